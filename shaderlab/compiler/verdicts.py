"""One target's verdict on a program: the compiler's, then the validator's."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from shaderlab.files import display_path
from shaderlab.model.records import Diagnostic, Verdict

from . import verdicts
from .diagnostics import VERSION, declaration, has_errors, line_of, of_link, of_stage, of_validator
from .engines import Engine, Linked
from .reflection import stage_variables
from .sources import Source
from .spirv import (
    OPAQUE,
    Decoration,
    Module,
    Op,
    StorageClass,
    elements_of,
    leaves_count,
    parse,
    slots,
    unwrap,
)
from .spirv_tools import instruction_count
from .targets import SETTINGS
from .text import STAGES


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
    deadly = tuple(d for d in (verdicts.fatal(source, engine) for source in sources) if d)
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
    old = tuple(d for d in (verdicts.too_old(source, target) for source in sources) if d)
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


_STRUCT = re.compile(r"\bstruct\s+(?P<name>\w+)\s*\{(?P<body>[^{}]*)\}")
_MEMBER = re.compile(r"(?P<all>[^;]*?\b(?P<type>[iu]?(?:sampler|image)\w+)\s+(?P<names>[^;]+);)")
_OPAQUE = re.compile(r"\b[iu]?(?:sampler|image)")
_DECLARATOR = re.compile(r"\s*(?P<name>\w+)\s*(?P<array>\[[^\]]*\])?\s*")


def lift_samplers(
    sources: Sequence[Source], engine: Engine
) -> tuple[Sequence[Source], tuple[Diagnostic, ...]]:
    """The stages with samplers lifted out of uniform structs, and a note on each struct.

    If there is nothing to lift, or it can't be done, the stages are unchanged.
    """
    lifted, notes = [], []
    for source in sources:
        new, its_notes = _lift(source)
        lifted.append(new)
        notes += its_notes
    if not notes or not all(engine.check(source).ok for source in lifted):
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
    """The declared names, each with its array suffix or ""."""
    return [(found["name"], found["array"] or "") for found in _DECLARATOR.finditer(names)]


_NUMBERED = (StorageClass.UniformConstant, StorageClass.Uniform, StorageClass.StorageBuffer)
_Words = Mapping[str, list[int]]
"""The modules' words by stage."""


@dataclass(frozen=True)
class _Use:
    """A stage's numbers for a name: the index of the first one's word, how many there are, and the
    author's qualifier for them, "location" or "binding"."""

    stage: str
    word: int
    count: int
    qualifier: str

    def numbers(self, words: _Words) -> range:
        start = words[self.stage][self.word]
        return range(start, start + self.count)


def match_locations(modules: Mapping[str, bytes], sources: Sequence[Source]) -> dict[str, bytes]:
    """The modules with numbers that agree between stages.

    Each input gets the location of the previous stage's output of that name, and each uniform,
    sampler and block gets one location and one binding in all stages. Numbers that the author
    wrote stay. Modules that agree already are not changed.
    """
    if len(modules) == 1:
        return dict(modules)
    parsed = {stage: parse(data) for stage, data in modules.items()}
    words = {stage: list(module.words) for stage, module in parsed.items()}
    for writer, reader in pairwise(stage for stage in STAGES if stage in parsed):
        _move_inputs(parsed[writer], parsed[reader], words[writer], words[reader])
    for uses_by_name in _namespaces(parsed):
        _renumber(uses_by_name, words, sources)
    return {
        stage: data
        if tuple(words[stage]) == parsed[stage].words
        else struct.pack(f"{len(words[stage])}I", *words[stage])
        for stage, data in modules.items()
    }


def unwritten_inputs(
    sources: Sequence[Source], modules: Mapping[str, bytes]
) -> tuple[Diagnostic, ...]:
    """An error for each input that a stage uses and the previous stage does not declare, or
    declares with another type at the location that the author gave to both."""
    found = []
    by_stage = {source.stage: source for source in sources}
    for writer, reader in pairwise(stage for stage in STAGES if stage in modules):
        outputs = list(stage_variables(parse(modules[writer]), StorageClass.Output))
        written = {_without_indices(v.name) for v in outputs}
        at = {v.location: v for v in outputs if v.location is not None}
        source = by_stage[reader]
        inputs = stage_variables(parse(modules[reader]), StorageClass.Input)
        for name, variable in {_without_indices(v.name): v for v in inputs if v.used}.items():
            if name in written:
                continue
            declared = declaration(source, name.rpartition(".")[2], "in")
            message = f"'{name}' : input of the {reader} stage that the {writer} stage never writes"
            if declared is not None and "location" in declared[1]:
                other = None if variable.location is None else at.get(variable.location)
                if other is None or other.type == variable.type:
                    continue
                message = (
                    f"'{name}' : {variable.type} at location {variable.location}, where the "
                    f"{writer} stage writes the {other.type} '{other.name}'"
                )
            at_line = declared[0] if declared else None
            found.append(source.diagnostic(message, at_line, token=name))
    return tuple(found)


