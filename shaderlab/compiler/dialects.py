"""A program in another dialect than its author's: what Vulkan's rules refuse rewritten, newer
versions for reflection, and what a dialect allows below highp."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from shaderlab.files import display_path
from shaderlab.model.records import Diagnostic

from .diagnostics import VERSION
from .engines import Engine
from .sources import Source

_STRUCT = re.compile(r"\bstruct\s+(?P<name>\w+)\s*\{(?P<body>[^{}]*)\}")
_MEMBER = re.compile(r"(?P<all>[^;]*?\b(?P<type>[iu]?(?:sampler|image)\w+)\s+(?P<names>[^;]+);)")
_OPAQUE = re.compile(r"\b[iu]?(?:sampler|image)")
_DECLARATOR = re.compile(r"\s*(?P<name>\w+)\s*(?P<array>\[[^\]]*\])?\s*")


def lift_samplers(
    sources: Sequence[Source], engine: Engine
) -> tuple[Sequence[Source], tuple[Diagnostic, ...]]:
    """Return the stages with samplers lifted out of uniform structs, and a note on each struct.

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
