"""Are two runs equal? `python -m benchmarks.compare_runs BEFORE.json AFTER.json [options]`.

Compares the records that `shaderlab run … --json FILE` wrote, field by field, but for times; with
`--pictures BEFORE AFTER`, also the pictures of two `--report` folders, to the byte. Prints what
differs, a line for each field or file, and ends with exit status 1 if anything does.

Fields named by `--ignore` are left out wherever they stand. With `--some`, records and pictures
that only the first run has do not count: a run of a few cases is compared with one of all.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

IGNORED = frozenset({"seconds", "timings"})
# What the table of a `cost` says of the clock; calls and vertices beside it do count.
_TIMES = re.compile(
    r"\d+(\.\d+)? (ms|µs|s|×)|\d+\.\d+(?= at )|(holds|does not hold) on this driver[^\"]*"
)
_MOST = 40

Records = Mapping[str, Mapping[str, Any]]


def main(arguments: list[str] | None = None) -> int:
    """Compare, print, and return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--pictures", nargs=2, type=Path, metavar=("BEFORE", "AFTER"))
    parser.add_argument("--ignore", action="append", default=[], metavar="FIELD")
    parser.add_argument("--some", action="store_true")
    asked = parser.parse_args(arguments)

    before, after = records(asked.before), records(asked.after)
    if asked.some:
        before = {key: record for key, record in before.items() if key in after}
    found = list(differences(before, after, IGNORED | set(asked.ignore)))
    counted = f"{len(after)} records"
    if asked.pictures:
        folders = [folder / "images" for folder in asked.pictures]
        cases = {key.partition(" ")[0] for key in after} if asked.some else None
        found += picture_differences(*folders, cases=cases)
        counted += f", {len(pictures(folders[1], cases))} pictures"
    for line in found[:_MOST]:
        print(line)
    if len(found) > _MOST:
        print(f"… and {len(found) - _MOST} more")
    print(f"{counted}: " + (f"{len(found)} differences" if found else "equal"))
    return 1 if found else 0


def records(file: Path) -> Records:
    """The records of a `--json` file by "id variant"."""
    cases = json.loads(file.read_text(encoding="utf-8"))["cases"]
    return {f"{record['id']} {record['variant']}": record for record in cases}


def differences(
    before: Records, after: Records, ignored: Collection[str] = IGNORED
) -> Iterator[str]:
    """A line for each field in which two runs' records differ, and for each missing record.

    >>> one = {"a default": {"status": "pass", "seconds": 1.0}}
    >>> list(differences(one, {"a default": {"status": "fail", "seconds": 2.0}}))
    ['a default: status: "pass" → "fail"']
    """
    for key in sorted({*before, *after}):
        if key not in after:
            yield f"{key}: only in the first run"
        elif key not in before:
            yield f"{key}: only in the second run"
        else:
            yield from _differences(before[key], after[key], f"{key}: ", ignored)


def pictures(folder: Path, cases: Collection[str] | None = None) -> dict[str, Path]:
    """The files of a report's folder of images by name; of `cases` alone, if they are given."""
    return {
        file.name: file
        for file in sorted(folder.iterdir())
        if cases is None or file.name.partition("--")[0] in cases
    }


def picture_differences(
    before: Path, after: Path, *, cases: Collection[str] | None = None
) -> Iterator[str]:
    """A line for each picture that only one folder has, or that differs in any byte."""
    old, new = pictures(before, cases), pictures(after, cases)
    for name in sorted({*old, *new}):
        if name not in new:
            yield f"{name}: only in the first report"
        elif name not in old:
            yield f"{name}: only in the second report"
        elif old[name].read_bytes() != new[name].read_bytes():
            yield f"{name}: differs"


def _differences(before: Any, after: Any, place: str, ignored: Collection[str]) -> Iterator[str]:
    if isinstance(before, dict) and isinstance(after, dict):
        if before.get("kind") == after.get("kind") == "cost":
            before, after = _without_times(before), _without_times(after)
        for name in sorted({*before, *after} - set(ignored)):
            inside = f"{place}{name}: "
            if name in before and name in after:
                yield from _differences(before[name], after[name], inside, ignored)
            else:
                yield f"{inside}only in the {'first' if name in before else 'second'} run"
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for index, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from _differences(one, other, f"{place}[{index}] ", ignored)
    elif before != after:
        yield f"{place}{_shown(before)} → {_shown(after)}"


def _without_times(cost: dict[str, Any]) -> dict[str, Any]:
    rows = json.loads(_TIMES.sub("…", json.dumps(cost["values"], ensure_ascii=False)))
    return {**cost, "kind": "", "values": rows}


def _shown(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:59] + "…"


if __name__ == "__main__":
    sys.exit(main())