def interface_name(module: Module, id_: int) -> str:
    """The name that a variable has in all stages: its block's, or its own."""
    element = unwrap(module, module.variables[id_][0])[1]
    blocks = (Decoration.Block, Decoration.BufferBlock)
    is_block = any(module.decorated(element, block) is not None for block in blocks)
    return module.names.get(element if is_block else id_, "")


def _without_indices(name: str) -> str:
    """A name without array indices, which geometry and tessellation stages add by vertex."""
    return "".join(part.partition("]")[2] if i else part for i, part in enumerate(name.split("[")))


def _located(module: Module, storage: int) -> dict[str, tuple[int, int]]:
    """A storage class's variables that have a location, by interface name: the index of the
    location's word, and how many locations the variable takes."""
    return {
        interface_name(module, id_): (
            module.decoration_words[id_, Decoration.Location],
            slots(module, pointee),
        )
        for id_, (pointee, its_storage) in module.variables.items()
        if its_storage == storage and module.number(id_, Decoration.Location) is not None
    }


def _move_inputs(
    writer: Module, reader: Module, writer_words: Sequence[int], reader_words: list[int]
) -> None:
    """Moves the reader's inputs to the locations of their outputs, and others out of their way."""
    outputs, inputs = _located(writer, StorageClass.Output), _located(reader, StorageClass.Input)
    occupied: set[int] = set()
    for name, (at, _) in inputs.items():
        if name in outputs:
            word, count = outputs[name]
            reader_words[at] = writer_words[word]
            occupied.update(range(reader_words[at], reader_words[at] + count))
    for name, (at, count) in inputs.items():
        if name not in outputs:
            if occupied.intersection(range(reader_words[at], reader_words[at] + count)):
                reader_words[at] = max(occupied) + 1
            occupied.update(range(reader_words[at], reader_words[at] + count))


def _namespaces(parsed: Mapping[str, Module]) -> Iterator[Mapping[str, Sequence[_Use]]]:
    """For each range of numbers that a program's stages share, its uses by name.

    OpenGL numbers uniform locations, texture units, image units, uniform and storage blocks
    separately; Vulkan has one range of bindings for each descriptor set.
    """
    found: dict[object, dict[str, list[_Use]]] = {}
    for stage, module in parsed.items():
        for id_, (_, storage) in module.variables.items():
            for namespace, qualifier, count in _numbers(module, id_, storage):
                kind = Decoration.Location if qualifier == "location" else Decoration.Binding
                use = _Use(stage, module.decoration_words[id_, kind], count, qualifier)
                names = found.setdefault(namespace, {})
                names.setdefault(interface_name(module, id_), []).append(use)
    yield from found.values()


def _numbers(module: Module, id_: int, storage: int) -> Iterator[tuple[object, str, int]]:
    """The numbers that a variable takes: their range's key, the author's qualifier, how many."""
    if storage not in _NUMBERED:
        return
    pointee = module.variables[id_][0]
    lengths, element = unwrap(module, pointee)
    if module.number(id_, Decoration.Location) is not None:
        yield "location", "location", leaves_count(module, pointee)
    if module.number(id_, Decoration.Binding) is None:
        return
    descriptor_set = module.number(id_, Decoration.DescriptorSet)
    if descriptor_set is not None:
        yield ("set", descriptor_set), "binding", 1
    elif storage != StorageClass.UniformConstant:
        stored = module.decorated(element, Decoration.BufferBlock) is not None
        yield "storage" if stored else "uniform", "binding", elements_of(lengths)
    elif module.types[element].op in OPAQUE:
        image = module.types[element].op == Op.TypeImage
        yield "image" if image else "unit", "binding", elements_of(lengths)


def _renumber(
    uses_by_name: Mapping[str, Sequence[_Use]], words: _Words, sources: Sequence[Source]
) -> None:
    """Renumbers the names of a range if two stages disagree about them."""
    if _agree(uses_by_name, words):
        return
    fixed = {name for name, uses in uses_by_name.items() if _by_author(name, uses, sources)}
    taken = {n for name in fixed for use in uses_by_name[name] for n in use.numbers(words)}
    for name, uses in uses_by_name.items():
        if name in fixed:
            continue
        count = max(use.count for use in uses)
        start = 0
        while taken.intersection(range(start, start + count)):
            start += 1
        taken.update(range(start, start + count))
        for use in uses:
            words[use.stage][use.word] = start


