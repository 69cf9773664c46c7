"""compile_fails: a shader, or a program of several, is refused with exactly these messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from shaderlab.errors import CaseError, DriverError
from shaderlab.model.activity import doing
from shaderlab.model.case import Scene
from shaderlab.model.checked import checked_arguments
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame
from shaderlab.model.records import Row, Verdict

from .base import Context, judge_rows

Place = tuple[str, int | None, str]
"""A shader's name, a line from 1 (None where a message has none), and the whole message."""


@dataclass(frozen=True, kw_only=True)
class Verdicts:
    """What the compilers said of a program that must be refused.

    `errors` are those of the plain GLSL compiler, `stages` each file's stage by its name;
    `driver` is the driver's own verdict, None where the driver lacks such a stage; `driver_errors`
    are its errors.
    """

    errors: tuple[Place, ...]
    accepted: bool
    stages: Mapping[str, str] = field(default_factory=dict)
    driver: Verdict | None = None
    driver_errors: tuple[Place, ...] = ()


@dataclass(frozen=True)
class CompilerVerdicts(Need):
    """What the compilers say of some files as one program."""

    shaders: tuple[str, ...]

    def answer(self, context: Context) -> Verdicts:
        """Ask them. Raises ShaderError where a file can't even be read."""
        with doing("compile"):
            sources, compiled = context.preparer.refusal(self.shaders)
        names = {source.path: source.name for source in sources}
        verdict = compiled.verdicts[0]
        try:
            with doing("link"):
                driver = context.driver_verdict(sources)
        except DriverError:  # it has no such stage: glslang's verdict is the only one
            driver = None

        def errors(said: Verdict | None) -> tuple[Place, ...]:
            return tuple(
                (names.get(d.file) or context.shortened(d.file), d.line, d.message)
                for d in (said.diagnostics if said else ())
                if d.severity == "error"
            )

        return Verdicts(
            errors=errors(verdict),
            accepted=verdict.ok,
            stages={source.name: source.stage for source in sources},
            driver=driver,
            driver_errors=errors(driver),
        )


@dataclass(frozen=True, kw_only=True)
class CompileFails(Expectation):
    """The plain GLSL compiler refuses the shaders with exactly these messages. `driver` says
    whether the driver must refuse them too, and in which file and line; in which words is up to
    the driver."""

    kind = "compile fails"

    shaders: tuple[str, ...]
    messages: tuple[Place, ...]
    driver: bool | tuple[str, int] = True

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield CompilerVerdicts(self.shaders)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        verdicts: Verdicts = frame.answers[CompilerVerdicts(self.shaders)]
        rows = []
        for index in range(max(len(verdicts.errors), len(self.messages))):
            want = self.messages[index] if index < len(self.messages) else None
            got = verdicts.errors[index] if index < len(verdicts.errors) else None
            named = want or got
            assert named is not None
            stage = verdicts.stages.get(named[0], "")
            rows.append(
                Row(
                    label=f"{stage} {_spot(named)}".strip(),
                    expected="no further message" if want is None else want[2],
                    measured="nothing" if got is None else f"{_spot(got)}: {got[2]}",
                    ok=want == got,
                )
            )
        what = " + ".join(self.shaders)
        message = ""
        if verdicts.accepted:
            message = f"{what} compiles, but must be refused"
        elif not all(row.ok for row in rows):
            message = f"{what} is refused with other messages"
        if verdicts.driver is not None:
            rows.append(self._driver_row(verdicts.driver, verdicts.driver_errors))
            if not rows[-1].ok:
                wrong = "accepts" if verdicts.driver.ok else "refuses another place of"
                message = message or f"the driver {wrong} {what}"
        return judge_rows(self.name, self.kind, rows, message, judged=len(rows) or 1)

    def _driver_row(self, verdict: Verdict, errors: Sequence[Place]) -> Row:
        expected = "refused, in its own words" if self.driver else "either"
        ok = not verdict.ok or not self.driver
        if isinstance(self.driver, tuple):
            expected = f"refused at {_spot((*self.driver, ''))}"
            ok = ok and bool(errors) and errors[0][:2] == self.driver
        return Row(
            label="the driver",
            expected=expected,
            measured="accepted" if verdict.ok else "; ".join(f"{_spot(e)}: {e[2]}" for e in errors),
            ok=ok,
        )


@checked_arguments
def compile_fails(
    shader: str | Sequence[str],
    *messages: tuple[int | None, str] | Place,
    driver: bool | tuple[str, int] = True,
    name: str = "",
) -> CompileFails:
    """`shader` is refused with these whole messages, each (line, text), in this order.

    Args:
        shader: one file, which is compiled by itself; or several, which are linked as well.
        messages: all errors of the plain GLSL compiler, in its words. For several files each is
            (file, line, text). A message of the linker that no declaration can be found for has
            the line None.
        driver: whether the driver must refuse it, too; or the (file, line) that its first error
            must name. Its words differ from those of another driver: they are shown, and not
            compared.
        name: how outcomes call it.

    Raises:
        CaseError: a message does not say which of several files it is about.
    """
    shaders = (shader,) if isinstance(shader, str) else tuple(shader)
    places: list[Place] = []
    for message in messages:
        place = (shaders[0], *message) if len(message) == 2 else message
        if (len(message) == 2 and len(shaders) > 1) or place[0] not in shaders:
            raise CaseError(
                f"compile_fails: {message!r} is about none of {', '.join(shaders)}",
                remedy="write (file, line, text)",
            )
        places.append(place)
    label = " + ".join(shaders)
    return CompileFails(
        shaders=shaders, messages=tuple(places), driver=driver, name=name or f"{label} is refused"
    )


def _spot(place: Place) -> str:
    file, line, _ = place
    return file if line is None else f"{file}:{line}"
