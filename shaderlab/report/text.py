"""Numbers, names and records as people read them: on a page, in a shell, in pytest, in JUnit XML.

Strings from shaders, cases and drivers are made fit for where they are shown.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from textwrap import indent
from typing import TYPE_CHECKING

from shaderlab.errors import Diagnostic, significant
from shaderlab.files import display_path
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.model.records import Outcome, Record, Run, Status, Worst

# C0 and C1 controls (but tab and line ends), lone surrogates, and XML's two non-characters.
_UNPRINTABLE = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
# Characters that reorder or hide what is around them, so that code reads as it does not run.
_HIDING = re.compile(r"[\u200b\u200e\u200f\u2028-\u202e\u2060-\u2069\ufeff]")
DEFAULT_VARIANT = "default"
MARKS: Mapping[Status, str] = {
    "pass": "✓", "fail": "✗", "error": "✗", "crash": "✗", "timeout": "✗", "unsupported": "–",
}  # fmt: skip
MOST_ROWS = 12
MOST_DIAGNOSTICS = 10


def clean(text: object) -> str:
    """Return `text` without what XML and HTML can't hold, and with hidden characters made visible.

    >>> clean("a\\x1bb\\u202ec")
    'a\ufffdb[U+202E]c'
    """
    if type(text) is str and text.isprintable():
        return text  # as most texts are; what has to be replaced is not printable
    shown = _UNPRINTABLE.sub("\ufffd", str(text).replace("\r\n", "\n").replace("\r", "\n"))
    return _HIDING.sub(lambda match: f"[U+{ord(match.group()):04X}]", shown)


def figure(value: float) -> str:
    """Format a float in at most nine digits, enough to tell any two 32-bit floats apart."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return significant(value).replace("-", "−")


def short(value: float) -> str:
    """Format a float in three digits, for distances and shares.

    >>> short(0.41234), short(1234.5), short(0.0)
    ('0.412', '1230', '0')
    """
    if not math.isfinite(value):
        return figure(value)
    size = abs(value)
    if value and (size < 1e-3 or size >= 1e6):
        return f"{value:.2e}".replace("-", "−")
    if size >= 100:
        return f"{float(f'{value:.3g}'):.0f}".replace("-", "−")
    return f"{value:.3g}".replace("-", "−")


def count(number: int) -> str:
    """Format an integer with thin spaces between thousands.

    >>> count(1234567)
    '1\u202f234\u202f567'
    """
    return f"{number:,}".replace(",", "\u202f")


def plural(number: int, one: str, many: str = "") -> str:
    """Format a number with its noun.

    >>> plural(1, "case"), plural(2, "case"), plural(2, "query", "queries")
    ('1 case', '2 cases', '2 queries')
    """
    return f"{count(number)} {one if number == 1 else many or one + 's'}"