def _agree(uses_by_name: Mapping[str, Sequence[_Use]], words: _Words) -> bool:
    """Whether each name has one number in all stages, and each number one name."""
    owner: dict[int, str] = {}
    return all(
        len({words[use.stage][use.word] for use in uses}) == 1
        and all(owner.setdefault(n, name) == name for use in uses for n in use.numbers(words))
        for name, uses in uses_by_name.items()
    )


def _by_author(name: str, uses: Sequence[_Use], sources: Sequence[Source]) -> bool:
    """Whether the author wrote the name's number in one of the stages that use it."""
    stages, qualifier = {use.stage for use in uses}, uses[0].qualifier
    may = [s for s in sources if s.stage in stages and name and qualifier in s.code]
    return any(found and qualifier in found[1] for found in (declaration(s, name) for s in may))


_ES = re.compile(r"\s*#\s*version\s+(?:100|3[012]0\s+es)\b")
_DECLARED = re.compile(r"\b(?:mediump|lowp)\b")
_SAMPLER = re.compile(r"\buniform\s+(sampler2D|samplerCube)\s+(\w+)")


def below_highp(source: Source) -> str:
    """The first thing that a driver may read or compute at 16 bits or fewer, as a sentence that
    begins with its place; "" if there is none, as in all of desktop GLSL.

    What is said nowhere is lowp for a `sampler2D` and a `samplerCube` (GLSL ES 3.00, §4.5.4).
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
_OPAQUE_dialects = re.compile(r"[iu]?(?:sampler|image|texture|subpassInput)|atomic_uint")
_IDS = {"gl_VertexID": "gl_VertexIndex", "gl_InstanceID": "gl_InstanceIndex"}


def in_dialect(sources: Sequence[Source], target: str, plain: Result, engine: Engine) -> Result:
    """What a SPIR-V target says of stages that plain GLSL refuses: it may know more words.

    Args:
        sources: the stages.
        target: one with SPIR-V.
        plain: what plain GLSL says; it is the answer if the target refuses the same lines.
        engine: the compiler.
    """
    if plain.deadly:
        return plain
    if target == "vulkan":
        # Relaxed rules crash on some mistakes that Vulkan's own rules report.
        own = to_spirv([_by_own_rules(source) for source in sources], "vulkan-strict", engine)
        own = to_spirv(sources, target, engine) if own.ok else own
    else:
        own = to_spirv(sources, target, engine)
    return plain if _lines(own) == _lines(plain) else own


def _lines(result: Result) -> set[tuple[str | None, int | None]]:
    errors: list[Diagnostic] = [d for d in result.diagnostics if d.severity == "error"]
    return {(d.file, d.line) for d in errors}


def _by_own_rules(source: Source) -> Source:
    """The stage without what only relaxed rules allow: plain globals for uniforms outside blocks,
    Vulkan's names of the indices. No line moves."""

    def blank(match: re.Match[str]) -> str:
        if _OPAQUE_dialects.match(match["type"]):
            return match.group()
        return re.sub(r"\S", " ", match["uniform"])

    code = _LOOSE.sub(blank, source.code)
    for old, new in _IDS.items():
        code = re.sub(rf"\b{old}\b", new, code)
    return source if code == source.code else replace(source, text=code, stripped=code)


def with_interface(source: Source) -> Source:
    """The stage in the oldest version that has all its words and can become SPIR-V for OpenGL, from
    which its interface is read: GLSL 3.30 for 1.40 and 1.50, ES 3.10 for ES 3.00."""
    version, profile = source.version
    if (version, profile) == (300, "es"):
        newer = "310 es"
    elif version in (140, 150) and profile in ("", "core"):
        newer = "330"
    else:
        return source
    text = re.sub(f"({VERSION}[ \\t]+)[^\\n]*", rf"\g<1>{newer}", source.text, count=1, flags=re.M)
    return replace(source, text=text, stripped=None)


MAX_NESTING = 200
MAX_OPERATORS = 5000

_OPERATORS = "+-*/%<>=&|^!~,"
_TOKEN = re.compile(r"\w+|[(){}\[\];?\n]|[-+*/%<>=&|^!~,]")
_BLOCK = re.compile(r"\b(?:uniform|buffer|in|out)\s+(\w+)\s*\Z")
_LONGEST_NAME = 1024  # GLSL's own limit
# After a type or another name; what an expression says of a built-in crashes nothing.
_BUILT_IN_MEMBER = re.compile(r"(?:[\w\]]\s+|,\s*)(gl_\w+)\s*[;,\[]")
_DEFINE = re.compile(r"#[ \t]*define\b[ \t]*(.*)")
# A macro for one number or name, or for nothing, does not nest.
_HARMLESS = re.compile(r"\w+(?:[ \t]+(?!(?:if|else|for|while|do|switch)\b)[\w.]+)?[ \t]*$")
_BRANCHES = frozenset(["if", "else", "for", "while", "do", "switch", "?"])


