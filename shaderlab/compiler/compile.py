"""Compiles one program for several targets: verdicts, SPIR-V modules, interface."""

from __future__ import annotations

import functools
import posixpath
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from shaderlab.errors import ShaderError, suggest
from shaderlab.files import display_path
from shaderlab.model.records import Diagnostic, Verdict

from .diagnostics import (
    VERSION,
    check_version,
    describe_invalid,
    find_crash,
    has_errors,
    parse_link_log,
    parse_stage_log,
)
from .glslang import ALL_TARGETS, SETTINGS, TARGETS, Linked, check, link, validate
from .reflection import Interface, find_unwritten_inputs, match_locations, reflect
from .shader_files import STAGES
from .sources import Source
from .spirv import instruction_count


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
        """Return the program with some of its targets only, and the same interface."""
        return replace(
            self,
            verdicts=tuple(verdict for verdict in self.verdicts if verdict.target in targets),
            spirv={target: modules for target, modules in self.spirv.items() if target in targets},
            logs={target: log for target, log in self.logs.items() if target in targets},
        )

    def require(self) -> None:
        """Raise unless every target accepts the program.

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


def compile_program(stages: Sequence[Source], targets: Sequence[str] = TARGETS) -> Compiled:
    """Compile and link one program's stages for each target.

    Vulkan allows no samplers in uniform structs, so they are lifted out for "vulkan", and an
    "info" diagnostic says so.

    Plain GLSL is compiled whatever the targets are: a SPIR-V target that rejects the same lines
    gets plain GLSL's messages, and stages that can't be linked go no further. A target's verdict
    does not depend on the other targets.

    Args:
        stages: at least one source, in any order; at most one for each stage.
        targets: some of `ALL_TARGETS`.

    Raises:
        ShaderError: no stages, two of one stage, stages that can't be linked, or an unknown
            target. What is wrong with the text never raises; it is in the verdicts.
    """
    ordered = order_stages(stages, targets)
    checked = plain = check_stages(ordered)
    results: dict[str, Result] = {}
    if checked.ok and "opengl" in targets:
        results["opengl"] = compile_spirv(ordered, "opengl")
    if checked.ok and not ("opengl" in results and _links_as_plain(ordered, results["opengl"])):
        plain = link_stages(checked, ordered)
    if not plain.ok:
        results.clear()
    results["glsl"] = plain
    for target in targets:
        if target in results:
            continue
        if not checked.ok:
            results[target] = _compile_refused(ordered, target, plain)
        else:
            results[target] = compile_spirv(ordered, target) if plain.ok else plain

    def interface() -> Interface | None:
        modules = results["opengl"].modules if "opengl" in results else None
        if modules:
            return reflect(modules)
        newer = tuple(map(raise_version, ordered))
        if "opengl" in results and newer == tuple(ordered):
            return None
        return compile_program(newer, ("glsl", "opengl")).interface

    return Compiled(
        verdicts=tuple(
            add_include_notes(results[target].verdict(target), ordered) for target in targets
        ),
        spirv={t: results[t].modules for t in targets if results[t].modules},
        logs={target: results[target].log for target in targets},
        sources=tuple(ordered),
        _reflect=functools.cache(interface),
    )


def _links_as_plain(stages: Sequence[Source], opengl: Result) -> bool:
    """Return whether stages that link for OpenGL without a message link as plain GLSL, too: the
    rules are the same, and parsing them once less saves a fifth of the time to compile them."""
    return opengl.linked and not any("GL_SPIRV" in stage.code for stage in stages)


def _compile_refused(sources: Sequence[Source], target: str, plain: Result) -> Result:
    """Return what a SPIR-V target says of stages that plain GLSL refuses: it may know more words.
    Where it refuses the same lines, what `plain` GLSL says is the answer."""
    if plain.deadly:
        return plain
    if target == "vulkan":
        # Relaxed rules crash on some mistakes that Vulkan's own rules report.
        own = compile_spirv([apply_own_rules(source) for source in sources], "vulkan-strict")
        own = compile_spirv(sources, target) if own.ok else own
    else:
        own = compile_spirv(sources, target)
    return plain if _lines(own) == _lines(plain) else own


def _lines(result: Result) -> set[tuple[str | None, int | None]]:
    return {(d.file, d.line) for d in result.diagnostics if d.severity == "error"}


def order_stages(stages: Sequence[Source], targets: Sequence[str]) -> list[Source]:
    """Return the sources in pipeline order. Raises ShaderError as `compile_program` does."""
    for target in targets:
        if target not in ALL_TARGETS:
            raise ShaderError(
                f"no such compile target: {target!r}", remedy=suggest(target, ALL_TARGETS)
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
            remedy="compile it as a separate program",
        )
    return ordered


_MISSING = ("undeclared identifier", "no matching overloaded function found")
_INCLUDE = re.compile(r"^[ \t]*#[ \t]*include[ \t]*[\"<]([^\">]+)[\">]", re.MULTILINE)


def add_include_notes(verdict: Verdict, sources: Sequence[Source]) -> Verdict:
    """Return the verdict with a note for each name that an included file lacks, at the `#include`
    that the declaration has to precede."""
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


@dataclass(frozen=True)
class Result:
    """One target's verdict in the making.

    Attributes:
        log: the compiler's own words.
        modules: each stage's module, if all are valid.
        valid: SPIRV-Tools' verdict, None if the compiler made no modules.
        linked: whether the compiler linked the stages without a message.
        deadly: whether the text would crash a compiler, so that no other may get it.
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
        """Return the result as plain data."""
        return Verdict(
            target=target,
            ok=self.ok,
            diagnostics=self.diagnostics,
            spirv_bytes=sum(map(len, self.modules.values())),
            instructions=sum(map(instruction_count, self.modules.values())),
            valid=self.valid,
        )


