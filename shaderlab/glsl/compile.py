"""One program, several targets: what each compiler says of it, and what it made of it."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from shaderlab.errors import ShaderError, nearest
from shaderlab.glsl.engines import Engine, choose
from shaderlab.glsl.frontend import ENVIRONMENTS
from shaderlab.glsl.sources import STAGES, Source
from shaderlab.glsl.spirv import Interface, reflect
from shaderlab.glsl.targets import check_stages, link_stages, to_spirv
from shaderlab.records import Diagnostic, Verdict

TARGETS = ("glsl", "opengl", "vulkan")
ALL_TARGETS = tuple(ENVIRONMENTS)

# What plain GLSL lacks and GLSL for Vulkan or SPIR-V has; the compiler's words, or a name.
_SPIRV_ONLY = re.compile(
    r"only allowed when (?:using GLSL for Vulkan|generating SPIR-V)"
    r"|'(?:gl_VertexIndex|gl_InstanceIndex|subpassInput\w*|[iu]?texture[123C]\w+|sampler)' : "
)


@dataclass(frozen=True)
class Compiled:
    """What compiling and linking one program gave.

    Attributes:
        verdicts: one a target, in the order asked for.
        spirv: for each SPIR-V target that compiled, each stage's module, with the locations of
            varyings and uniforms made to agree between stages.
        logs: for each target, the compiler's own words: each stage's log, then the link's.
        sources: the stages, in pipeline order.
    """

    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]]
    logs: Mapping[str, str] = field(default_factory=dict)
    sources: tuple[Source, ...] = field(default=(), repr=False)
    _declared: Callable[[], Interface | None] | None = field(
        default=None, repr=False, compare=False
    )

    @property
    def ok(self) -> bool:
        """Whether every target accepts the program."""
        return all(verdict.ok for verdict in self.verdicts)

    @functools.cached_property
    def interface(self) -> Interface | None:
        """What the program declares, read from its OpenGL modules when it is first asked for;
        None where it does not compile for OpenGL."""
        return self._declared() if self._declared else None

    def only(self, targets: Sequence[str]) -> Compiled:
        """The same program with some of its targets alone. What it declares stays known."""
        return replace(
            self,
            verdicts=tuple(verdict for verdict in self.verdicts if verdict.target in targets),
            spirv={target: modules for target, modules in self.spirv.items() if target in targets},
            logs={target: log for target, log in self.logs.items() if target in targets},
        )

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


Compile = Callable[[Sequence[Source], Sequence[str]], Compiled]
"""What compiles a program for some targets, as `compile_program` does."""


def compile_program(
    stages: Sequence[Source], targets: Sequence[str] = TARGETS, *, engine: Engine | None = None
) -> Compiled:
    """Compiles and links one program's stages for each target.

    For "vulkan", samplers are first lifted out of uniform structs, where Vulkan allows none; an
    "info" diagnostic says so.

    A program that plain GLSL rejects is not given to the SPIR-V targets, which can crash on it;
    they are reported as failed for the same reasons. GLSL that only SPIR-V knows, such as
    `layout (constant_id = 0)`, is given to them all the same.

    Args:
        stages: one source a stage, in any order; a single stage is a program too.
        targets: some of `ALL_TARGETS`.
        engine: what to compile with; by default what `engines.choose()` gives.

    Raises:
        ShaderError: no stages, two of one stage, stages that can't be linked, or an unknown
            target; never for what a compiler says of the text, which is in the verdicts.
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
        # One stage that links for OpenGL without a word does so as plain GLSL; half a
        # millisecond saved. Where it does not, the plain link has the first word.
        if target == "opengl" and plain.ok and len(ordered) == 1 and not results[target].linked:
            results["glsl"] = plain = link_stages(plain, ordered, engine)
            if not plain.ok:
                goes_on = False
                results = {done: plain for done in results}

    def declared() -> Interface | None:
        if "opengl" not in results:
            return compile_program(ordered, ("glsl", "opengl"), engine=engine).interface
        modules = results["opengl"].modules
        return reflect(modules) if modules else None

    return Compiled(
        verdicts=tuple(results[target].verdict(target) for target in targets),
        spirv={t: results[t].modules for t in targets if results[t].modules},
        logs={target: results[target].log for target in targets},
        sources=tuple(ordered),
        _declared=functools.cache(declared),
    )


def _is_spirv_only(diagnostics: Sequence[Diagnostic]) -> bool:
    """Whether all that plain GLSL has against a text is that it was written for SPIR-V."""
    errors = [d.message for d in diagnostics if d.severity == "error"]
    return all(map(_SPIRV_ONLY.search, errors))


def in_order(stages: Sequence[Source], targets: Sequence[str]) -> list[Source]:
    """The sources in pipeline order. Raises ShaderError as `compile_program` does."""
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
