"""What a case costs on each driver, side by side.

    python -m benchmarks.drivers [--drivers llvmpipe,lavapipe,…] [--size 256] [CASE…]

Each case is run twice on each driver, in one process that has its device open; the second time
counts, when programs are compiled and linked. Cases that a driver does not pass have no figure,
and the median is of those that all of them pass. Drawing is what `timings` calls link, draw,
capture and read; the rest of the time is spent on bands, the same for all.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Mapping, Sequence

from benchmarks.shipped import load_cases
from shaderlab.drivers import DRIVERS
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import RunOptions

CASES = (
    "attenuation", "mvp", "ten-cubes", "mipmap-chain", "cubemap", "stencil-outline",
    "transparency-order", "hdr", "pbr", "deferred-shading",
)  # fmt: skip
_DRAWING = ("link", "draw", "capture", "read")
Cost = tuple[float, float]


def costs(driver: str, size: int, names: Sequence[str]) -> tuple[float, Mapping[str, Cost]]:
    """Seconds to open a driver, and for each case that passes all and those of drawing."""
    known, found = load_cases(), {}
    with SceneRunner(RunOptions(size=size, driver=driver, pictures=False)) as lab:
        started = time.perf_counter()
        assert lab.backend
        opened = time.perf_counter() - started
        for name in names:
            scene = next(iter(known[name].scenes()))
            first, record = lab.run(scene), lab.run(scene)
            if (first.status, record.status) == ("pass", "pass"):
                drawing = sum(record.timings.get(part, 0.0) for part in _DRAWING)
                found[name] = (record.seconds, drawing)
    return opened, found


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("cases", nargs="*", default=CASES)
    options.add_argument("--drivers", default=",".join(d for d in DRIVERS if d != "default"))
    options.add_argument("--size", type=int, default=256)
    given = options.parse_args()
    opened: dict[str, float] = {}
    all_costs: dict[str, Mapping[str, Cost]] = {}
    for driver in given.drivers.split(","):
        try:
            opened[driver], all_costs[driver] = costs(driver, given.size, given.cases)
        except ShaderlabError as error:
            print(f"{driver}: {error.message}")
    shared = [name for name in given.cases if all(name in own for own in all_costs.values())]
    print("| seconds: all, drawing | " + " | ".join(all_costs) + " |")
    print("|---" * (len(all_costs) + 1) + "|")
    for name in given.cases:
        print(_row(name, [own.get(name) for own in all_costs.values()]))
    if shared:
        print(_row(f"median of {len(shared)}", [
            tuple(statistics.median(own[name][part] for name in shared) for part in range(2))
            for own in all_costs.values()
        ]))  # fmt: skip
    print("| opening | " + " | ".join(f"{seconds:.2f}" for seconds in opened.values()) + " |")


def _row(name: str, figures: Sequence[Sequence[float] | None]) -> str:
    cells = ["–" if one is None else f"{one[0]:.2f}, {one[1]:.2f}" for one in figures]
    return f"| {name} | " + " | ".join(cells) + " |"


if __name__ == "__main__":
    main()
