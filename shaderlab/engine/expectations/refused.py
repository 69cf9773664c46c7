"""refused: the lab itself refuses something, with exactly this message, place and remedy."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Any

from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row

from .base import Context, judge_rows


@dataclass(frozen=True)
class RaisedError(Need):
    """The error that the lab raises over a shader's name or in a function, or None; folders are
    left out of its paths."""

    what: str | Callable[[], Any]

    def answer(self, context: Context) -> ShaderlabError | None:
        try:
            if isinstance(self.what, str):
                context.preparer.source(self.what)
            else:
                self.what()
        except ShaderlabError as error:
            return ShaderlabError(
                context.shortened(error.message),
                file=None if error.file is None else context.shortened(error.file),
                line=error.line,
                remedy=None if error.remedy is None else context.shortened(error.remedy),
            )
        return None


@dataclass(frozen=True)
class Refused(Expectation):
    """The lab refuses `what` with this whole error: message, file, line and remedy.

    Args:
        what: a shader's name, which the lab is asked to read with its includes; or a function
            that must raise one of the lab's errors, such as one that reads a mesh.
        message: the error's message. Folders of the case and of the shaders are left out of
            paths, here and in `file`, so that they are the same on every machine.
        file: the file that the error names, "" for none; the shader itself by default.
        line: the line that it names, if it names one.
        remedy: what it advises, "" for nothing.
        name: how outcomes call it.
    """

    kind = "refused"

    what: str | Callable[[], Any]
    _: KW_ONLY
    message: str
    file: str | None = None
    line: int | None = None
    remedy: str = ""

    def __post_init__(self) -> None:
        own = self.what if isinstance(self.what, str) else ""
        self.name_by_default(f"{own or self.file or 'it'} is refused")
        if self.file is None:
            object.__setattr__(self, "file", own)

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield RaisedError(self.what)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        error: ShaderlabError | None = frame.answers[RaisedError(self.what)]
        want = _parts(self.message, self.file, self.line, self.remedy)
        got = _parts("nothing", None, None, None)
        if error is not None:
            got = _parts(error.message, error.file, error.line, error.remedy)
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
        return judge_rows(self.name, self.kind, rows, message, judged=len(rows))


def _parts(message: str, file: str | None, line: int | None, remedy: str | None) -> dict[str, str]:
    return {
        "message": message,
        "file": file or "",
        "line": "" if line is None else str(line),
        "remedy": remedy or "",
    }


refused = Refused
