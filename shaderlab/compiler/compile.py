"""Compiles one program for several targets: verdicts, SPIR-V modules, interface."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from shaderlab.compiler.engines import Engine, choose
from shaderlab.compiler.interface import Interface
from shaderlab.compiler.reflection import reflect
from shaderlab.compiler.sources import Source
from shaderlab.compiler.targets import ALL_TARGETS, TARGETS
from shaderlab.compiler.text import STAGES
from shaderlab.compiler.verdicts import check_stages, link_stages, to_spirv
from shaderlab.errors import ShaderError, nearest
from shaderlab.records import Diagnostic, Verdict

# The compiler's words, or a name, for what GLSL has for Vulkan or SPIR-V only.
_SPIRV_ONLY = re.compile(
    r"only allowed when (?:using GLSL for Vulkan|generating SPIR-V)"
    r"|'(?:gl_VertexIndex|gl_InstanceIndex|subpassInput\w*|[iu]?texture[123C]\w+|sampler)' : "
)


@dataclass(frozen=True)
class Compiled:
    """A program's verdicts, modules and interface.

    Attributes:
        verdicts: one for each target, in the order they were given.
        spirv: each stage's module, for each SPIR-V target that accepts the program. Locations of
            varyings and uniforms agree between stages.
        logs: the compiler's own words for each target: each stage's log, then the link's.
        sources: the stages, in pipeline order.
    """

    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]]
    logs: Mapping[str, str] = field(default_factory=dict)
    sources: tuple[Source, ...] = field(default=(), repr=False)
    _reflect: Callable[[], Interface | None] | None = field(default=None, repr=False, compare=False)

    @property
    def ok(self) -> bool:
        """Whether every target accepts the program."""
        return all(verdict.ok for verdict in self.verdicts)

    @functools.cached_property
    def interface(self) -> Interface | None:
        """What the program declares, read from its OpenGL modules on first use; None if it does
        not compile for OpenGL."""
        return self._reflect() if self._reflect else None

    def only(self, targets: Sequence[str]) -> Compiled:
        """The program with some of its targets only, and the same interface."""
        return replace(
            self,
            verdicts=tuple(verdict for verdict in self.verdicts if verdict.target in targets),
            spirv={target: modules for target, modules in self.spirv.items() if target in targets},
            logs={target: log for target, log in self.logs.items() if target in targets},
        )

    def require(self) -> None:
        """Raises unless every target accepts the program.

        Raises:
            ShaderError: the first error of the first target that refuses it.
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


Compile = Callable[[Sequence[Source], Sequence[str]], Compiled]
"""`compile_program` or a function that stands for it."""


def compile_program(
    stages: Sequence[Source], targets: Sequence[str] = TARGETS, *, engine: Engine | None = None
) -> Compiled:
    """Compiles and links one program's stages for each target.

    Vulkan allows no samplers in uniform structs, so they are lifted out for "vulkan", and an
    "info" diagnostic says so.

    A program that plain GLSL refuses can crash the SPIR-V targets. They don't get it, and their
    verdicts have the same errors. They do get GLSL that only SPIR-V knows, such as
    `layout (constant_id = 0)`.

    Args:
        stages: at least one source, in any order; at most one for each stage.
        targets: some of `ALL_TARGETS`.
        engine: by default `engines.choose()`.

    Raises:
        ShaderError: no stages, two of one stage, stages that can't be linked, or an unknown
            target. What is wrong with the text never raises; it is in the verdicts.
    """
    ordered = in_order(stages, targets)
    engine = engine or choose()
    plain = check_stages(ordered, engine)
    results = {"glsl": plain}
    goes_on = plain.ok or _is_spirv_only(plain.diagnostics)
    if plain.ok and (len(ordered) > 1 or "opengl" not in targets):
        results["glsl"] = plain = link_stages(plain, ordered, engine)
        goes_on = plain.ok
    for target in targets:
        if target != "glsl":
            results[target] = to_spirv(ordered, target, engine) if goes_on else plain
        # One stage that links for OpenGL without a message also links as plain GLSL, which saves
        # half a millisecond. Otherwise the plain link's messages come first.
        if target == "opengl" and plain.ok and len(ordered) == 1 and not results[target].linked:
            results["glsl"] = plain = link_stages(plain, ordered, engine)
            if not plain.ok:
                goes_on = False
                results = {done: plain for done in results}

    def interface() -> Interface | None:
        if "opengl" not in results:
            return compile_program(ordered, ("glsl", "opengl"), engine=engine).interface
        modules = results["opengl"].modules
        return reflect(modules) if modules else None

    return Compiled(
        verdicts=tuple(results[target].verdict(target) for target in targets),
        spirv={t: results[t].modules for t in targets if results[t].modules},
        logs={target: results[target].log for target in targets},
        sources=tuple(ordered),
        _reflect=functools.cache(interface),
    )


def _is_spirv_only(diagnostics: Sequence[Diagnostic]) -> bool:
    """Whether all errors of plain GLSL are about GLSL that only SPIR-V has."""
    errors = [d.message for d in diagnostics if d.severity == "error"]
    return all(map(_SPIRV_ONLY.search, errors))


def in_order(stages: Sequence[Source], targets: Sequence[str]) -> list[Source]:
    """The sources in pipeline order. Raises ShaderError as `compile_program` does."""
    for target in targets:
        if target not in ALL_TARGETS:
            raise ShaderError(
                f"no such compile target: {target!r}", remedy=nearest(target, ALL_TARGETS)
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