def check_stages(sources: Sequence[Source]) -> Result:
    """Check each stage by itself, as plain GLSL."""
    deadly = tuple(d for d in (find_crash(source) for source in sources) if d)
    if deadly:
        return Result(deadly, deadly=True)
    diagnostics: list[Diagnostic] = []
    log = ""
    for source in sources:
        checked = check(source)
        log += checked.log
        found = parse_stage_log(checked.log, source) if checked.log else ()
        diagnostics += _require_error(found, checked.ok, source)
    return Result(tuple(diagnostics), log)


def link_stages(plain: Result, sources: Sequence[Source]) -> Result:
    """Link stages that `check_stages` accepted, as plain GLSL."""
    linked = link(sources, "glsl")
    new = [d for d in _parse_logs(linked, sources) if d not in plain.diagnostics]
    return Result((*plain.diagnostics, *new), plain.log + linked.log)


def compile_spirv(sources: Sequence[Source], target: str) -> Result:
    """Link the stages, make SPIR-V for a target and validate it."""
    old = tuple(d for d in (check_version(source, target) for source in sources) if d)
    if old:
        return Result(old)
    notes: tuple[Diagnostic, ...] = ()
    if target == "vulkan":
        sources, notes = lift_samplers(sources)
    linked = link(sources, target)
    log = "".join(linked.stage_logs.values()) + linked.log
    diagnostics = (*notes, *_parse_logs(linked, sources)) if log or not linked.ok else notes
    if has_errors(diagnostics):
        return Result(diagnostics, log)
    # Validated before they are read, since glslang can make modules that can't be parsed.
    problems = _validate(linked.modules, sources, target)
    valid, modules = not problems, linked.modules
    if valid and len(sources) > 1:
        modules = match_locations(linked.modules, sources)
        changed = {s: m for s, m in modules.items() if m != linked.modules[s]}
        problems = [
            *find_unwritten_inputs(sources, modules),
            *_validate(changed, sources, target),
        ]
    log += "".join(f"{d.message}\n" for d in problems)
    return Result(
        (*diagnostics, *problems),
        log,
        {} if problems else modules,
        valid,
        linked=not (log or problems),
    )


