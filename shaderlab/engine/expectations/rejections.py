"""compile_fails and refused: compilers reject a shader, or the lab something, in these words."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from shaderlab.engine.expectations.base import Context, Demand
from shaderlab.errors import CaseError, DriverError, ShaderlabError, Verdict
from shaderlab.model.case import Scene
from shaderlab.model.checked import checked_arguments
from shaderlab.model.expectation import Expectation, Judgement, Need, Programs
from shaderlab.model.frame import Frame, TypedNeed
from shaderlab.model.phases import phase
from shaderlab.model.records import Row

Place = tuple[str, int | None, str]
"""A shader's name, a line from 1 (None where a message has none), and the whole message."""


@dataclass(frozen=True, kw_only=True)
class Verdicts:
    """What the compilers say of a program that should be rejected.

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
class CompilerVerdicts(TypedNeed[Verdicts]):
    """What the compilers say of some files as one program."""

    shaders: tuple[str, ...]

    def answer(self, context: Context) -> Verdicts:
        """Ask them. Raises ShaderError where a file can't even be read."""
        with phase("compile"):
            sources, compiled = context.preparer.refusal(self.shaders)
        names = {source.path: source.name for source in sources}
        verdict = compiled.verdicts[0]
        try:
            with phase("link"):
                driver = context.driver_verdict(sources)
        except DriverError:  # it has no such stage: glslang's verdict is the only one
            driver = None

        def errors(said: Verdict | None) -> tuple[Place, ...]:
            return tuple(
                (names.get(d.file) or context.shorten_paths(d.file), d.line, d.message)
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
class CompileFails(Demand):
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
        verdicts = frame.answer(CompilerVerdicts(self.shaders))
        rows = []
        for index in range(max(len(verdicts.errors), len(self.messages))):
            want = self.messages[index] if index < len(self.messages) else None
            got = verdicts.errors[index] if index < len(verdicts.errors) else None
            named = want or got
            assert named is not None
            stage = verdicts.stages.get(named[0], "")
            rows.append(
                Row(
                    label=f"{stage} {_format_place(named)}".strip(),
                    expected="no further message" if want is None else want[2],
                    measured="nothing" if got is None else f"{_format_place(got)}: {got[2]}",
                    ok=want == got,
                )
            )
        what = " + ".join(self.shaders)
        message = ""
        if verdicts.accepted:
            message = f"{what} compiles, but should be rejected"
        elif not all(row.ok for row in rows):
            message = f"{what} is rejected with other messages"
        if verdicts.driver is not None:
            rows.append(self._driver_row(verdicts.driver, verdicts.driver_errors))
            if not rows[-1].ok:
                wrong = "accepts" if verdicts.driver.ok else "reports another line of"
                message = message or f"the driver {wrong} {what}"
        return self.judge_demand(rows, message, frame)

    def _driver_row(self, verdict: Verdict, errors: Sequence[Place]) -> Row:
        expected = "rejected, in its own words" if self.driver else "either"
        ok = not verdict.ok or not self.driver
        if isinstance(self.driver, tuple):
            expected = f"rejected at {_format_place((*self.driver, ''))}"
            ok = ok and bool(errors) and errors[0][:2] == self.driver
        return Row(
            label="the driver",
            expected=expected,
            measured="accepted"
            if verdict.ok
            else "; ".join(f"{_format_place(e)}: {e[2]}" for e in errors),
            ok=ok,
        )


@checked_arguments
def compile_fails(
    shader: str | Sequence[str],
    *messages: tuple[int | None, str] | Place,
    driver: bool | tuple[str, int] = True,
    departs: Mapping[str, str] | None = None,
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
        departs: drivers known to accept it: {"part of the vendor's name": "accepted"}.
        name: how outcomes call it.

    Raises CaseError: a message does not say which of several files it is about."""
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
        shaders=shaders,
        messages=tuple(places),
        driver=driver,
        departs=departs,
        name=name or f"{label} is refused",
    )


def _format_place(place: Place) -> str:
    file, line, _ = place
    return file if line is None else f"{file}:{line}"


@dataclass(frozen=True)
class RaisedError(TypedNeed[ShaderlabError | None]):
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
                context.shorten_paths(error.message),
                file=None if error.file is None else context.shorten_paths(error.file),
                line=error.line,
                remedy=None if error.remedy is None else context.shorten_paths(error.remedy),
            )
        return None


@dataclass(frozen=True)
class Refused(Expectation):
    """The lab refuses `what` with this whole error: message, file, line and remedy.

    Args:
        what: a shader's name, which the lab reads with its includes; or a function
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
        if self.file is None:
            object.__setattr__(self, "file", self.what if isinstance(self.what, str) else "")

    @property
    def default_name(self) -> str:
        own = self.what if isinstance(self.what, str) else ""
        return f"{own or self.file or 'it'} is refused"

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        yield RaisedError(self.what)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        error = frame.answer(RaisedError(self.what))
        rows = []
        for part in ("message", "file", "line", "remedy"):
            want = str(getattr(self, part) or "")
            got = str(getattr(error, part, None) or "")
            if want or got:
                shown = "nothing" if part == "message" and error is None else got
                rows.append(Row(label=part, expected=want, measured=shown, ok=want == got))
        message = ""
        if error is None:
            message = "the lab accepts it, but should reject it"
        elif not all(row.ok for row in rows):
            message = "the lab rejects it in other words: " + str(error).replace("\n", " ")
        return self.judge_rows(rows, message, judged=len(rows))


refused = Refused
