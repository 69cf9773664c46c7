"""gl_error: a draw raises this GL error, and nothing else does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from shaderlab.model.calls import GL_ERRORS, error_name
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Frame, PassDraw
from shaderlab.model.records import Row
from shaderlab.model.state import one_of

from .base import Asked, OfDraw, judge_rows


@dataclass(frozen=True)
class GlError(OfDraw):
    """The draw raises this error ("invalid_operation", …); any other error fails the case."""

    kind = "GL error"

    error: str

    def __post_init__(self) -> None:
        one_of("gl_error", "error", self.error, tuple(GL_ERRORS))
        self.name_by_default(f"GL {self.error}")

    def raises_gl_errors(self, scene: Scene) -> frozenset[PassDraw]:
        return frozenset({self.key(scene)})

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield Asked("gl_errors", (self.key(scene),))

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        errors: Sequence[int] = frame.answers[Asked("gl_errors", (self.key(scene),))]
        want = GL_ERRORS[self.error]
        ok = list(errors) == ([want] if want else [])
        measured = ", ".join(error_name(e) for e in errors) or error_name(0)
        row = Row(label="glGetError", expected=error_name(want), measured=measured, ok=ok)
        message = "" if ok else f"the draw raises {measured}"
        return judge_rows(self.name, self.kind, [row], message, judged=1)


gl_error = GlError
