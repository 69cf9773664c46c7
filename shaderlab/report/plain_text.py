"""Records as lines of plain text: failures look alike in a shell, in pytest and in JUnit XML."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import indent

from shaderlab.files import display_path
from shaderlab.model.options import RunOptions
from shaderlab.model.records import (
    CodeCoverage,
    Diagnostic,
    Outcome,
    Record,
    Run,
    Status,
    Worst,
    significant,
)
from shaderlab.report.text import count

DEFAULT_VARIANT = "default"
MARKS: Mapping[Status, str] = {
    "pass": "✓",
    "fail": "✗",
    "error": "✗",
    "crash": "✗",
    "timeout": "✗",
    "unsupported": "–",
}
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")
MOST_ROWS = 12
MOST_DIAGNOSTICS = 10


def label(case_id: str, variant: str) -> str:
    """The name of a variant: `attenuation[50]`, or `gamma` for a case without variants."""
    return case_id if variant == DEFAULT_VARIANT else f"{case_id}[{variant}]"


def failed(record: Record) -> bool:
    """Whether a record makes a run fail; lacking a feature of the driver does not."""
    return record.status not in ("pass", "unsupported")


def diagnostic_line(found: Diagnostic) -> str:
    """`file:line: error: message`, the form that editors jump from."""
    return f"{display_path(found.file, found.line)}: {found.severity}: {found.message}"


def printable(text: str) -> str:
    """The text without characters that could steer a terminal."""
    return _CONTROLS.sub("\ufffd", text)


def failure(record: Record) -> list[str]:
    """Everything about a record that did not pass, the most important first."""
    lines = [f"{MARKS[record.status]} {label(record.id, record.variant)} · {record.title}"]
    lines += [f"  {display_path(record.file)}"] if record.file else []
    if record.status not in ("fail", "pass"):
        said = f"{record.status}: {record.message}" if record.message else record.status
        lines += indent(said, "  ").splitlines()
    elif record.message and not _said_below(record):
        lines += indent(record.message, "  ").splitlines()
    lines += _refusals(record)
    for outcome in record.expectations:
        if outcome.status != "pass":
            lines += ["", f"  {MARKS[outcome.status]} {outcome.name} ({outcome.kind})"]
            lines += [f"    {line}" for line in outcome_details(outcome)]
    return [printable(line) for line in lines]


def _said_below(record: Record) -> bool:
    """Whether the record's message only repeats that of an outcome."""
    return any(o.message and o.message in record.message for o in record.expectations)


def _refusals(record: Record) -> Iterator[str]:
    """The compilers' messages, each once: several targets often give the same one."""
    seen: set[str] = set()
    for program in record.programs:
        for verdict in program.verdicts:
            if verdict.ok:
                continue
            said = [diagnostic_line(d) for d in verdict.diagnostics if d.severity == "error"]
            new = [line for line in said if line not in seen]
            seen.update(new)
            if new or not said:
                yield f"  refused as {verdict.target}:"
                yield from (f"    {line}" for line in new[:MOST_DIAGNOSTICS])


def outcome_details(outcome: Outcome) -> Iterator[str]:
    """Why an expectation does not hold: message, worst value, wrong rows, sources."""
    if outcome.message:
        yield from outcome.message.splitlines()
    elif outcome.judged:
        yield f"{outcome.outside} of {outcome.judged} values outside"
    if outcome.worst is not None:
        yield from _worst(outcome.worst)
    if outcome.explanation is not None and outcome.explanation.verdict:
        yield outcome.explanation.verdict
    wrong = [row for row in outcome.rows if not row.ok]
    for row in wrong[:MOST_ROWS]:
        note = f" ({row.note})" if row.note else ""
        yield f"{row.label}: expected {row.expected}, measured {row.measured}{note}"
    if len(wrong) > MOST_ROWS:
        yield f"… and {len(wrong) - MOST_ROWS} more"
    for source in outcome.sources:
        what = "formula" if source.language == "python" else "shader"
        yield f"{what:<10} {display_path(source.file, source.line)}"


def _worst(worst: Worst) -> Iterator[str]:
    where = "worst value"
    if worst.pixel is not None:
        where = f"worst pixel ({worst.pixel[0]}, {worst.pixel[1]})"
    if len(worst.measured) > 1:
        number = f"{worst.component + 1} of {len(worst.measured)}"
        where += f", component {'rgba'[worst.component] if len(worst.measured) <= 4 else number}"
    yield f"{where}: {_distance(worst)}"
    yield f"  measured   {numbers(worst.measured)}"
    yield f"  reference  {numbers(worst.reference)}"
    yield f"  band       {_bands(worst.low, worst.high)}"
    for name, values in worst.inputs.items():
        yield f"  {name} = {numbers(values)}"


