"""Judging what must be refused, and which uniforms a driver leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from shaderlab.checks.judgement import Judgement
from shaderlab.checks.plain import table
from shaderlab.errors import CaseError, ShaderlabError, nearest
from shaderlab.model import CompileFails, InactiveUniforms, Refused
from shaderlab.model.refusals import Place
from shaderlab.records import Row, Verdict

NOTHING = "nothing"


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What the compilers said of a program that must be refused.

    `errors` are those of the plain GLSL compiler, `stages` each file's stage by its name;
    `driver` is the driver's own verdict, None where it was not asked.
    """

    errors: tuple[Place, ...]
    accepted: bool
    stages: Mapping[str, str] = field(default_factory=dict)
    driver: Verdict | None = None


@dataclass(frozen=True, kw_only=True)
class Complaint:
    """The error that the lab raised, or None; folders are left out of its paths."""

    error: ShaderlabError | None


def judge_compile_fails(expectation: CompileFails, answer: Answer) -> Judgement:
    """Compare all errors of a compiler with the expected ones: files, lines and whole messages."""
    rows = []
    for index in range(max(len(answer.errors), len(expectation.messages))):
        want = expectation.messages[index] if index < len(expectation.messages) else None
        got = answer.errors[index] if index < len(answer.errors) else None
        named = want or got
        assert named is not None
        stage = answer.stages.get(named[0], "")
        rows.append(
            Row(
                label=f"{stage} {_spot(named)}".strip(),
                expected="no further message" if want is None else want[2],
                measured=NOTHING if got is None else f"{_spot(got)}: {got[2]}",
                ok=want == got,
            )
        )
    what = " + ".join(expectation.shaders)
    message = ""
    if answer.accepted:
        message = f"{what} compiles, but must be refused"
    elif not all(row.ok for row in rows):
        message = f"{what} is refused with other messages"
    if answer.driver is not None:
        rows.append(_driver_row(expectation, answer.driver))
        if not rows[-1].ok:
            message = message or f"the driver accepts {what}"
    return table(expectation.name, "compile fails", rows, message, judged=len(rows) or 1)


def _driver_row(expectation: CompileFails, verdict: Verdict) -> Row:
    said = [
        f"line {d.line}: {d.message}" if d.line is not None else d.message
        for d in verdict.diagnostics
        if d.severity == "error"
    ]
    return Row(
        label="the driver",
        expected="refused, in its own words" if expectation.driver else "either",
        measured="accepted" if verdict.ok else "; ".join(said),
        ok=not verdict.ok or not expectation.driver,
    )


def judge_refused(expectation: Refused, complaint: Complaint) -> Judgement:
    """Compare the lab's error with the expected one: message, place and remedy, word for word."""
    error = complaint.error
    want = {
        "message": expectation.message,
        "file": expectation.file,
        "line": _line(expectation.line),
        "remedy": expectation.remedy,
    }
    got = {"message": NOTHING, "file": "", "line": "", "remedy": ""}
    if error is not None:
        got = {
            "message": error.message,
            "file": error.file or "",
            "line": _line(error.line),
            "remedy": error.remedy or "",
        }
    rows = [
        Row(label=part, expected=want[part], measured=got[part], ok=want[part] == got[part])
        for part in want
        if want[part] or got[part]
    ]
    message = ""
    if error is None:
        message = "the lab takes it, but must refuse it"
    elif not all(row.ok for row in rows):
        message = "the lab refuses it in other words: " + str(error).replace("\n", " ")
    return table(expectation.name, "refused", rows, message, judged=len(rows))


def judge_inactive(expectation: InactiveUniforms, locations: Mapping[str, int]) -> Judgement:
    """Compare the uniforms that have no location with those that must have none.

    Raises:
        CaseError: a name is no uniform that the program declares.
    """
    for name in expectation.uniforms:
        if name not in locations:
            raise CaseError(
                f"inactive_uniforms: the program declares no {name!r}",
                remedy=nearest(name, locations),
            )
    rows = []
    for name, location in locations.items():
        inactive = name in expectation.uniforms
        rows.append(
            Row(
                label=name,
                expected="inactive: −1" if inactive else "active: 0 or more",
                measured=str(location).replace("-", "−"),
                ok=(location == -1) is inactive,
            )
        )
    wrong = [row.label for row in rows if not row.ok]
    message = f"not as expected: {', '.join(wrong)}" if wrong else ""
    return table(expectation.name, "inactive uniforms", rows, message, judged=len(rows) or 1)


def _spot(place: Place) -> str:
    file, line, _ = place
    return file if line is None else f"{file}:{line}"


def _line(line: int | None) -> str:
    return "" if line is None else str(line)
