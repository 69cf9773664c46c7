"""What is wrong with a program: logs of compilers and drivers as diagnostics at the author's own
file and line, and texts that would crash a compiler."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from tree_sitter import Node

from shaderlab.errors import Diagnostic, Severity, Verdict

from .glslang import SETTINGS, preprocess
from .shader_files import OWN
from .sources import Source
from .syntax import GlslDeclaration, Syntax

_MESSAGE = re.compile(r"^(?P<severity>(?:INTERNAL )?ERROR|WARNING|NOTE): (?P<rest>.*)$")
_PLACED = re.compile(
    r"^(?P<string>-?\d+):(?P<line>\d+): (?:'(?P<token>.*?)' : )?(?P<message>.*)$", re.DOTALL
)
_LINKING = re.compile(r"^Linking (?P<stages>.+?) stages?: (?P<message>.*)$", re.DOTALL)
# Not messages of their own: a count, and a note after the error that ended compilation.
_COUNT = re.compile(r"^\d+ compilation errors\.  No code generated\.$")
_TERMINATED = "compilation terminated"
_SEVERITIES: dict[str, Severity] = {"WARNING": "warning", "NOTE": "info"}
VERSION = r"^[ \t]*#[ \t]*version\b"


def parse_stage_log(log: str, source: Source) -> tuple[Diagnostic, ...]:
    """Return the diagnostics in one stage's log, without duplicates, in the log's order."""
    found: dict[Diagnostic, None] = {}
    for severity, rest in _entries(log.replace(OWN, "")):
        placed = _PLACED.match(rest)
        if _COUNT.match(rest):
            continue
        if placed is None:
            # One about the version is about the line of `#version`.
            at = find_line(VERSION, source) if "version" in rest else None
            message = rest.strip().removeprefix("#version: ")
            found[source.diagnostic(message, at, severity=severity)] = None
        elif (message := placed["message"].strip()) != _TERMINATED:
            token = placed["token"] or ""
            at = int(placed["line"])
            quoted = token == "bad" or message.startswith("no matching")
            row = source.code.split("\n")[at - 1] if quoted else ""
            foreign = "".join(c for c in row if not c.isascii())[:1]
            if token == "bad" and foreign:  # glslang's preprocessor has no other word for it
                token, message = foreign, "unexpected character"
            elif channels := re.findall(rf"\b{re.escape(token)}\s*\(\s*(iChannel\d)", row):
                said = " or ".join(dict.fromkeys(channels))
                message += f"; declare it, if it is no sampler2D: uniform samplerCube {said};"
            worded = f"'{token}' : {message}" if token else message
            found[source.diagnostic(worded, at, severity=severity, token=token)] = None
    return tuple(found)


def parse_link_log(log: str, sources: Sequence[Source]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics in a link's log, which has no lines. A message that quotes a
    declaration, such as `" vec3 normal"`, gets its file and line in the last stage that has it."""
    found: dict[Diagnostic, None] = {}
    for severity, rest in _entries(log):
        linking = _LINKING.match(rest)
        stages = linking["stages"].replace("tessellation ", "tess_") if linking else ""
        involved = [s for s in sources if s.stage in stages] or list(sources)
        source, at, token = _find_declaration(rest, involved)
        found[source.diagnostic(rest.strip(), at, severity=severity, token=token)] = None
    return tuple(found)


def describe_invalid(message: str, source: Source) -> Diagnostic:
    """SPIRV-Tools' message as an error, at the declaration it is about if that is known."""
    text = " ".join(message.split())
    at, token = None, ""
    named = re.search(r"%(\w+) = OpTypeStruct", text)
    if "must not contain an opaque type" in text and named:
        token = named.group(1)
        at = find_line(rf"\bstruct\s+{re.escape(token)}\b", source)
        text = (
            f"'{token}' : Vulkan has no samplers inside structs; declare the sampler as a "
            f"separate uniform [{text}]"
        )
    return source.diagnostic(f"invalid SPIR-V: {text}", at, token=token)


def find_declaration(source: Source, name: str, kind: str = "") -> GlslDeclaration | None:
    """Return the declaration of a global name or of a block's member, whose qualifiers have the
    word `kind`; any by default."""
    for declaration in source.declarations:
        names = {*declaration.declares}
        if declaration.kind == "block":
            names |= {member.name for member in declaration.members}
        if name in names and (not kind or kind in declaration.qualifiers):
            return declaration
    return None


