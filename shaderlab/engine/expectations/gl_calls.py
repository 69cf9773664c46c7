"""gl_calls: which calls of OpenGL drawing the scene takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from shaderlab.errors import CaseError
from shaderlab.model.activity import doing
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame, TracedCall
from shaderlab.model.records import Row

from .base import Context, judge_rows

_SHOWN = 12


@dataclass(frozen=True)
class Traced(Need):
    """The calls that drawing the scene takes."""

    def answer(self, context: Context) -> Sequence[TracedCall]:
        with doing("draw", "recording calls of OpenGL"):
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
        yield Traced()

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        trace: Sequence[TracedCall] = frame.answers[Traced()]
        calls = [c for c in trace if self.pass_name in (None, c.pass_name)]
        same = [c for c in calls if c.function == self.function]
        if same:
            self._require_parameters(same[0])
        found = [c for c in same if self._matches(c)]
        wanted = "at least 1" if self.times is None else str(self.times)
        ok = bool(found) if self.times is None else len(found) == self.times
        rows = [Row(label=self._in_words(), expected=wanted, measured=str(len(found)), ok=ok)]
        message = "" if ok else f"{self._in_words()} is called {len(found)} times, not {wanted}"
        if self.after:
            early = self._early(calls)
            rows.append(
                Row(label=f"before {self.after}", expected="0", measured=str(early), ok=not early)
            )
            if early and not message:
                message = f"{self._in_words()} is called before {self.after}"
        if not ok:
            rows += [Row(label=str(c), expected="", measured="", ok=True) for c in same[:_SHOWN]]
        return judge_rows(self.name, self.kind, rows, message, judged=len(rows))

    def _matches(self, call: TracedCall) -> bool:
        return all(call.arguments.get(name) == word for name, word in self.arguments.items())

    def _early(self, calls: Sequence[TracedCall]) -> int:
        """How many of the calls come before the first one of `after`."""
        first = next((i for i, c in enumerate(calls) if c.function == self.after), len(calls))
        return sum(c.function == self.function and self._matches(c) for c in calls[:first])

    def _require_parameters(self, call: TracedCall) -> None:
        for name in self.arguments:
            if name not in call.arguments:
                raise CaseError(
                    f"gl_calls: {self.function} has no parameter {name!r}",
                    remedy=f"it has {', '.join(call.arguments)}",
                )

    def _in_words(self) -> str:
        words = ", ".join(f"{name} = {word}" for name, word in self.arguments.items())
        return f"{self.function}({words})" if words else self.function


def gl_calls(
    function: str,
    *,
    times: int | None = None,
    after: str = "",
    pass_name: str | None = None,
    name: str = "",
    **arguments: str | int,
) -> GlCalls:
    """Which calls of OpenGL drawing the scene takes: the lab's own, as a driver gets them.

    Args:
        function: its C name, such as "glBufferData".
        times: how often it must be called with these arguments; 0 for never, None for at least
            once.
        after: another function, before whose first call there must be none of these.
        pass_name: the pass whose calls count; all by default.
        name: how outcomes call it.
        arguments: values of parameters by their names in OpenGL's headers, such as
            usage="GL_STREAM_DRAW": constants by name, numbers as they are.

    Raises:
        CaseError: `function` is no name of one, or `times` is negative.
    """
    if not function.startswith("gl") or (times is not None and times < 0):
        raise CaseError(
            f"gl_calls({function!r}, times={times})",
            remedy="a C name such as 'glBufferData', and how often: 0 for never",
        )
    words = {key: str(value) for key, value in arguments.items()}
    return GlCalls(
        name=name or function, function=function, arguments=words, times=times, after=after,
        pass_name=pass_name,
    )  # fmt: skip
