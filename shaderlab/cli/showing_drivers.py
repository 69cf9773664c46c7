"""How `shaderlab run --drivers` shows where drivers agree."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rich.console import Console
from rich.text import Text

from shaderlab.cli.rows import plain_table
from shaderlab.model.records import Disagreement, DriverResult, Run
from shaderlab.report.drivers import AGREEMENTS, driver_table
from shaderlab.report.plain_text import label, printable

_STYLES = {"✓": "green", "–": "yellow", "✗": "red"}
_MOST = 40


def show_drivers(run: Run, console: Console) -> None:
    """A table of cases and drivers, why a driver did not pass, and what lies outside of a band;
    nothing for a run on one driver."""
    table = driver_table(run, {})
    if table is None:
        return
    names = [name for name, _ in table.drivers]
    shown = plain_table("case", "variants", *names, right={"variants"}, whole={"case", *names})
    for case_id, count, cells in table.by_case():
        texts = (Text(cell, _STYLES.get(cell[0], "")) for cell in cells)
        shown.add_row(Text(printable(case_id)), Text(str(count)), *texts)
    console.print()
    console.print(shown)
    console.print()
    total = table.outputs.total()
    for verdict, words in AGREEMENTS.items():
        console.print(f"{table.outputs[verdict]} of {total} outputs: {words}")
    for result, labels in _alike(run.drivers):
        style = "yellow" if result.status == "unsupported" else "red"
        head = f"{result.status} on {result.driver}: {', '.join(labels)}"
        console.print(printable("\n  ".join([head, *result.message.splitlines()])), style=style)
    outside = [each for each in table.apart if each.verdict == "outside"]
    for each in outside[:_MOST]:
        console.print(printable(_line(each)))
    if len(outside) > _MOST:
        console.print(f"… and {len(outside) - _MOST} more")


def _alike(results: Iterable[DriverResult]) -> Iterator[tuple[DriverResult, list[str]]]:
    """What did not pass: one result and the scenes of all that say the same."""
    found: dict[tuple[str, str, str], list[DriverResult]] = {}
    for result in results:
        if result.status != "pass":
            found.setdefault((result.driver, result.status, result.message), []).append(result)
    for alike in found.values():
        yield alike[0], [label(result.id, result.variant) for result in alike]


def _line(each: Disagreement) -> str:
    name = f"{label(each.id, each.variant)}: {each.output}"
    pair = " | ".join(each.drivers)
    return (
        f"{name}  {pair}: {each.differing} of {each.pixels} pixels differ, by {each.ulp:.4g} ULP "
        f"at most; outside on {', '.join(each.outside)}"
    )
