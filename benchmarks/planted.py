"""Mistakes planted at the edges of small functions: what `glsl.given` finds, and how small.

    python -m benchmarks.planted [--only NAME]

`planted.toml` has the functions. Of each mistake: seconds until it is found and made small, and how
many of its inputs are still neither 0, 1, −1 nor an end of their domain. The right versions must
raise no alarm.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab import glsl
from shaderlab.functions.properties import Floats, Ints

DATA = Path(__file__).with_suffix(".toml")
TRIVIAL = (0.0, 1.0, -1.0)


@dataclass(frozen=True)
class Planted:
    """A function, right (as a rewrite, it may be) or with one mistake, and the property that tells
    which."""

    name: str
    text: str
    domains: str
    property: str
    result: str = "y"
    bug: str = ""
    rewrite: str = ""

    def test(self) -> Any:
        """A test of the property, as people write it."""
        names = {"glsl": glsl, "np": np, "f": glsl.load(self.text)[self.name]}
        names |= {n: getattr(glsl, n) for n in ("floats", "ints")}
        parameters = ", ".join(p.name for p in names["f"].signatures[0].given)
        code = (
            f"@glsl.given(f, {self.domains})\n"
            f"def test_{self.name}({parameters}, {self.result}):\n"
            f"    return {self.property}\n"
        )
        exec(compile(code, __file__, "exec"), names)
        return names[f"test_{self.name}"]

    def limits(self) -> dict[str, Any]:
        """The domains by name."""
        found: dict[str, Any] = eval(f"dict({self.domains})", {"floats": Floats, "ints": Ints})
        return found


@dataclass(frozen=True)
class Found:
    """How a search ended: whether anything failed, when, and the inputs that failed."""

    failed: bool
    seconds: float
    inputs: dict[str, Any]

    def nontrivial(self, planted: Planted) -> int:
        """How many numbers of the inputs are not 0, 1, −1 or an end of their domain."""
        count = 0
        for name, value in self.inputs.items():
            domain = planted.limits()[name]
            simple = np.float32([*TRIVIAL, domain.low, domain.high])
            count += int((~np.isin(np.float32(value), simple)).sum())
        return count


def planted() -> Iterator[Planted]:
    """Each function, right, written in other right ways, then with each of its mistakes."""
    for entry in tomllib.loads(DATA.read_text(encoding="utf-8"))["functions"]:
        rewrites, bugs = entry.pop("rewrites"), entry.pop("bugs")
        right = Planted(**entry)
        yield right
        for change in rewrites:
            yield replace(right, text=_changed(right, change), rewrite=change)
        for bug in bugs:
            yield replace(right, text=_changed(right, bug), bug=bug)


def _changed(right: Planted, change: str) -> str:
    old, new = change.split(" => ")
    assert old in right.text, f"{right.name}: no {old!r}"
    return right.text.replace(old, new)


def search(one: Planted) -> Found:
    """Run the test."""
    test = one.test()
    began = time.perf_counter()
    try:
        test()
    except AssertionError as error:
        seconds = time.perf_counter() - began
        text = "\n".join([str(error), *getattr(error, "__notes__", ())])
        line = next(row for row in text.splitlines() if row.startswith("@glsl.example("))
        values = eval(line.removeprefix("@glsl.example").join(["dict", ""]), {"nan": np.nan})
        return Found(True, seconds, values)
    return Found(False, time.perf_counter() - began, {})


def main() -> None:
    """Search all, and print a line for each and the sums."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="one function's name")
    only = parser.parse_args().only
    rows = [(one, search(one)) for one in planted() if only in (None, one.name)]
    for one, found in rows:
        what = f"{one.name}: {one.bug or one.rewrite or 'right'}"
        if found.failed:
            print(f"{found.seconds:5.2f} s  {found.nontrivial(one)}  {what}  {found.inputs}")
        else:
            print(f"{found.seconds:5.2f} s  –  {what}")
    wrong = [(o, f) for o, f in rows if o.bug]
    right = [(o, f) for o, f in rows if not o.bug]
    small = sum(f.failed and f.nontrivial(o) <= 2 for o, f in wrong)
    quick = sum(f.failed and f.seconds < 1.0 for _, f in wrong)
    print(
        f"{sum(f.failed for _, f in wrong)} of {len(wrong)} mistakes found, {quick} in less than "
        f"1 s, {small} with at most two numbers that are not trivial; "
        f"{sum(f.failed for _, f in right)} alarms on {len(right)} right versions"
    )


if __name__ == "__main__":
    main()
