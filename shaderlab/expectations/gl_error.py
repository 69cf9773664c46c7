"""gl_error: a draw raises this GL error, and nothing else does."""

from __future__ import annotations

from dataclasses import dataclass

from shaderlab.expectations.base import OfDraw, table
from shaderlab.frame import Frame, PassDraw
from shaderlab.model import GL_ERRORS, Judgement, Scene, error_name, one_of
from shaderlab.records import Row


@dataclass(frozen=True, kw_only=True)
class GlError(OfDraw):
    """The draw raises `error`, one of GL_ERRORS."""

    kind = "GL error"

    error: str

    def raises_gl_errors(self, scene: Scene) -> frozenset[PassDraw]:
        return frozenset({self.key(scene)})

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        errors = frame.gl_errors.get(self.key(scene), ())
        want = GL_ERRORS[self.error]
        ok = list(errors) == ([want] if want else [])
        measured = ", ".join(error_name(e) for e in errors) or error_name(0)
        row = Row(label="glGetError", expected=error_name(want), measured=measured, ok=ok)
        message = "" if ok else f"the draw raises {measured}"
        return table(self.name, self.kind, [row], message, judged=1)


def gl_error(
    error: str, *, pass_name: str | None = None, draw: int = -1, name: str = ""
) -> GlError:
    """The draw raises this error ("invalid_operation", …); any other error fails the case."""
    one_of("gl_error", "error", error, tuple(GL_ERRORS))
    return GlError(error=error, pass_name=pass_name, draw=draw, name=name or f"GL {error}")