def has_errors(diagnostics: Sequence[Diagnostic]) -> bool:
    return bool(diagnostics) and any(d.severity == "error" for d in diagnostics)


def _entries(log: str) -> Iterator[tuple[Severity, str]]:
    """Yield each message with the indented lines that continue it."""
    severity: Severity = "error"
    rows: list[str] = []
    for row in [*log.split("\n"), "NOTE: "]:
        start = _MESSAGE.match(row)
        if start is None:
            if rows and row.startswith((" ", "\t")) and row.strip():
                rows.append(row)
            continue
        if rows:
            yield severity, "\n".join(rows)
        severity = _SEVERITIES.get(start["severity"], "error")
        rows = [start["rest"]]


def find_line(pattern: str, source: Source) -> int | None:
    """Return the line, counted from 1, where the source's code first has the pattern."""
    match = re.search(pattern, source.code, re.MULTILINE)
    return None if match is None else source.code.count("\n", 0, match.start()) + 1


def _find_declaration(message: str, sources: Sequence[Source]) -> tuple[Source, int | None, str]:
    """Return the declaration that a link message is about: its source, line and name."""
    shown = re.findall(r'"[^"]*?(\w+)(?:\[[^"]*)?"', message)
    listed = re.findall(r"^\s+(\w+)[(:]", message, re.MULTILINE)
    for name in [*reversed(shown), *listed]:
        for source in reversed(sources):
            found = find_declaration(source, name)
            if found:
                return source, found.line, name
    return sources[-1], None, ""


DRIVER = "driver"
"""The target that a driver's verdict is for."""

_FORMS = (
    # Mesa: "0:3(12): error: `x' undeclared"
    re.compile(
        r"^\d+:(?P<line>\d+)\(\d+\): (?:preprocessor )?"
        r"(?P<severity>error|warning): (?P<message>.*)$"
    ),
    # NVIDIA: "0(3) : error C1008: undefined variable"
    re.compile(r"^\d+\((?P<line>\d+)\) ?: (?P<severity>error|warning) (?P<message>.*)$"),
    # AMD, Intel, Apple: "ERROR: 0:3: 'x' : undeclared identifier"
    re.compile(r"^(?P<severity>ERROR|WARNING): \d+:(?P<line>\d+): (?P<message>.*)$"),
    # A message without a line; the empty group keeps the names the same.
    re.compile(r"^(?P<severity>error|warning)\s*:\s*(?P<line>)(?P<message>.*)$", re.IGNORECASE),
)


def parse_driver_log(log: str, source: Source, *, ok: bool) -> tuple[Diagnostic, ...]:
    """Return a driver's log as diagnostics at the author's lines; includes an error unless `ok`."""
    found: dict[Diagnostic, None] = {}
    for row in filter(None, map(str.strip, log.split("\n"))):
        match = next(filter(None, (form.match(row) for form in _FORMS)), None)
        severity: Severity = "info"
        at, message = None, row
        if match:
            severity = "error" if match["severity"].lower() == "error" else "warning"
            at, message = int(match["line"] or 0) or None, match["message"]
        found[source.diagnostic(message, at, severity=severity)] = None
    if not ok and not any(d.severity == "error" for d in found):
        message = "the driver rejects it" + ("" if found else " without a message")
        return (source.diagnostic(message), *found)
    return tuple(found)


def mark_disagreement(verdicts: Iterable[Verdict]) -> tuple[Verdict, ...]:
    """Return the verdicts, with the driver's status "disagrees" if plain GLSL's verdict differs.
    The first diagnostic says so, as a warning: the side that refuses the program has reported its
    errors."""
    by_target = {verdict.target: verdict for verdict in verdicts}
    plain, driver = by_target.get("glsl"), by_target.get(DRIVER)
    if plain and driver and not (plain.status or driver.status) and plain.ok != driver.ok:
        refusing = plain if driver.ok else driver
        first = next(d for d in refusing.diagnostics if d.severity == "error")
        accepts, refuses = ("the driver", "glslang") if driver.ok else ("glslang", "the driver")
        message = f"disagreement: {accepts} accepts what {refuses} refuses: {first.message}"
        note = replace(first, severity="warning", message=message)
        by_target[DRIVER] = replace(
            driver, status="disagrees", diagnostics=(note, *driver.diagnostics)
        )
    return tuple(by_target.values())


# Texts that would crash a compiler are rejected before it gets them.

MAX_NESTING = 200
MAX_OPERATORS = 5000

