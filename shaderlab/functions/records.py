"""What a test finds of GLSL functions, and its record on a report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace

from shaderlab.compiler.sources import Source
from shaderlab.files import display_path
from shaderlab.model.records import Outcome, ProgramRecord, Record, SourceText, Status


@dataclass
class Notes:
    """What one test did: the outcomes of its checks, and the functions that it called."""

    outcomes: list[Outcome] = field(default_factory=list)
    called: dict[tuple[str, int], SourceText] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.outcomes or self.called)

    def add_call(self, source: Source, definition: SourceText) -> None:
        self.called.setdefault((definition.file, definition.line), definition)
        self.sources.setdefault(source.path, source)


_NOTES: ContextVar[Notes | None] = ContextVar("_NOTES", default=None)


def current_notes() -> Notes | None:
    """The notes of the test that runs; None if none are taken."""
    return _NOTES.get()


@contextmanager
def take_notes() -> Iterator[Notes]:
    found = Notes()
    token = _NOTES.set(found)
    try:
        yield found
    finally:
        _NOTES.reset(token)


def record_of_test(
    file: str,
    name: str,
    line: int,
    *,
    status: Status,
    message: str = "",
    seconds: float = 0.0,
    lesson: str = "",
    notes: Notes | None = None,
) -> Record:
    """A test's record: its file is the case, the test a variant, each check an expectation. A test
    that asserts of itself what functions give is one expectation.
    """
    shown = display_path(file)
    stem = shown.rpartition("/")[2].removesuffix(".py")
    found = notes or Notes()
    outcomes = tuple(_merge_outcomes(found.outcomes))
    if not outcomes and found.called and status in ("pass", "fail"):
        own = Outcome(
            name=name,
            kind="test",
            status="pass" if status == "pass" else "fail",
            message=message,
            sources=tuple(found.called.values()),
            line=line,
        )
        outcomes = (own,)
    is_explained = any(outcome.status != "pass" for outcome in outcomes)
    return Record(
        id=stem,
        variant=name,
        title=lesson.partition("\n")[0].strip() or stem,
        section="",
        lesson=lesson,
        formula="",
        file=shown,
        status=status,
        message="" if is_explained else message,
        seconds=seconds,
        programs=tuple(_programs(found)),
        expectations=tuple(
            replace(o, sources=tuple(replace(s, file=display_path(s.file)) for s in o.sources))
            for o in outcomes
        ),
    )


def _merge_outcomes(outcomes: list[Outcome]) -> Iterator[Outcome]:
    """The outcomes, those of one property as one: its batches were judged one by one."""
    together: dict[tuple[str, str, int], Outcome] = {}
    for number, outcome in enumerate(outcomes):
        same = outcome.kind == "given"
        key = (outcome.name, outcome.kind, outcome.line if same else -1 - number)
        before = together.get(key)
        judged = outcome.judged + (before.judged if before else 0)
        together[key] = replace(outcome, judged=judged)
    names: dict[str, int] = {}
    for outcome in together.values():
        names[outcome.name] = names.get(outcome.name, 0) + 1
        number = names[outcome.name]
        yield outcome if number == 1 else replace(outcome, name=f"{outcome.name} ({number})")


def _programs(found: Notes) -> Iterator[ProgramRecord]:
    for source in found.sources.values():
        parts = [(display_path(path), text) for path, text in source.parts]
        yield ProgramRecord(
            files=tuple(path for path, _ in parts),
            sources=tuple(
                SourceText(file=path, line=1, language="glsl", text=text) for path, text in parts
            ),
            verdicts=(),
        )
