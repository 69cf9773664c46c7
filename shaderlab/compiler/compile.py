"""Compiles one program for several targets: verdicts, SPIR-V modules, interface."""

import functools
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from operator import itemgetter

from shaderlab.errors import Diagnostic, ShaderError, Verdict, suggest
from shaderlab.files import display_path

from .diagnostics import (
    check_version,
    describe_invalid,
    find_crash,
    has_errors,
    parse_link_log,
    parse_stage_log,
)
from .dialects import drop_version, raise_version
from .glslang import ALL_TARGETS, SETTINGS, TARGETS, Linked, link, validate
from .module_edits import drop_repeated, find_unwritten_inputs, match_locations
from .reflection import Interface, reflect
from .shader_files import STAGES, is_embedded, version_of
from .sources import Source
from .spirv import count_instructions
from .syntax import Node, Syntax, walk


@dataclass(frozen=True)
class Compiled:
    """A program's verdicts, one for each target in the order they were given, its modules by stage
    for each SPIR-V target that accepts it, in which locations of varyings and uniforms agree
    between stages, and its interface."""

    verdicts: tuple[Verdict, ...]
    spirv: Mapping[str, Mapping[str, bytes]]
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

    def only(self, targets: Sequence[str]) -> "Compiled":
        """Return the program with some of its targets only, and the same interface."""
        return replace(
            self,
            verdicts=tuple(verdict for verdict in self.verdicts if verdict.target in targets),
            spirv={target: modules for target, modules in self.spirv.items() if target in targets},
        )

    def require(self) -> None:
        """Raise ShaderError unless every target accepts the program: the first error of the first
        target that refuses it."""
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


def compile_program(stages: Sequence[Source], targets: Sequence[str] = TARGETS) -> "Compiled":
    """Compile and link one program's stages, in any order, for some of `ALL_TARGETS`. Vulkan allows
    no samplers in uniform structs, so they are lifted out for "vulkan", and an "info" diagnostic
    says so. A SPIR-V target that rejects the same lines as plain GLSL gets its messages, and stages
    that can't be linked go no further. A target's verdict does not depend on the other targets.
    Raises ShaderError: no stages, two of one stage, stages that can't be linked, or an unknown
    target. What is wrong with the text never raises; it is in the verdicts."""
    ordered = order_stages(stages, targets)
    plain = compile_plain(ordered)
    results = {"glsl": plain}
    for target in targets:
        if target not in results:
            results[target] = plain if plain.final else compile_spirv(ordered, target, plain)

    compiled = Compiled(
        verdicts=tuple(results[target].verdict(target) for target in targets),
        spirv={t: results[t].modules for t in targets if results[t].modules},
    )
    return with_interface(compiled, ordered, targets)


def with_interface(
    compiled: Compiled,
    ordered: Sequence[Source],
    targets: Sequence[str],
    compile: Compile = compile_program,
) -> Compiled:
    """Return a program with its sources, and with its interface, which `compile` finds where none
    of the targets tells it."""

    def interface() -> Interface | None:
        if modules := compiled.spirv.get("opengl"):
            return reflect(modules)
        newer = tuple(map(raise_version, ordered))
        compatible = any(source.version[1] == "compatibility" for source in ordered)
        if compatible or ("opengl" in targets and newer == tuple(ordered)):
            return None
        return compile(newer, ("glsl", "opengl")).interface

    return replace(compiled, sources=tuple(ordered), _reflect=interface)


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
    if {source.version for source in ordered} == {(100, ""), (110, "")}:
        # A vertex stage without `#version` may be either.
        ordered = [s if version_of(s.parts[0][1]) else drop_version(s) for s in ordered]
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


@dataclass(frozen=True)
class Result:
    """One target's verdict in the making: each stage's module, if all are `valid`, which is
    SPIRV-Tools' verdict, None without modules. It is `final` if it is the verdict of all targets:
    of stages that parse and can't be linked, and of a text that would crash a compiler."""

    diagnostics: tuple[Diagnostic, ...]
    modules: Mapping[str, bytes] = field(default_factory=dict)
    valid: bool | None = None
    final: bool = False

    @property
    def ok(self) -> bool:
        return not has_errors(self.diagnostics)

    def verdict(self, target: str) -> Verdict:
        return Verdict(
            target=target,
            ok=self.ok,
            diagnostics=self.diagnostics,
            spirv_bytes=sum(map(len, self.modules.values())),
            instructions=sum(map(count_instructions, self.modules.values())),
            valid=self.valid,
        )


def compile_plain(sources: Sequence[Source]) -> Result:
    deadly = tuple(d for d in map(find_crash, sources) if d)
    if deadly:
        return Result(deadly, final=True)
    linked = link(sources, "glsl")
    return Result(_parse_logs(linked, sources), final=linked.parsed and not linked.ok)


