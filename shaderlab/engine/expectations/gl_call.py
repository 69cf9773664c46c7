"""gl_call and gl_calls: what the API answers to a call, and which calls drawing a scene makes.

What serves such calls alone is imported from here: `call`, `Object`, `Program`, `Location`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

from shaderlab.engine.expectations.base import Context, Demand, SessionQuery
from shaderlab.errors import CaseError
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
from shaderlab.model.frame import Frame, Reply, TracedCall, TypedNeed
from shaderlab.model.phases import phase
from shaderlab.model.records import Row
from shaderlab.model.state import check_choice

# Calls of the function that a failing table lists.
MOST_SHOWN = 12

__all__ = ["GlCall", "GlCalls", "Location", "Object", "Program", "call", "gl_call", "gl_calls"]


@dataclass(frozen=True)
class CallReply(TypedNeed[Reply]):
    """The API's answer to calls made one after the other in a separate context."""

    calls: tuple[Call, ...]
    returns: tuple[int | float | str, ...]

    def answer(self, context: Context) -> Reply:
        with phase("draw", f"calling {self.calls[-1]}"):
            reply: Reply = context.session.query("call", self.calls, self.returns)
            return reply


@dataclass(frozen=True, kw_only=True)
class GlCall(Demand):
    """A call of the API raises this error and no other, and returns this, if that is given."""

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
    def _need(self) -> CallReply:
        return CallReply((*self.before, self.call), self.returns or ())

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        reply = frame.answer(self._need)
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
                ", ".join(_format_value(v, reply.names) for v in values) or "nothing"
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
        return self.judge_demand(rows, message, frame)


@checked_arguments
def gl_call(
    function: str,
    *arguments: Argument,
    raises: str = "no_error",
    returns: int | float | str | Sequence[int | float | str] | None = None,
    at_least: float | None = None,
    before: Sequence[Call] = (),
    departs: Mapping[str, str] | None = None,
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
        departs: drivers known to answer otherwise: {"part of the vendor's name": "GL_NO_ERROR"}.
        name: how outcomes call it; the call itself by default.

    Raises CaseError: `raises` is not an error of OpenGL; or two of an error, a value and a least
    value are given."""
    check_choice("gl_call", "raises", raises, tuple(GL_ERRORS))
    if returns is not None and at_least is not None:
        raise CaseError(f"gl_call {function}: give returns= or at_least=, not both")
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
        departs=departs,
        name=name or str(made),
    )


def _format_value(value: Any, names: Mapping[int, str]) -> str:
    if isinstance(value, int) and names.get(value):
        return f"{names[value]} (0x{value:04X})"
    return str(value)


@dataclass(frozen=True)
class CallTrace(TypedNeed[Sequence[TracedCall]]):
    """The calls that drawing the scene makes."""

    def answer(self, context: Context) -> Sequence[TracedCall]:
        with phase("draw", "recording calls of OpenGL"):
            calls: Sequence[TracedCall] = context.session.query("trace")
            return calls


@dataclass(frozen=True, kw_only=True)
class GlCalls(Expectation):
    """A function of OpenGL is called so many times with these arguments; see `gl_calls`."""

    kind = "GL calls"

    function: str
    arguments: Mapping[str, str]
    times: int | None
    after: str
    pass_name: str | None

    def passes(self, scene: Scene) -> frozenset[str]:
        return frozenset({p.name for p in scene.passes if self.pass_name in (None, p.name)})

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        if self.pass_name is not None:
            scene.find_pass(self.pass_name)
        yield CallTrace()
        for function in filter(None, (self.function, self.after)):
            yield _parameters_of(function)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        trace = frame.answer(CallTrace())
        calls = [c for c in trace if self.pass_name in (None, c.pass_name)]
        same = [c for c in calls if c.function == self.function]
        self._require_parameters(frame.answer(_parameters_of(self.function)))
        found = [c for c in same if self._matches(c)]
        wanted = "at least 1" if self.times is None else str(self.times)
        ok = bool(found) if self.times is None else len(found) == self.times
        rows = [Row(label=self._format_call(), expected=wanted, measured=str(len(found)), ok=ok)]
        message = "" if ok else f"{self._format_call()} is called {len(found)} times, not {wanted}"
        if self.after:
            before = takewhile(lambda c: c.function != self.after, calls)
            early = sum(c.function == self.function and self._matches(c) for c in before)
            rows.append(
                Row(label=f"before {self.after}", expected="0", measured=str(early), ok=not early)
            )
            if early and not message:
                message = f"{self._format_call()} is called before {self.after}"
        if not ok:
            rows += [
                Row(label=str(c), expected="", measured="", ok=True) for c in same[:MOST_SHOWN]
            ]
        return self.judge_rows(rows, message, judged=len(rows))

    def _matches(self, call: TracedCall) -> bool:
        return all(call.arguments.get(name) == word for name, word in self.arguments.items())

    def _require_parameters(self, known: Sequence[str]) -> None:
        for name in self.arguments:
            if name not in known:
                raise CaseError(
                    f"gl_calls: {self.function} has no parameter {name!r}",
                    remedy=f"it has {', '.join(known)}",
                )

    def _format_call(self) -> str:
        words = ", ".join(f"{name} = {word}" for name, word in self.arguments.items())
        return f"{self.function}({words})" if words else self.function


def _parameters_of(function: str) -> SessionQuery[Sequence[str]]:
    return SessionQuery("parameters", (function,))


def gl_calls(
    function: str,
    *,
    times: int | None = None,
    after: str = "",
    pass_name: str | None = None,
    name: str = "",
    **arguments: str | int,
) -> GlCalls:
    """Which calls of OpenGL drawing the scene makes: the lab's own, as a driver gets them.

    Args:
        function: its C name, such as "glBufferData".
        times: how often it must be called with these arguments; 0 for never, None for at least
            once.
        after: another function, before whose first call there must be none of these.
        pass_name: the pass whose calls count; all by default.
        name: how outcomes call it.
        arguments: values of parameters by their names in OpenGL's headers, such as
            usage="GL_STREAM_DRAW": constants by name, numbers as they are.

    Raises CaseError: `function` is not a name of a function, or `times` is negative."""
    if not function.startswith("gl") or (times is not None and times < 0):
        raise CaseError(
            f"gl_calls({function!r}, times={times})",
            remedy="a C name such as 'glBufferData', and how often: 0 for never",
        )
    words = {key: str(value) for key, value in arguments.items()}
    return GlCalls(
        name=name or function,
        function=function,
        arguments=words,
        times=times,
        after=after,
        pass_name=pass_name,
    )