def fatal(source: Source, engine: Engine) -> Diagnostic | None:
    """An error if the text would crash the compiler, or None."""
    code = source.code
    if "define" in code and not all(map(_HARMLESS.match, _DEFINE.findall(code))):
        code = engine.preprocess(source) or code  # a few macros can expand to many operators
    found = _crashing_block(code) or (None if _is_small(code) else _too_deep(code))
    if found is None:
        return None
    token, message, line = found
    return source.diagnostic(message, line, token=token)


def too_old(source: Source, target: str) -> Diagnostic | None:
    """glslang's error for a `#version` too old for SPIR-V.

    Below these versions glslang can't parse its own built-in functions, and prints all of them
    to the process's standard output.
    """
    minimum, name = SETTINGS[target].minimum, SETTINGS[target].api
    version, profile = source.version
    if version >= minimum or profile == "es" or version == 100:
        return None
    at = line_of(VERSION, source) or 1
    message = f"Desktop shaders for {name} SPIR-V require version {minimum} or higher"
    return source.diagnostic(message, at)


def _crashing_block(code: str) -> tuple[str, str, int] | None:
    """A block that crashes glslang 13: its name is reused for an array with an initialiser, or a
    member has a built-in's name. The token, the message and the line."""
    for name, start in _blocks(code):
        again = re.compile(rf"\b{name}\s*(\[[^\]]*\]\s*)+=").search(code, start)
        if again:
            return name, f"'{name}' : redefinition", code.count("\n", 0, again.start()) + 1
        end = code.find("}", start)
        member = _BUILT_IN_MEMBER.search(code, start, end if end >= 0 else len(code))
        if member and not name.startswith("gl_"):
            word = member.group(1)
            message = f"'{word}' : identifiers starting with \"gl_\" are reserved"
            return word, message, code.count("\n", 0, member.start(1)) + 1
    return None


def _blocks(code: str) -> Iterator[tuple[str, int]]:
    """The interface blocks' names, and where their members start."""
    # Searching back from each brace is eight times as fast as one regular expression.
    brace = code.find("{")
    while brace >= 0:
        before = code[max(brace - _LONGEST_NAME - 64, 0) : brace].rstrip()
        if not before.endswith(")"):  # a function's body, a loop's, a branch's
            block = _BLOCK.search(" ".join(before.rsplit(None, 2)[-2:]))
            if block:
                yield block.group(1), brace + 1
        brace = code.find("{", brace + 1)


def _too_deep(code: str) -> tuple[str, str, int] | None:
    for line, nesting, operators in _depths(code):
        what = ""
        if nesting > MAX_NESTING:
            what = f"nests deeper than {MAX_NESTING} levels"
        elif operators > MAX_OPERATORS:
            what = f"has a statement of more than {MAX_OPERATORS} operators"
        if what:
            return "", f"{what}, which overflows the compiler's stack", line
    return None


def _is_small(code: str) -> bool:
    """Whether the whole text has no more operators and brackets than one statement may have."""
    branches = sum(map(code.count, ("{", "(", "[", "?", "if", "else", "for", "while", "do")))
    if branches > MAX_NESTING:
        return False
    return len(code) <= MAX_OPERATORS or sum(map(code.count, _OPERATORS)) <= MAX_OPERATORS


def _depths(code: str) -> Iterator[tuple[int, int, int]]:
    """For each token: its line, its nesting depth, and the operators so far in its expression."""
    line, branches, before = 1, 0, ";"
    inside = [_Bracket(is_list=False)]
    for match in _TOKEN.finditer(code):
        token = match.group()
        if token == "\n":
            line += 1
            continue
        here = inside[-1]
        if before in ";}":
            branches = here.operators = 0
            here.chain = here.chain + 1 if token == "else" else 0
        if token in "([{":
            branches = 0 if token == "{" else branches
            inside.append(_Bracket(is_list=_opens_list(token, before)))
        elif token in ")]}":
            del inside[max(len(inside) - 1, 1) :]
        elif token in _BRANCHES:
            branches += 1
        elif token == "," and here.is_list:
            here.operators = 0
        elif token in _OPERATORS:
            here.operators += 1
        before = token
        yield line, len(inside) + sum(b.chain for b in inside) + branches, inside[-1].operators


@dataclass
class _Bracket:
    """An open bracket: whether its commas separate a list, and so far the `else`s in the chain of
    branches, and the operators in the expression."""

    is_list: bool
    chain: int = 0
    operators: int = 0


def _opens_list(token: str, before: str) -> bool:
    """Whether commas after the bracket separate arguments or elements, not operands."""
    return before[-1].isalnum() or before in "]_" if token == "(" else before in "=,({"
