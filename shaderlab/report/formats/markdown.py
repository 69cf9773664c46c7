"""A run in a few lines of GitHub-flavoured Markdown, for a job's summary or a comment."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from itertools import groupby

from shaderlab.model.records import Outcome, Record, Run
from shaderlab.report import grouping, text
from shaderlab.report.comparison import AGREEMENTS, compare_drivers

_SIGNS = {"pass": "✅", "unsupported": "➖"}
# GitHub cuts summaries off at 1 MiB, and few people read this far.
_MOST_FAILURES = 50


def render(run: Run) -> str:
    """The verdict, a line a chapter, and what failed with its worst value.

    Every string from a shader, a case or a driver is escaped: none of it is markup.
    """
    cases = grouping.group_cases(run.records)
    totals = grouping.count_totals(run, cases)
    bad = totals.bad
    if not cases:
        verdict = "Nothing was run"
    elif bad:
        verdict = f"{text.count(bad)} of {text.plural(len(cases), 'case')} did not pass"
    elif totals.expectations and totals.cases["pass"]:
        verdict = f"{text.count(totals.cases['pass'])} of {text.plural(len(cases), 'case')} passed"
    else:
        verdict = "Nothing was checked"
    if run.missing:
        verdict += f", {text.plural(run.missing, 'variant')} not run: the run was interrupted"
    if run.failing_drivers and not bad:
        verdict += f", not all on {', '.join(run.failing_drivers)}"
    good = "✅" if totals.good else "➖"
    sign = "❌" if bad or run.failing_drivers else "⚠️" if run.missing else good
    lines = [f"## {sign} {verdict}", ""]
    lines += [f"{escape(line)}  " for line in text.format_conditions(run)]
    lines.append(
        f"{text.plural(totals.judged, 'value')} judged, "
        f"{text.count(totals.outside)} outside their band · "
        f"{text.plural(totals.variants.total(), 'variant')} · {text.duration(run.seconds)} · "
        f"{escape(run.driver.get('renderer', 'no driver'))}"
    )
    if totals.not_asked:
        lines.append(
            f"  \n{text.plural(totals.not_asked, 'check')} of OpenGL's own calls skipped on this "
            f"driver; {text.plural(totals.partly, 'case')} passed without them"
        )
    if cases:
        lines += ["", *_chapters(cases)]
    failed = [r for case in cases for r in case.records if r.status not in grouping.PASSABLE]
    if failed:
        lines += ["", "### Failures", ""]
        for record in failed[:_MOST_FAILURES]:
            lines += _failure(record)
        if len(failed) > _MOST_FAILURES:
            lines.append(f"- and {text.plural(len(failed) - _MOST_FAILURES, 'more variant')}")
    lines += _drivers(run)
    unjudged = list(text.format_unread(run.records))
    if unjudged:
        lines += ["", "### Outputs that no check reads", ""]
        lines += [f"- {escape(line)}" for line in unjudged[:_MOST_FAILURES]]
        if len(unjudged) > _MOST_FAILURES:
            lines.append(f"- and {text.plural(len(unjudged) - _MOST_FAILURES, 'more case')}")
    return "\n".join(lines) + "\n"


def escape(words: str) -> str:
    """One line of text with nothing in it that Markdown, HTML or GitHub would act upon.

    >>> escape("a|b <i> @x *y*")
    'a\\\\|b &lt;i&gt; &#64;x \\\\*y\\\\*'
    """
    line = " ".join(text.clean(words).split())
    line = line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    line = re.sub(r"([\\`*_{}\[\]()#+!|~$-])", r"\\\1", line)
    # Mentions and links are made of plain text too.
    return line.replace("@", "&#64;").replace("://", "&#58;//").replace("www.", "www&#46;")


def _chapters(cases: list[grouping.CaseGroup]) -> Iterable[str]:
    present = [s for s in reversed(grouping.STATUSES) if any(case.status == s for case in cases)]
    yield "| Chapter | " + " | ".join(grouping.STATUS_WORDS[status] for status in present) + " |"
    yield "|---" * (len(present) + 1) + "|"
    for (number, name), members in groupby(cases, lambda case: case.chapter):
        counted = Counter(case.status for case in members)
        title = f"{number} {escape(name)}" if number else name
        yield f"| {title} | " + " | ".join(str(counted[s] or "") for s in present) + " |"


def _drivers(run: Run) -> Iterable[str]:
    """A table of cases and drivers, and what leaves a band; nothing for a single driver."""
    table = compare_drivers(run, {})
    if table is None:
        return
    names = [escape(name) for name, _ in table.drivers]
    yield from ("", "### Drivers", "", f"| Case | {' | '.join(names)} |")
    yield "|---" * (len(names) + 1) + "|"
    rows = list(table.by_case())
    for case_id, many, cells in rows[:_MOST_FAILURES]:
        case = f"{escape(case_id)} ({many})" if many > 1 else escape(case_id)
        yield f"| {case} | " + " | ".join(map(escape, cells)) + " |"
    if len(rows) > _MOST_FAILURES:
        yield f"\nand {text.plural(len(rows) - _MOST_FAILURES, 'more case')}"
    counts = (f"{text.count(table.outputs[v])} {words}" for v, words in AGREEMENTS.items())
    total = text.plural(table.outputs.total(), "output")
    yield from ("", f"{total} compared: {', '.join(counts)}", "")
    outside = [each for each in table.differences if each.verdict == "outside"]
    for each in outside[:_MOST_FAILURES]:
        name = escape(f"{text.format_label(each.id, each.variant)}: {each.output}")
        where = f"outside on {', '.join(each.outside)}"
        yield f"- **{name}** {escape(' | '.join(each.drivers))}: {escape(where)}"


def _failure(record: Record) -> Iterable[str]:
    sign = _SIGNS.get(record.status, "❌")
    name = escape(text.format_label(record.id, record.variant))
    yield f"- {sign} **{name}** {grouping.STATUS_WORDS[record.status]} · {escape(record.title)}"
    if record.message:
        yield f"  - {escape(record.message)}"
    for outcome in record.expectations:
        if outcome.status != "pass":
            yield f"  - {_outcome(outcome)}"


def _outcome(outcome: Outcome) -> str:
    parts = [f"{escape(outcome.name)}: {escape(outcome.message) or 'does not hold'}"]
    worst = outcome.worst
    if worst is not None and worst.component < min(map(len, (worst.measured, worst.low))):
        c = worst.component
        place = f"pixel {worst.pixel}: " if worst.pixel else ""
        parts.append(
            f"{place}measured {text.figure(worst.measured[c])}, "
            f"band {text.figure(worst.low[c])} … {text.figure(worst.high[c])} "
            f"({text.short(worst.ulp)} ULP from the reference)"
        )
    parts += [f"{escape(source.file)}:{source.line}" for source in outcome.sources]
    return " · ".join(parts)