def compile_spirv(sources: Sequence[Source], target: str, plain: Result) -> Result:
    """Link the stages, make SPIR-V for a target and validate it. Stages that `plain` GLSL refuses
    may be right for a SPIR-V target, which knows more words. Where it refuses the same lines, what
    plain GLSL says is the answer."""
    newer = [raise_version(s) if is_embedded(*s.version) else s for s in sources]
    if newer != list(sources):
        result = compile_spirv(newer, target, plain)
        message = "compiled as GLSL ES 3.10, the oldest version that can become SPIR-V"
        note = sources[0].diagnostic(message, 1, severity="info")
        return replace(result, diagnostics=(note, *result.diagnostics)) if result.ok else result
    old = tuple(d for d in (check_version(source, target) for source in sources) if d)
    if old:
        return plain if _lines(plain) == _lines(Result(old)) else Result(old)
    if not plain.ok:
        if target == "vulkan":
            # Relaxed rules crash on some mistakes that Vulkan's own rules report.
            strict = [apply_own_rules(source) for source in sources]
            result = _finish(link(strict, "vulkan-strict"), sources, target)
        if target != "vulkan" or result.ok:
            result = _finish(link(sources, target), sources, target)
        return plain if _lines(result) == _lines(plain) else result
    if target == "vulkan":
        lifted, notes = lift_samplers(sources)
        if notes and (linked := link(lifted, target)).ok:
            result = _finish(linked, lifted, target)
            return replace(result, diagnostics=(*notes, *result.diagnostics))
    return _finish(link(sources, target), sources, target)


def _lines(result: Result) -> set[tuple[str | None, int | None]]:
    return {(d.file, d.line) for d in result.diagnostics if d.severity == "error"}


def _finish(linked: Linked, sources: Sequence[Source], target: str) -> Result:
    """Validate what was linked, and let locations agree between stages."""
    diagnostics = _parse_logs(linked, sources)
    if has_errors(diagnostics):
        return Result(diagnostics)
    # Validated before they are read, since glslang can make modules that can't be parsed.
    problems = _validate(linked.modules, sources, target)
    if any("multiple times" in problem.message for problem in problems):
        # glslang decorates twice what is converted to its own type.
        linked = replace(linked, modules={s: drop_repeated(m) for s, m in linked.modules.items()})
        problems = _validate(linked.modules, sources, target)
    valid, modules = not problems, linked.modules
    if valid and len(sources) > 1:
        modules = match_locations(linked.modules, sources)
        changed = {s: m for s, m in modules.items() if m != linked.modules[s]}
        problems = [*find_unwritten_inputs(sources, modules), *_validate(changed, sources, target)]
    return Result((*diagnostics, *problems), {} if problems else modules, valid)


def _validate(
    modules: Mapping[str, bytes], sources: Sequence[Source], target: str
) -> list[Diagnostic]:
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
    if not linked.ok and not has_errors(tuple(found)):
        found[sources[-1].diagnostic("the compiler rejects the shader without a message")] = None
    return tuple(found)


_DIRECTIVE = r"^[ \t]*#[ \t]*(?!define\b)[^\n]*"
_NUMBER = re.compile(
    rf"{_DIRECTIVE}|(?<![\w.])((?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][+-]?\d+)?)[fF]?(?![\w.])", re.M
)
_CONSTANT = re.compile(r"\bconst\s+(?=(?:\w+p\s+)?(?:float|vec[234]|mat[234]\w*)\s)")
_START = re.compile(r"^[ \t]*#[ \t]*(?:version|extension)\b[^\n]*\n", re.M)
_AS_NAME, _AS_NUMBER = str.maketrans(".+-", "pqm"), str.maketrans("pqm", ".+-")
_LITERAL = "shaderlab_literal_"


def keep_literals(source: Source) -> Source:
    """Return a stage in which each float literal is a specialisation constant, so that the compiler
    leaves constant expressions to whoever reads the module; `literal_of` tells its number. Lines
    stay. Not every text compiles so: what must be constant may not be computed of those."""
    names: dict[str, str] = {}

    def name(match: re.Match[str]) -> str:
        number = match[1]
        if not number:
            return match[0]
        return names.setdefault(number, _LITERAL + number.translate(_AS_NAME))

    starts = list(_START.finditer(source.code))
    at = starts[-1].end() if starts else 0
    rest = _CONSTANT.sub("", _NUMBER.sub(name, source.code[at:]))
    if not names or source.version[0] < SETTINGS["opengl"].minimum:
        return source
    line = source.code.count("\n", 0, at) + 1
    declared = ", ".join(f"{name} = {number}" for number, name in names.items())
    text = f"layout (constant_id = 0) const float {declared};\n#line {line}\n{rest}"
    return replace(source, text=source.code[:at] + text, stripped=None)