def _validate(
    modules: Mapping[str, bytes], sources: Sequence[Source], target: str
) -> list[Diagnostic]:
    """SPIRV-Tools' errors."""
    environment = SETTINGS[target].environment
    made = [source for source in sources if source.stage in modules]
    messages = [validate(modules[source.stage], environment) for source in made]
    return [
        describe_invalid(m, source)
        for m, source in zip(messages, made, strict=True)
        if m is not None
    ]


def _parse_logs(linked: Linked, sources: Sequence[Source]) -> tuple[Diagnostic, ...]:
    found: dict[Diagnostic, None] = {}
    for source in sources:
        found |= dict.fromkeys(parse_stage_log(linked.stage_logs[source.stage], source))
    found |= dict.fromkeys(parse_link_log(linked.log, sources))
    return _require_error(tuple(found), linked.ok, sources[-1])


def _require_error(
    diagnostics: tuple[Diagnostic, ...], ok: bool, source: Source
) -> tuple[Diagnostic, ...]:
    """Return the diagnostics, with an error added if the compiler failed without reporting one."""
    if ok or has_errors(diagnostics):
        return diagnostics
    message = "the compiler rejects the shader without a message"
    return (*diagnostics, source.diagnostic(message))


_STRUCT = re.compile(r"\bstruct\s+(?P<name>\w+)\s*\{(?P<body>[^{}]*)\}")
_MEMBER = re.compile(r"(?P<all>[^;]*?\b(?P<type>[iu]?(?:sampler|image)\w+)\s+(?P<names>[^;]+);)")
_OPAQUE = re.compile(r"\b[iu]?(?:sampler|image)")
_DECLARATOR = re.compile(r"\s*(?P<name>\w+)\s*(?P<array>\[[^\]]*\])?\s*")


def lift_samplers(
    sources: Sequence[Source],
) -> tuple[Sequence[Source], tuple[Diagnostic, ...]]:
    """Return the stages with samplers lifted out of uniform structs, and a note on each struct.

    If there is nothing to lift, or it can't be done, the stages are unchanged.
    """
    found = [_lift(source) for source in sources]
    lifted = [source for source, _ in found]
    notes = [note for _, its_notes in found for note in its_notes]
    if not notes or not all(check(source).ok for source in lifted):
        return sources, ()
    return lifted, tuple(notes)


def _lift(source: Source) -> tuple[Source, list[Diagnostic]]:
    code = source.code
    if "struct" not in code or not _OPAQUE.search(code):
        return source, []
    edits: list[tuple[int, int, str]] = []  # start and end in the text, and what comes there
    notes = []
    for block in _STRUCT.finditer(code):
        members = list(_MEMBER.finditer(code, *block.span("body")))
        uniforms = list(re.finditer(rf"\buniform\s+{block['name']}\s+([^;=]+);", code))
        if not (members and uniforms):
            continue
        opaque = [(m["type"], *own) for m in members for own in _declarators(m["names"])]
        for member in members:
            edits.append((*member.span(), re.sub(r"[^\n]", " ", member["all"])))
        if not _MEMBER.sub("", block["body"]).strip():
            edits.append((block.end("body"), block.end("body"), "float lifted;"))
        for uniform in uniforms:
            texts = ""
            for variable, array in _declarators(uniform[1]):
                for kind, member_name, suffix in opaque:
                    texts += f"uniform {kind} {variable}_{member_name}{array}{suffix}; "
                    pattern = rf"\b{variable}\s*(\[[^\[\]]*\])?\s*\.\s*{member_name}\b"
                    for use in re.finditer(pattern, code):
                        edits.append((*use.span(), f"{variable}_{member_name}{use[1] or ''}"))
            edits.append((uniform.start(), uniform.start(), texts))
        line = code.count("\n", 0, block.start()) + 1
        name, lifted = block["name"], ", ".join(own[1] for own in opaque)
        message = f"'{name}' : Vulkan has no samplers in structs; compiled with {lifted} lifted out"
        notes.append(source.diagnostic(message, line, severity="info", token=name))
    text = source.text
    for start, end, new in sorted(edits, key=lambda edit: edit[0], reverse=True):
        text = text[:start] + new + text[end:]
    return replace(source, text=text, stripped=None), notes


