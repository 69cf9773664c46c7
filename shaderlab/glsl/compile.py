"""One program, several targets: what each compiler says of it, and what it made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl import guards
from shaderlab.glsl.diagnostics import has_errors, of_link, of_stage
from shaderlab.glsl.frontend import ENVIRONMENTS, Linked, check, link
from shaderlab.glsl.interstage import match_locations, unwritten_inputs
from shaderlab.glsl.lifting import lift_samplers
from shaderlab.glsl.sources import STAGES, Source
from shaderlab.glsl.spirv import Interface, reflect
from shaderlab.glsl.tools import validate
from shaderlab.glsl.vulkan import explain
from shaderlab.records import Diagnostic, Verdict

TARGETS = ("glsl", "opengl", "vulkan")
ALL_TARGETS = tuple(ENVIRONMENTS)

_VALIDATION = {"opengl": "opengl4.5", "vulkan": "vulkan1.0", "vulkan-strict": "vulkan1.0"}


@dataclass(frozen=True)
class Compiled:
    """What compiling and linking one program gave.

    Attributes:
        verdicts: one a target, in the order asked for.
        spirv: for each SPIR-V target that compiled, each stage's module, with the locations of
            varyings and uniforms made to agree between stages.
        interface: what the program declares, read from the OpenGL modules; None where the
            OpenGL target does not compile.
        logs: for each target, the compiler's own words: each stage's log, then the link's.
    """

    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]]
    interface: Interface | None
    logs: Mapping[str, str] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether every target accepts the program."""
        return all(verdict.ok for verdict in self.verdicts)

    def require(self) -> None:
        """Nothing, where every target accepts the program.

        Raises:
            ShaderError: a target rejects it; carries that target's first error.
        """
        for verdict in self.verdicts:
            if not verdict.ok:
                errors = [d for d in verdict.diagnostics if d.severity == "error"]
                raise ShaderError(
                    f"{errors[0].message} [{verdict.target}]"
                    + (f" and {len(errors) - 1} more" if len(errors) > 1 else ""),
                    file=errors[0].file,
                    line=errors[0].line,
                )


@dataclass(frozen=True)
class _Result:
    """One target's outcome before it becomes a verdict."""

    diagnostics: tuple[Diagnostic, ...]
    log: str
    modules: Mapping[str, bytes]

    @property
    def ok(self) -> bool:
        return not has_errors(self.diagnostics)


def compile_program(stages: Sequence[Source], targets: Sequence[str] = TARGETS) -> Compiled:
    """Compiles and links one program's stages for each target.

    For "vulkan", samplers are first lifted out of uniform structs, where Vulkan allows none; an
    "info" diagnostic says so.

    A program that plain GLSL rejects is not given to the SPIR-V targets, which can crash on it;
    they are reported as failed for the same reasons.

    Args:
        stages: one source a stage, in any order; a single stage is a program too.
        targets: some of `ALL_TARGETS`.

    Raises:
        ShaderError: no stages, two of one stage, stages that can't be linked, or an unknown
            target; never for what a compiler says of the text, which is in the verdicts.
    """
    ordered = _in_order(stages, targets)
    plain = _plain(ordered)
    results = {"glsl": plain}
    for target in dict.fromkeys(["opengl", *targets]):
        if target != "glsl":
            results[target] = _spirv(ordered, target) if plain.ok else plain
    opengl = results["opengl"]
    return Compiled(
        verdicts=tuple(
            Verdict(
                target=target,
                ok=results[target].ok,
                diagnostics=results[target].diagnostics,
                spirv_bytes=sum(map(len, results[target].modules.values())),
            )
            for target in targets
        ),
        spirv={t: results[t].modules for t in targets if results[t].modules},
        interface=reflect(opengl.modules) if opengl.ok else None,
        logs={target: results[target].log for target in targets},
    )