def literal_of(name: str) -> float | None:
    """Return the number of a constant that `keep_literals` has made, by its name; None of others.

    >>> literal_of("shaderlab_literal_2p5em3")
    0.0025
    """
    if not name.startswith(_LITERAL):
        return None
    return float(name.removeprefix(_LITERAL).translate(_AS_NUMBER))


_OPAQUE = re.compile(r"[iu]?(?:sampler|image)")


def lift_samplers(sources: Sequence[Source]) -> tuple[Sequence[Source], tuple[Diagnostic, ...]]:
    """Return the stages with samplers lifted out of uniform structs, and a note on each struct."""
    lifted, notes = [], []
    for source in sources:
        may = "struct" in source.code and _OPAQUE.search(source.code)
        lifting = Lifting(source) if may else None
        notes += [] if lifting is None else lifting.notes
        lifted.append(lifting.result() if lifting is not None and lifting.notes else source)
    return lifted, tuple(notes)


class Lifting:
    """A stage's text with samplers lifted out of uniform structs: `material.diffuse` becomes
    `material_diffuse`. No line moves."""

    def __init__(self, source: Source) -> None:
        self.notes: list[Diagnostic] = []
        self._source = source
        self._file = Syntax(source.code)
        self._edits: list[tuple[int, int, str]] = []  # start and end in bytes, what comes there
        self._nodes = list(walk(self._file.outline))
        for node in self._nodes:
            body = node.child_by_field_name("body")
            if node.type == "struct_specifier" and body is not None:
                self._lift(node, body)

    def result(self) -> Source:
        text = self._file.bytes
        for start, end, new in sorted(self._edits, key=itemgetter(0), reverse=True):
            text = text[:start] + new.encode() + text[end:]
        return replace(self._source, text=text.decode(), stripped=text.decode())

    def _lift(self, struct: Node, body: Node) -> None:
        name = self._field(struct, "name")
        uniforms = [
            node
            for node in self._nodes
            if node.type == "declaration"
            and self._field(node, "type") == name
            and any(child.type == "uniform" for child in node.children)
        ]
        members = [child for child in body.children if child.type == "field_declaration"]
        opaque = [m for m in members if _OPAQUE.match(self._field(m, "type"))]
        if not (name and uniforms and opaque):
            return
        lifted = []  # the type, name and array of each
        for member in opaque:
            kind = self._field(member, "type")
            lifted += [(kind, *own) for own in self._declarators(member)]
            blank = re.sub(r"[^\n]", " ", self._file.of(member))
            self._edits.append((member.start_byte, member.end_byte, blank))
        if len(opaque) == len(members):
            self._edits.append((body.end_byte - 1, body.end_byte - 1, "float lifted;"))
        for uniform in uniforms:
            texts = ""
            for variable, array in self._declarators(uniform):
                for kind, member_name, suffix in lifted:
                    texts += f"uniform {kind} {variable}_{member_name}{array}{suffix}; "
                self._rename(variable, {member_name for _, member_name, _ in lifted})
            self._edits.append((uniform.start_byte, uniform.start_byte, texts))
        names = ", ".join(member_name for _, member_name, _ in lifted)
        message = f"'{name}' : Vulkan has no samplers in structs; compiled with {names} lifted out"
        line = struct.start_point[0] + 1
        self.notes.append(self._source.diagnostic(message, line, severity="info", token=name))

    def _field(self, node: Node, name: str) -> str:
        """Return the text of a node's field, "" where it has none."""
        found = node.child_by_field_name(name)
        return "" if found is None else self._file.of(found)

    def _rename(self, variable: str, members: Collection[str]) -> None:
        """Rename `variable.member` and `variable[i].member`."""
        for node in self._nodes:
            if node.type == "field_expression":
                member = self._field(node, "field")
                owner, bracket, index = self._field(node, "argument").partition("[")
                if owner.strip() == variable and member in members:
                    new = f"{variable}_{member}{bracket}{index}"
                    self._edits.append((node.start_byte, node.end_byte, new))

    def _declarators(self, node: Node) -> Iterator[tuple[str, str]]:
        """Yield the declared names, each with its array suffix or ""."""
        for declarator in node.children_by_field_name("declarator"):
            name, bracket, length = self._file.of(declarator).partition("[")
            yield name.strip(), bracket + length


_DECLARED = re.compile(r"\b(?:mediump|lowp)\b")
_SAMPLER = re.compile(r"\buniform\s+(sampler2D|samplerCube)\s+(\w+)")


def find_below_highp(source: Source) -> str:
    """Return the first thing that a driver may read or compute at 16 bits or fewer, as a sentence
    that begins with its place; "" if there is none, as in all of desktop GLSL. Without a
    declaration a `sampler2D` and a `samplerCube` are lowp (GLSL ES 3.00, §4.5.4)."""
    code = source.code
    if not is_embedded(*source.version):
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
