"""gl_call: what the API itself says to a call, by exact error and value.

What serves such calls alone is imported from here: `call`, `Object`, `Program`, `Location`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from shaderlab.errors import CaseError
from shaderlab.model.activity import doing
from shaderlab.model.calls import (
    GL_ERRORS,
    Argument,
    Call,
    Location,
    Object,
    Program,
    call,
    error_name,
    programs_of,
)
from shaderlab.model.case import Scene
from shaderlab.model.checked import checked_arguments
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame, Reply
from shaderlab.model.records import Row
from shaderlab.model.state import one_of

from .base import Context, judge_rows

__all__ = ["GlCall", "Location", "Object", "Program", "call", "gl_call"]


@dataclass(frozen=True)
class Answered(Need):
    """The API's answer to calls made one after the other in a context of their own."""

    calls: tuple[Call, ...]
    returns: tuple[int | float | str, ...]

    def answer(self, context: Context) -> Reply:
        with doing("draw", f"calling {self.calls[-1]}"):
            reply: Reply = context.session.query("call", self.calls, self.returns)
            return reply


@dataclass(frozen=True, kw_only=True)
class GlCall(Expectation):
    """A call of the API raises this error and no other, and answers this, if that is asked."""

    kind = "GL call"

    call: Call
    raises: str
    returns: tuple[int | float | str, ...] | None = None
    at_least: bool = False
    before: tuple[Call, ...] = ()

    def passes(self, scene: Scene) -> frozenset[str]:
        named = programs_of((*self.before, self.call))
        return frozenset(scene.draw_key(p.pass_name, p.draw)[0] for p in named)

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield self._need

    @property
    def _need(self) -> Answered:
        return Answered((*self.before, self.call), self.returns or ())

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        reply: Reply = frame.answers[self._need]
        want = GL_ERRORS[self.raises]
        errors = ", ".join(error_name(code) for code in reply.errors) or error_name(0)
        first = reply.at == str(self.call)
        ok = first and list(reply.errors) == ([want] if want else [])
        rows = [
            Row(
                label=reply.at,
                expected=error_name(want if first else 0),
                measured=errors,
                ok=ok,
                note="" if first else f"comes before {self.call}",
            )
        ]
        if self.returns is not None and first and not want:
            expected, returned = (
                ", ".join(_named(v, reply.names) for v in values) or "nothing"
                for values in (reply.wanted, reply.returned)
            )
            same = reply.wanted == reply.returned
            if self.at_least:
                expected = f"≥ {expected}"
                same = len(reply.returned) == 1 and reply.returned[0] >= reply.wanted[0]
            rows.append(Row(label="its answer", expected=expected, measured=returned, ok=same))
        wrong = next((row for row in rows if not row.ok), None)
        verb = "raises" if wrong is rows[0] else "answers"
        message = f"{reply.at} {verb} {wrong.measured}" if wrong else ""
        return judge_rows(self.name, self.kind, rows, message, judged=len(rows))


@checked_arguments
def gl_call(
    function: str,
    *arguments: Argument,
    raises: str = "no_error",
    returns: int | float | str | Sequence[int | float | str] | None = None,
    at_least: float | None = None,
    before: Sequence[Call] = (),
    name: str = "",
) -> GlCall:
    """What the API itself says to a call, judged by exact code.

    Args:
        function: its C name.
        arguments: as in `Call`.
        raises: the one error it must raise; none by default.
        returns: what it must return, or, for a glGet… function, what it must write: a number, a
            "GL_" word, or several.
        at_least: the least number that it may return or write, where drivers differ.
        before: calls that come first, in order, each of which must raise no error.
        name: how outcomes call it; the call itself by default.

    Raises:
        CaseError: `raises` is no error of OpenGL; or two of an error, a value and a least value are
            asked for at once.
    """
    one_of("gl_call", "raises", raises, tuple(GL_ERRORS))
    if returns is not None and at_least is not None:
        raise CaseError(f"gl_call {function}: it returns either a value or at least one")
    if at_least is not None:
        returns = at_least
    if raises != "no_error" and returns is not None:
        raise CaseError(f"gl_call {function}: a call that raises an error returns nothing")
    made = Call(function, arguments)
    several = None
    if returns is not None:
        several = (returns,) if isinstance(returns, int | float | str) else tuple(returns)
    return GlCall(
        call=made,
        raises=raises,
        returns=several,
        at_least=at_least is not None,
        before=tuple(before),
        name=name or str(made),
    )


def _named(value: Any, names: Mapping[int, str]) -> str:
    """A returned value as people read it: a constant by its name, with its number."""
    if isinstance(value, int) and names.get(value):
        return f"{names[value]} (0x{value:04X})"
    return str(value)
