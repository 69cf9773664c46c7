"""One target's verdict on a program: the compiler's, then the validator's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from shaderlab.compiler import guards
from shaderlab.compiler.diagnostics import has_errors, of_link, of_stage, of_validator
from shaderlab.compiler.engines import Engine, Linked
from shaderlab.compiler.interstage import match_locations, unwritten_inputs
from shaderlab.compiler.lifting import lift_samplers
from shaderlab.compiler.sources import Source
from shaderlab.compiler.spirv_tools import instruction_count
from shaderlab.compiler.targets import SETTINGS
from shaderlab.model.records import Diagnostic, Verdict


@dataclass(frozen=True)
class Result:
    """One target's verdict in the making.

    Attributes:
        log: the compiler's own words.
        modules: each stage's module, if all are valid.
        valid: SPIRV-Tools' verdict, None if the compiler made no modules.
        linked: whether the compiler linked the stages without a message.
        deadly: whether the text would crash a compiler, and no other may get it.
    """

    diagnostics: tuple[Diagnostic, ...]
    log: str = ""
    modules: Mapping[str, bytes] = field(default_factory=dict)
    valid: bool | None = None
    linked: bool = False
    deadly: bool = False

    @property
    def ok(self) -> bool:
        return not has_errors(self.diagnostics)

    def verdict(self, target: str) -> Verdict:
        """The result as plain data."""
        return Verdict(
            target=target,
            ok=self.ok,
            diagnostics=self.diagnostics,
            spirv_bytes=sum(map(len, self.modules.values())),
            instructions=sum(map(instruction_count, self.modules.values())),
            valid=self.valid,
        )


def check_stages(sources: Sequence[Source], engine: Engine) -> Result:
    """Checks each stage by itself, as plain GLSL."""
    deadly = tuple(d for d in (guards.fatal(source, engine) for source in sources) if d)
    if deadly:
        return Result(deadly, deadly=True)
    diagnostics: list[Diagnostic] = []
    log = ""
    for source in sources:
        checked = engine.check(source)
        log += checked.log
        found = of_stage(checked.log, source) if checked.log else ()
        diagnostics += _consistent(found, checked.ok, source)
    return Result(tuple(diagnostics), log)


def link_stages(plain: Result, sources: Sequence[Source], engine: Engine) -> Result:
    """Links stages that `check_stages` accepted, as plain GLSL."""
    linked = engine.link(sources, "glsl")
    new = [d for d in _of_linked(linked, sources) if d not in plain.diagnostics]
    return Result((*plain.diagnostics, *new), plain.log + linked.log)


def to_spirv(sources: Sequence[Source], target: str, engine: Engine) -> Result:
    """Links the stages, makes SPIR-V for a target and validates it."""
    old = tuple(d for d in (guards.too_old(source, target) for source in sources) if d)
    if old:
        return Result(old)
    notes: tuple[Diagnostic, ...] = ()
    if target == "vulkan":
        sources, notes = lift_samplers(sources, engine)
    linked = engine.link(sources, target)
    log = "".join(linked.stage_logs.values()) + linked.log
    diagnostics = (*notes, *_of_linked(linked, sources)) if log or not linked.ok else notes
    if has_errors(diagnostics):
        return Result(diagnostics, log)
    # Validated before they are read, since glslang can make modules that can't be parsed.
    problems = _invalid(linked.modules, sources, target, engine)
    valid, modules = not problems, linked.modules
    if valid and len(sources) > 1:
        modules = match_locations(linked.modules, sources)
        changed = {s: m for s, m in modules.items() if m != linked.modules[s]}
        problems = [
            *unwritten_inputs(sources, modules),
            *_invalid(changed, sources, target, engine),
        ]
    log += "".join(f"{d.message}\n" for d in problems)
    return Result(
        (*diagnostics, *problems),
        log,
        {} if problems else modules,
        valid,
        linked=not (linked.log or problems),
    )


def _invalid(
    modules: Mapping[str, bytes], sources: Sequence[Source], target: str, engine: Engine
) -> list[Diagnostic]:
    """SPIRV-Tools' errors."""
    environment = SETTINGS[target].environment
    made = [source for source in sources if source.stage in modules]
    messages = [engine.validate(modules[source.stage], environment) for source in made]
    return [
        of_validator(m, source) for m, source in zip(messages, made, strict=True) if m is not None
    ]


def _of_linked(linked: Linked, sources: Sequence[Source]) -> tuple[Diagnostic, ...]:
    found: dict[Diagnostic, None] = {}
    for source in sources:
        found |= dict.fromkeys(of_stage(linked.stage_logs[source.stage], source))
    found |= dict.fromkeys(of_link(linked.log, sources))
    return _consistent(tuple(found), linked.ok, sources[-1])


def _consistent(
    diagnostics: tuple[Diagnostic, ...], ok: bool, source: Source
) -> tuple[Diagnostic, ...]:
    """The diagnostics, with an error added if the compiler failed without reporting one."""
    if ok or has_errors(diagnostics):
        return diagnostics
    message = "the compiler rejects the shader and does not say why"
    return (*diagnostics, source.diagnostic(message))