def duration(seconds: float) -> str:
    """Format seconds in the unit that reads best.

    >>> duration(0.0042), duration(3.14159), duration(125)
    ('4.2 ms', '3.1 s', '2 min 5 s')
    """
    if not math.isfinite(seconds):
        return figure(seconds)
    if seconds < 1:
        return f"{short(round(seconds * 1000, 1))} ms"
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{int(seconds // 60)} min {int(seconds % 60)} s"


def share(fraction: float) -> str:
    """Format a share of 0…1 in percent; never 0 % or 100 % unless it is exactly that.

    >>> share(0.0), share(0.00001), share(0.5), share(0.99999)
    ('0 %', '<0.1 %', '50 %', '>99.9 %')
    """
    if not math.isfinite(fraction):
        return figure(fraction)
    if 0 < fraction < 0.001:
        return "<0.1 %"
    if 0.999 < fraction < 1:
        return ">99.9 %"
    return f"{fraction * 100:.3g} %"


def day(started: str) -> str:
    """Format an ISO date and time as "21 November 2026, 10:33 UTC"; anything else as it is."""
    try:
        moment = datetime.fromisoformat(started)
    except ValueError:
        return started
    zone = f" {moment.tzname()}" if moment.tzinfo else ""
    return f"{moment.day} {moment:%B %Y, %H:%M}{zone}"


def slug(name: str) -> str:
    """Return `name` as part of an anchor: letters, digits and hyphens.

    >>> slug("d = 50 (notes)")
    'd-50-notes'
    """
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "x"


class Anchors:
    """Makes anchors, never one twice."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._numbers: Counter[str] = Counter()

    def short(self) -> str:
        """Return a short anchor, for listings that repeat it in each line."""
        self._numbers["s"] += 1
        return self.new(f"s{self._numbers['s']}")

    def new(self, *parts: str) -> str:
        """Return an anchor that begins with the slugs of `parts`."""
        wanted = anchor = "-".join(slug(part) for part in parts)
        while anchor in self._taken:
            self._numbers[wanted] += 1
            anchor = f"{wanted}-{self._numbers[wanted] + 1}"
        self._taken.add(anchor)
        return anchor


def format_label(case_id: str, variant: str) -> str:
    """Return the name of a variant: `attenuation[50]`, or `gamma` for a case without variants."""
    return clean(case_id if variant == DEFAULT_VARIANT else f"{case_id}[{variant}]")


def has_failed(record: Record) -> bool:
    """Whether a record makes a run fail; lacking a feature of the driver does not."""
    return record.status not in ("pass", "unsupported")


def format_diagnostic(found: Diagnostic) -> str:
    """`file:line: error: message`, the form that editors jump from."""
    return f"{display_path(found.file, found.line)}: {found.severity}: {found.message}"


def format_failure(record: Record) -> list[str]:
    """Return the lines of a record that did not pass, the most important first."""
    lines = [f"{MARKS[record.status]} {format_label(record.id, record.variant)} · {record.title}"]
    lines += [f"  {display_path(record.file)}"] if record.file else []
    if record.status not in ("fail", "pass"):
        status = f"{record.status}: {record.message}" if record.message else record.status
        lines += indent(status, "  ").splitlines()
    elif not any(o.message and o.message in record.message for o in record.expectations):
        lines += indent(record.message, "  ").splitlines()
    lines += _format_refusals(record)
    for outcome in record.expectations:
        if outcome.status != "pass":
            lines += ["", f"  {MARKS[outcome.status]} {outcome.name} ({outcome.kind})"]
            lines += [f"    {line}" for line in format_outcome(outcome)]
    return [clean(line) for line in lines]


def _format_refusals(record: Record) -> Iterator[str]:
    """The compilers' messages, each once: several targets often give the same one."""
    seen: set[str] = set()
    for program in record.programs:
        for verdict in program.verdicts:
            if verdict.ok:
                continue
            messages = [format_diagnostic(d) for d in verdict.diagnostics if d.severity == "error"]
            new = [line for line in messages if line not in seen]
            seen.update(new)
            if new or not messages:
                yield f"  refused as {verdict.target}:"
                yield from (f"    {line}" for line in new[:MOST_DIAGNOSTICS])


def format_outcome(outcome: Outcome) -> Iterator[str]:
    """Yield why an expectation does not hold: message, worst value, wrong rows, sources."""
    if outcome.message:
        yield from outcome.message.splitlines()
    elif outcome.judged:
        yield f"{outcome.outside} of {outcome.judged} values outside"
    if outcome.worst is not None:
        yield from _format_worst(outcome.worst)
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


def _format_worst(worst: Worst) -> Iterator[str]:
    where = "worst value"
    if worst.pixel is not None:
        where = f"worst pixel ({worst.pixel[0]}, {worst.pixel[1]})"
    if len(worst.measured) > 1:
        number = f"{worst.component + 1} of {len(worst.measured)}"
        where += f", component {'rgba'[worst.component] if len(worst.measured) <= 4 else number}"
    yield f"{where}: {_format_distance(worst)}"
    yield f"  measured   {format_numbers(worst.measured)}"
    yield f"  reference  {format_numbers(worst.reference)}"
    yield f"  band       {_format_bands(worst.low, worst.high)}"
    for name, values in worst.inputs.items():
        yield f"  {name} = {format_numbers(values)}"


def _format_distance(worst: Worst) -> str:
    if math.isnan(worst.widths):
        return "not a number"
    if worst.whole:
        return f"{worst.ulp:.0f} from the reference"
    low, high = worst.low[worst.component], worst.high[worst.component]
    if low == high:
        return f"{abs(worst.measured[worst.component] - low):.3g} from the exact value"
    ulp = "" if math.isnan(worst.ulp) else f" and {worst.ulp:.3g} ulp"
    return f"{worst.widths:.3g} half band widths{ulp} from the reference"


def format_numbers(values: Sequence[float]) -> str:
    """Format a number, or a vector in parentheses, in the nine digits that tell float32s apart."""
    shown = [significant(float(value)) for value in values]
    return shown[0] if len(shown) == 1 else f"({', '.join(shown)})"


def _format_bands(low: Sequence[float], high: Sequence[float]) -> str:
    pairs = zip(map(significant, low), map(significant, high), strict=True)
    return ", ".join(f"[{least}, {most}]" for least, most in pairs)


def format_unread(records: Iterable[Record]) -> Iterator[str]:
    """Yield a line for each case with outputs that no check reads."""
    found: dict[str, dict[str, None]] = {}
    for record in records:
        if record.unread:
            found.setdefault(record.id, {}).update(dict.fromkeys(record.unread))
    for case_id, outputs in found.items():
        yield clean(f"{case_id}: no check reads {', '.join(outputs)}")


def format_gl_calls(record: Record) -> Iterator[str]:
    """Yield a record's calls of OpenGL, below a line for each pass and draw."""
    for part in record.gl_calls:
        what = "its target" if part.draw is None else f"draw {part.draw}"
        yield clean(f"{record.id}[{record.variant}], pass {part.pass_name!r}, {what}:")
        yield from (clean(f"  {call}") for call in part.calls)


def format_conditions(run: Run) -> Iterator[str]:
    """Yield a line for each thing that makes a run another one than its cases were written for.

    That is a file in a shader's place, and another size where something failed.
    """
    for name, file in run.replaced.items():
        yield clean(f"{file} was judged in place of {name}")
    usual = RunOptions.size
    sizes = {record.size for record in run.records if has_failed(record)} - {0, usual}
    for size in sorted(sizes):
        yield (
            f"judged at {size} × {size} pixels, not at {usual} × {usual}: numbers of pixels and "
            "figures that are measured on them belong to a size, so what failed may have failed "
            "for that alone; run it without --size, or give the target of the case a size"
        )


def format_summary(run: Run) -> str:
    """Return `12 cases, 42 variants: 40 passed, 2 failed in 3.1 s`."""
    return f"{format_tally(run.records, run.missing)} in {run.seconds:.1f} s"


def format_tally(records: Iterable[Record], missing: int = 0) -> str:
    """Return a summary without the time."""
    some = list(records)
    cases = len({(record.id, record.file) for record in some})
    count = plural(cases, "case") + f", {plural(len(some), 'variant')}" * (len(some) != cases)
    left = [len(r.not_asked) for r in some if r.status == "pass" and r.not_asked]
    without = ""
    if left:
        without = f" ({len(left)} of them without {sum(left)} checks of OpenGL's own calls)"
    counts = Counter(record.status for record in some)
    words = {"pass": f"passed{without}", "fail": "failed", "error": "in error", "crash": "crashed"}
    parts = [f"{counts[s]} {words.get(s, s)}" for s in MARKS if counts.get(s)]
    parts += [f"{missing} not run"] if missing else []
    return f"{count}: {', '.join(parts) or 'nothing run'}"