def _distance(worst: Worst) -> str:
    if math.isnan(worst.widths):
        return "not a number"
    if worst.whole:
        return f"{worst.ulp:.0f} from the reference"
    low, high = worst.low[worst.component], worst.high[worst.component]
    if low == high:
        return f"{abs(worst.measured[worst.component] - low):.3g} from the exact value"
    ulp = "" if math.isnan(worst.ulp) else f" and {worst.ulp:.3g} ulp"
    return f"{worst.widths:.3g} half band widths{ulp} from the reference"


def numbers(values: Sequence[float]) -> str:
    """A number, or a vector in parentheses, to the nine digits that tell float32 values apart."""
    shown = [significant(float(value)) for value in values]
    return shown[0] if len(shown) == 1 else f"({', '.join(shown)})"


def _bands(low: Sequence[float], high: Sequence[float]) -> str:
    return ", ".join(f"[{numbers([a])}, {numbers([b])}]" for a, b in zip(low, high, strict=True))


def unread(records: Iterable[Record]) -> Iterator[str]:
    """A line for each case with outputs that no check reads."""
    found: dict[str, dict[str, None]] = {}
    for record in records:
        if record.unread:
            found.setdefault(record.id, {}).update(dict.fromkeys(record.unread))
    for case_id, outputs in found.items():
        yield printable(f"{case_id}: no check reads {', '.join(outputs)}")


def coverage_lines(found: CodeCoverage) -> Iterator[str]:
    """How much of a case's shaders is exercised, then a line for each gap."""
    if found.message:
        yield printable(f"coverage of {found.id}: not measured, {found.message}")
        return
    yield printable(f"coverage of {found.id}: {found.items - len(found.gaps)} of {found.items}")
    for gap in found.gaps:
        yield printable(f"{gap.file}:{gap.line}: {gap.text} {gap.what}")


def gl_call_lines(record: Record) -> Iterator[str]:
    """A record's calls of OpenGL, below a line for each pass and draw."""
    for part in record.gl_calls:
        what = "its target" if part.draw is None else f"draw {part.draw}"
        yield printable(f"{record.id}[{record.variant}], pass {part.pass_name!r}, {what}:")
        yield from (printable(f"  {call}") for call in part.calls)


def conditions(run: Run) -> Iterator[str]:
    """A line for each thing that makes a run another one than its cases were written for: files
    that stood in a shader's place, and another size where something failed; and what of a sweep
    is not listed."""
    for name, file in run.replaced.items():
        yield printable(f"{file} was judged in place of {name}")
    usual = RunOptions.size
    sizes = {record.size for record in run.records if failed(record)} - {0, usual}
    for size in sorted(sizes):
        yield (
            f"judged at {size} × {size} pixels, not at {usual} × {usual}: numbers of pixels and "
            "figures that are measured on them belong to a size, so what failed may have failed "
            "for that alone; run it without --size, or give the target of the case a size"
        )
    if run.points is not None:
        yield listed(run)


def listed(run: Run) -> str:
    """Which points of a sweep its report lists, where there are more."""
    assert run.points is not None
    named = sum(map(failed, run.records))
    others = len(run.records) - named
    parts = []
    if bad := run.points.failed:
        of = "all" if named == bad else f"the {count(named)} worst of"
        parts.append(f"{of} {count(bad)} that did not pass")
    if others:
        parts.append(f"the {count(others)} worst of {count(run.points.count - bad)} that passed")
    return printable(
        f"{count(len(run.records))} of {count(run.points.count)} points are listed: "
        f"{' and '.join(parts) or 'none could be written'}; all are in {run.points.file}"
    )


def summary(run: Run) -> str:
    """`12 cases: 40 passed, 2 failed in 3.1 s`, counting variants, or the points of a sweep."""
    said = tally(run.records, run.missing)
    if run.points is not None:
        said = f"{run.points.count} points: {counted(run.points.statuses, run.missing)}"
    return f"{said} in {run.seconds:.1f} s"


def tally(records: Iterable[Record], missing: int = 0) -> str:
    """A `summary` without the time."""
    some = list(records)
    cases = {(record.id, record.file) for record in some}
    noun = "case" if len(cases) == 1 else "cases"
    left = [len(r.not_asked) for r in some if r.status == "pass" and r.not_asked]
    without = ""
    if left:
        without = f" ({len(left)} of them without {sum(left)} checks of OpenGL's own calls)"
    said = counted(Counter(record.status for record in some), missing, without)
    return f"{len(cases)} {noun}: {said}"


def counted(counts: Mapping[Status, int], missing: int, without: str = "") -> str:
    """`40 passed, 2 failed, 3 not run`; `without` goes after those that passed."""
    words = {"pass": f"passed{without}", "fail": "failed", "error": "in error", "crash": "crashed"}
    parts = [f"{counts[s]} {words.get(s, s)}" for s in MARKS if counts.get(s)]
    parts += [f"{missing} not run"] if missing else []
    return ", ".join(parts) or "nothing run"