def _declarators(names: str) -> list[tuple[str, str]]:
    """Return the declared names, each with its array suffix or ""."""
    return [(found["name"], found["array"] or "") for found in _DECLARATOR.finditer(names)]


_ES = re.compile(r"\s*#\s*version\s+(?:100|3[012]0\s+es)\b")
_DECLARED = re.compile(r"\b(?:mediump|lowp)\b")
_SAMPLER = re.compile(r"\buniform\s+(sampler2D|samplerCube)\s+(\w+)")


def find_below_highp(source: Source) -> str:
    """Return the first thing that a driver may read or compute at 16 bits or fewer, as a sentence
    that begins with its place; "" if there is none, as in all of desktop GLSL.

    Without a declaration a `sampler2D` and a `samplerCube` are lowp (GLSL ES 3.00, §4.5.4).
    """
    code = source.code
    if not _ES.match(code):
        return ""
    found, what = _DECLARED.search(code), ""
    if found is not None:
        what = f"{found[0]} is declared"
    else:
        for sampler in _SAMPLER.finditer(code):
            if not re.search(rf"\bprecision\s+highp\s+{sampler[1]}\b", code):
                found, what = sampler, f"{sampler[2]} is lowp, as no precision is declared"
                break
    if found is None:
        return ""
    file, line = source.lines[code.count("\n", 0, found.start())]
    return (
        f"{display_path(file, line)}: {what}, which drivers may take to 16 bits; bands are those "
        "of highp"
    )


_LOOSE = re.compile(
    r"(?P<uniform>(?:\blayout\s*\([^)]*\)\s*)?\buniform)(?=\s+(?:(?:low|medium|high)p\s+)?(?P<type>\w+)"
    r"\s+\w+\s*(?:\[[^\]]*\]\s*)*[=,;])"
)
_OPAQUE_TYPE = re.compile(r"[iu]?(?:sampler|image|texture|subpassInput)|atomic_uint")
_IDS = {"gl_VertexID": "gl_VertexIndex", "gl_InstanceID": "gl_InstanceIndex"}


def apply_own_rules(source: Source) -> Source:
    """Return the stage without what only relaxed rules allow: plain globals for uniforms outside
    blocks, Vulkan's names of the indices. No line moves."""

    def blank(match: re.Match[str]) -> str:
        if _OPAQUE_TYPE.match(match["type"]):
            return match.group()
        return re.sub(r"\S", " ", match["uniform"])

    code = _LOOSE.sub(blank, source.code)
    for old, new in _IDS.items():
        code = re.sub(rf"\b{old}\b", new, code)
    return source if code == source.code else replace(source, text=code, stripped=code)


def raise_version(source: Source) -> Source:
    """Return the stage in the oldest version that has all its words and can become SPIR-V for
    OpenGL, from which its interface is read: GLSL 3.30 for 1.40 and 1.50, ES 3.10 for ES 3.00."""
    version, profile = source.version
    if (version, profile) == (300, "es"):
        newer = "310 es"
    elif version in (140, 150) and profile in ("", "core"):
        newer = "330"
    else:
        return source
    text = re.sub(f"({VERSION}[ \\t]+)[^\\n]*", rf"\g<1>{newer}", source.text, count=1, flags=re.M)
    return replace(source, text=text, stripped=None)