_OPERATORS = "+-*/%<>=&|^!~,"
_BLOCK = re.compile(r"\b(?:uniform|buffer|in|out)\s+\w+\s*\{")
_DEFINE = re.compile(r"#[ \t]*define\b[ \t]*(.*)")
# A macro for one number or name, or for nothing, does not nest.
_HARMLESS = re.compile(r"\w+(?:[ \t]+(?!(?:if|else|for|while|do|switch)\b)[\w.]+)?[ \t]*$")
# Nodes that nest one level deeper in the compiler, and those that are an operator of an expression.
_NESTING = frozenset([
    "function_definition", "parenthesized_expression", "if_statement", "for_statement",
    "while_statement", "do_statement", "switch_statement",
    "conditional_expression", "argument_list", "subscript_expression", "initializer_list",
])  # fmt: skip
_OPERATING = frozenset([
    "binary_expression", "unary_expression", "assignment_expression", "update_expression",
    "comma_expression",
])  # fmt: skip


def find_crash(source: Source) -> Diagnostic | None:
    """Return an error if the text would crash the compiler, or None."""
    code = source.code
    if "define" in code and not all(map(_HARMLESS.match, _DEFINE.findall(code))):
        code = preprocess(source) or code  # a few macros can expand to many operators
    found = _find_crashing_block(code) or (None if _is_small(code) else _find_deep_nesting(code))
    if found is None:
        return None
    token, message, line = found
    return source.diagnostic(message, line, token=token)


def check_version(source: Source, target: str) -> Diagnostic | None:
    """glslang's error for a `#version` too old for SPIR-V. Below these versions glslang can't parse
    its own built-in functions, and prints all of them to the process's standard output."""
    minimum, name = SETTINGS[target].minimum, SETTINGS[target].api
    version, profile = source.version
    if version >= minimum or profile == "es" or version == 100:
        return None
    at = find_line(VERSION, source) or 1
    message = f"Desktop shaders for {name} SPIR-V require version {minimum} or higher"
    return source.diagnostic(message, at)


def _find_crashing_block(code: str) -> tuple[str, str, int] | None:
    """Return a block that crashes glslang 13: its name is reused for an array with an initialiser,
    or a member has a built-in's name. The token, the message and the line."""
    if not _BLOCK.search(code):
        return None
    for block in Syntax(code).declarations:
        if block.kind != "block" or "{" in block.body:
            continue
        again = re.compile(rf"\b{block.name}\s*(\[[^\]]*\]\s*)+=").search(code, block.end)
        if again:
            line = code.count("\n", 0, again.start()) + 1
            return block.name, f"'{block.name}' : redefinition", line
        word = next((m.name for m in block.members if m.name.startswith("gl_")), None)
        if word is not None and not block.name.startswith("gl_"):
            message = f"'{word}' : identifiers starting with \"gl_\" are reserved"
            line = code.count("\n", 0, code.index(word, block.start)) + 1
            return word, message, line
    return None


def _find_deep_nesting(code: str) -> tuple[str, str, int] | None:
    overflows = "which overflows the compiler's stack"
    cursor = Syntax(code).root.walk()
    nesting = operators = 0
    above: list[tuple[int, int]] = []  # of each node that the cursor is in
    while True:
        node = cursor.node
        assert node is not None
        above.append((nesting, operators))
        nesting += node.type in _NESTING or _is_bare_block(node)
        operators += node.type in _OPERATING
        if nesting > MAX_NESTING:
            what = f"nests deeper than {MAX_NESTING} levels"
            return "", f"{what}, {overflows}", node.start_point[0] + 1
        if operators > MAX_OPERATORS:
            what = f"has a statement of more than {MAX_OPERATORS} operators"
            return "", f"{what}, {overflows}", node.start_point[0] + 1
        if cursor.goto_first_child():
            continue
        nesting, operators = above.pop()
        while not cursor.goto_next_sibling():
            if not cursor.goto_parent():
                return None
            nesting, operators = above.pop()


def _is_bare_block(node: Node) -> bool:
    """Whether a node is a block in a block, not the body of a statement."""
    parent = node.parent if node.type == "compound_statement" else None
    return parent is not None and parent.type == "compound_statement"


def _is_small(code: str) -> bool:
    """Return whether the whole text has no more operators and brackets than one statement may have.
    Going through the tokens of every text would take a tenth of the time to compile it."""
    branches = sum(map(code.count, ("{", "(", "[", "?", "if", "else", "for", "while", "do")))
    return branches <= MAX_NESTING and sum(map(code.count, _OPERATORS)) <= MAX_OPERATORS
