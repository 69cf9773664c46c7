"""Which lines and branches of shaders ran, as LCOV's tracefile (geninfo(1)), for coverage services.

Of each file it has the lines with code, with how many programs ran them, each variant's apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest

from shaderlab.errors import UsageError
from shaderlab.files import display_path
from shaderlab.model.records import Run

Lines = dict[int, tuple[int, list[int]]]
"""By number, how often a line ran, and each way of its branches."""


def render(run: Run) -> str:
    """A run as a tracefile. Raises UsageError: it did not look at all pixels of its shaders."""
    files: dict[str, Lines] = {}
    for record in run.records:
        for one in record.modules.coverage if record.modules else ():
            lines = files.setdefault(display_path(one.file), {})
            count, ways = lines.get(one.line, (0, []))
            ways = [a + b for a, b in zip_longest(ways, one.branches, fillvalue=0)]
            lines[one.line] = count + one.was_run, ways
    if run.records and not files:
        raise UsageError("the run has no coverage of shaders", remedy="run with --modules")
    return "".join(f"{row}\n" for file in sorted(files) for row in _rows(file, files[file]))


def _rows(file: str, lines: Lines) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{file}"
    for line, (count, ways) in sorted(lines.items()):
        for number, way in enumerate(ways):
            yield f"BRDA:{line},0,{number},{way if count else '-'}"
        yield f"DA:{line},{count}"
    ways = [way for _, each in lines.values() for way in each]
    for name, counts in (("BR", ways), ("L", [count for count, _ in lines.values()])):
        yield f"{name}F:{len(counts)}"
        yield f"{name}H:{sum(count > 0 for count in counts)}"
    yield "end_of_record"
