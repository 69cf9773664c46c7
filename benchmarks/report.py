"""How long a report takes to make and to open, how much memory and how many bytes it needs.

    python -m benchmarks.report                 made-up runs of 100, 300 and 1000 records
    python -m benchmarks.report reports/latest  a run of your own

Each record has a picture of 512 × 512, and two checks with three pictures and the numbers of
64 × 64 pixels, of one and of four components; four records share a case. How long pages take to
open is measured in headless Chromium where there is one, from the first request to the end of the
load event: the front page, the median and the largest of the cases' pages.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

MAKE = """
import json, resource, sys, time
from shaderlab.report.html import write
from shaderlab.model.store import load
began = time.perf_counter()
run = load(sys.argv[1])
loaded = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
page = write(run, sys.argv[1])
cases = sorted((page.parent / "cases").iterdir(), key=lambda path: path.stat().st_size)
print(json.dumps({
    "seconds": time.perf_counter() - began,
    "loaded": loaded / 1024,
    "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    "records": len(run.records),
    "cases": len({record.id for record in run.records}),
    "front": page.stat().st_size,
    "bytes": sum(path.stat().st_size for path in cases),
    "pages": [str(page), str(cases[len(cases) // 2]), str(cases[-1])],
}))
"""


COUNTS = (100, 300, 1000)


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, nargs="?", help="a run's folder, not made-up records")
    run: Path | None = parser.parse_args().run
    print(
        "records  cases  make (s)  peak memory (MB)  after load (MB)  "
        "front (kB)  cases (MB)  opens (s)"
    )
    if run is not None:
        _measure(run)
        return
    for count in COUNTS:
        folder = Path(tempfile.mkdtemp(prefix="shaderlab-report-"))
        try:
            _made_up(folder, count)
            _measure(folder)
        finally:
            shutil.rmtree(folder)


def _measure(folder: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", MAKE, str(folder)], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    opened = [_opening(Path(page)) for page in found["pages"]]
    print(
        f"{found['records']:7} {found['cases']:6} {found['seconds']:9.1f} {found['peak']:17.0f} "
        f"{found['loaded']:16.0f} {found['front'] / 1e3:11.0f} {found['bytes'] / 1e6:11.1f}  "
        f"{' '.join('–' if time is None else format(time, '.2f') for time in opened)}",
        flush=True,
    )


def _opening(page: Path) -> float | None:
    """Seconds until the page is loaded, the least of three times; None without a browser."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        return None
    from tests.browser.conftest import FLAGS, find_chromium

    path = find_chromium()
    if path is None:
        return None
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=FLAGS)
        times = []
        for _ in range(3):
            tab = browser.new_page()
            tab.goto(page.resolve().as_uri(), timeout=120_000)
            times.append(
                tab.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd / 1000")
            )
            tab.close()
        browser.close()
    return min(times)


def _made_up(folder: Path, count: int) -> None:
    import numpy as np

    from shaderlab.engine.pictures import PictureWriter
    from shaderlab.errors import Verdict
    from shaderlab.model.frame import Image
    from shaderlab.model.records import ProgramRecord, SourceText
    from shaderlab.model.store import save
    from tests.unit.test_report_samples import curve, outcome, record, run, worst

    generator = np.random.default_rng(7)
    y, x = np.mgrid[0:512, 0:512] / 512
    outcomes, template = [], PictureWriter(folder, "made-up", "first")
    shown = template.write_picture(Image(np.stack([x, y, x * y], -1).astype("f4"), "rgba32f"))
    for components in (1, 4):
        exact = np.sqrt((x + y)[::8, ::8, None] + np.arange(components) / 7 + 0.1)
        measured = (exact * (1 + generator.uniform(-4, 4, exact.shape) * 2**-24)).astype("f4")
        arrays = {
            "measured": measured, "reference": exact, "exact": exact,
            "low": (exact * (1 - 2**-20)).astype("f4"), "high": (exact * (1 + 2**-20)).astype("f4"),
            "distance": np.zeros((64, 64)), "covered": np.ones((64, 64), bool),
            "outside": np.zeros(exact.shape, bool), "unit": np.float64(0),
        }  # fmt: skip
        seen = template.write_comparison(str(components), arrays)
        outcomes.append(
            outcome(worst=worst(), images=seen.files, captions=seen.captions, values=seen.values)
        )
    files = [*shown.files.values(), *(f for o in outcomes for f in (*o.images.values(), o.values))]
    records = []
    for number in range(count):
        case, variant = f"case-{number // 4}", str(number % 4)
        text = "#version 330 core\n" + f"uniform float u{number // 4};\n" * 40
        source = SourceText(file=f"{case}.frag", line=1, language="glsl", text=text)
        verdicts = tuple(Verdict(target=t, ok=True) for t in ("glsl", "opengl", "vulkan"))
        for file in files:  # each record has files of its own, as in a real run
            for part in folder.glob(file.replace(".png", "*.png")):
                _copy(part, part.with_name(f"{number}-{part.name}"))
        own = {f: f.replace("images/", f"images/{number}-") for f in files}
        records.append(
            record(
                case,
                variant,
                images={k: own[f] for k, f in shown.files.items()},
                curves=(curve(title=f"{case} {variant}"),),
                programs=(
                    ProgramRecord(files=(source.file,), sources=(source,), verdicts=verdicts),
                ),
                expectations=tuple(
                    replace(
                        o, images={k: own[f] for k, f in o.images.items()}, values=own[o.values]
                    )
                    for o in outcomes
                ),
            )
        )
    save(run(*records), folder)


def _copy(source: Path, goal: Path) -> None:
    if not goal.exists():
        shutil.copyfile(source, goal)


if __name__ == "__main__":
    began = time.perf_counter()
    main()
    print(f"measured in {time.perf_counter() - began:.0f} s")