def _in_order(stages: Sequence[Source], targets: Sequence[str]) -> list[Source]:
    """The sources in pipeline order."""
    for target in targets:
        if target not in ENVIRONMENTS:
            raise ShaderError(
                f"no such compile target: {target!r}", remedy=nearest(target, ENVIRONMENTS)
            )
    if not stages:
        raise ShaderError("a program needs at least one stage")
    ordered = sorted(stages, key=lambda source: STAGES.index(source.stage))
    for one, other in pairwise(ordered):
        if one.stage == other.stage:
            raise ShaderError(
                f"a program has one {one.stage} stage; {other.name} is another", file=other.path
            )
    if ordered[-1].stage == "compute" and len(ordered) > 1:
        raise ShaderError(
            f"a compute stage can't be linked with a {ordered[0].stage} stage",
            file=ordered[-1].path,
            remedy="make it a program of its own",
        )
    return ordered


def _plain(sources: Sequence[Source]) -> _Result:
    deadly = tuple(d for d in map(guards.fatal, sources) if d)
    if deadly:
        return _Result(deadly, "", {})
    diagnostics: list[Diagnostic] = []
    log = ""
    failed = False
    for source in sources:
        checked = check(source)
        log += checked.log
        failed |= not checked.ok
        diagnostics += _surely(of_stage(checked.log, source), checked.ok, source)
    if not failed:
        linked = link(sources, ENVIRONMENTS["glsl"])
        log += linked.log
        diagnostics += [d for d in _of_linked(linked, sources) if d not in diagnostics]
    return _Result(tuple(diagnostics), log, {})


def _spirv(sources: Sequence[Source], target: str) -> _Result:
    old = tuple(d for d in (guards.too_old(source, target) for source in sources) if d)
    if old:
        return _Result(old, "", {})
    notes: tuple[Diagnostic, ...] = ()
    if target == "vulkan":
        sources, notes = lift_samplers(sources)
    linked = link(sources, ENVIRONMENTS[target])
    log = "".join(linked.stage_logs.values()) + linked.log
    diagnostics = (*notes, *_of_linked(linked, sources))
    if has_errors(diagnostics):
        return _Result(diagnostics, log, {})
    # Validated before it is read, since glslang can make modules that nothing can read.
    problems = _invalid(linked.modules, sources, target)
    if problems:
        modules: Mapping[str, bytes] = {}
    else:
        modules = match_locations(linked.modules, sources)
        changed = {s: m for s, m in modules.items() if m != linked.modules[s]}
        problems = [*unwritten_inputs(sources, modules), *_invalid(changed, sources, target)]
    log += "".join(f"{d.message}\n" for d in problems)
    return _Result((*diagnostics, *problems), log, {} if problems else modules)


def _invalid(
    modules: Mapping[str, bytes], sources: Sequence[Source], target: str
) -> list[Diagnostic]:
    """What SPIRV-Tools has against the modules."""
    found = []
    for source in sources:
        if source.stage in modules:
            message = validate(modules[source.stage], _VALIDATION[target])
            if message is not None:
                found.append(explain(message, source))
    return found


def _of_linked(linked: Linked, sources: Sequence[Source]) -> tuple[Diagnostic, ...]:
    found: dict[Diagnostic, None] = {}
    for source in sources:
        found |= dict.fromkeys(of_stage(linked.stage_logs[source.stage], source))
    found |= dict.fromkeys(of_link(linked.log, sources))
    return _surely(tuple(found), linked.ok, sources[-1])


def _surely(
    diagnostics: tuple[Diagnostic, ...], ok: bool, source: Source
) -> tuple[Diagnostic, ...]:
    """The diagnostics, with an error among them if and only if the compiler failed."""
    if ok or has_errors(diagnostics):
        return diagnostics
    message = "the compiler rejects the shader and does not say why"
    return (
        *diagnostics,
        Diagnostic(file=source.path, line=None, severity="error", message=message),
    )
