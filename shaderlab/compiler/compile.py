"""Compiles one program for several targets: verdicts, SPIR-V modules, interface."""

from __future__ import annotations

import functools
import posixpath
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from shaderlab.compiler.engines import Engine, choose
from shaderlab.compiler.reflection import reflect
from shaderlab.compiler.sources import Source
from shaderlab.compiler.targets import ALL_TARGETS, TARGETS
from shaderlab.compiler.text import STAGES
from shaderlab.compiler.verdicts import Result, check_stages, link_stages, to_spirv
from shaderlab.errors import ShaderError, nearest
from shaderlab.model.records import Diagnostic, Verdict

from .reflection import Interface
from .verdicts import in_dialect, with_interface


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
                notes = [d for d in verdict.diagnostics if d.severity == "info" and d.token]
                note = next((d for d in notes if d.token == errors[0].token), None)
                raise ShaderError(
                    f"{errors[0].message} [{verdict.target}]"
                    + (f" and {len(errors) - 1} more" if len(errors) > 1 else ""),
                    file=errors[0].file,
                    line=errors[0].line,
                    remedy=f"{note.file}:{note.line}: {note.message}" if note else None,
                )


Compile = Callable[[Sequence[Source], Sequence[str]], Compiled]
"""`compile_program` or a function that stands for it."""


def compile_program(
    stages: Sequence[Source], targets: Sequence[str] = TARGETS, *, engine: Engine | None = None
) -> Compiled:
    """Compiles and links one program's stages for each target.

    Vulkan allows no samplers in uniform structs, so they are lifted out for "vulkan", and an
    "info" diagnostic says so.

    Plain GLSL is asked whatever the targets are: a SPIR-V target that refuses a program in the
    same lines gets plain GLSL's messages, and stages that can't be linked go no further. What a
    target says depends on no other target that is asked for.

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
    parsed, results = plain.ok, dict[str, Result]()
    if parsed and "opengl" in targets:
        results["opengl"] = to_spirv(ordered, "opengl", engine)
    if parsed and not ("opengl" in results and _links_as_plain(ordered, results["opengl"])):
        plain = link_stages(plain, ordered, engine)
    if not plain.ok:
        results.clear()
    results["glsl"] = plain
    for target in targets:
        if target in results:
            continue
        if not parsed:
            results[target] = in_dialect(ordered, target, plain, engine)
        else:
            results[target] = to_spirv(ordered, target, engine) if plain.ok else plain

    def interface() -> Interface | None:
        modules = results["opengl"].modules if "opengl" in results else None
        if modules:
            return reflect(modules)
        newer = tuple(map(with_interface, ordered))
        if "opengl" in results and newer == tuple(ordered):
            return None
        return compile_program(newer, ("glsl", "opengl"), engine=engine).interface

    return Compiled(
        verdicts=tuple(
            with_include_notes(results[target].verdict(target), ordered) for target in targets
        ),
        spirv={t: results[t].modules for t in targets if results[t].modules},
        logs={target: results[target].log for target in targets},
        sources=tuple(ordered),
        _reflect=functools.cache(interface),
    )


def _links_as_plain(stages: Sequence[Source], opengl: Result) -> bool:
    """Whether plain GLSL has no more to say of stages that are linked for OpenGL: its rules for
    links are the same, and it takes half a millisecond to ask."""
    # Where one stage alone has a warning, both have it.
    said = len(stages) > 1 and opengl.log
    return opengl.linked and not said and not any("GL_SPIRV" in stage.code for stage in stages)


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


_MISSING = ("undeclared identifier", "no matching overloaded function found")
_INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*[\"<]([^\">]+)[\">]", re.MULTILINE)


def with_include_notes(verdict: Verdict, sources: Sequence[Source]) -> Verdict:
    """The verdict with a note for each name that an included file lacks, at the `#include` that the
    declaration has to precede."""
    notes: dict[Diagnostic, None] = {}
    for diagnostic in verdict.diagnostics:
        if diagnostic.severity == "error" and diagnostic.message.endswith(_MISSING):
            for source in sources:
                notes |= dict.fromkeys(_notes(diagnostic, source))
    return replace(verdict, diagnostics=(*verdict.diagnostics, *notes)) if notes else verdict


def _notes(diagnostic: Diagnostic, source: Source) -> Iterator[Diagnostic]:
    parts = dict(source.parts)
    if diagnostic.file == source.path or diagnostic.file not in parts:
        return
    name = posixpath.basename(diagnostic.file)
    for file, text in parts.items():
        for found in _INCLUDE.finditer(text):
            if posixpath.basename(found[1]) == name:
                yield Diagnostic(
                    file=file,
                    line=text.count("\n", 0, found.start()) + 1,
                    severity="info",
                    message=f"{name}, included here, needs {diagnostic.token!r} declared before it",
                    token=diagnostic.token,
                )
