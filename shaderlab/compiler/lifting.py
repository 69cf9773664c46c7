"""Lifts samplers out of uniform structs for Vulkan, which allows none there.

`uniform Material material;` with a member `sampler2D diffuse` becomes a struct without it, a
`uniform sampler2D material_diffuse;` beside it, and `material_diffuse` for `material.diffuse`.
No line moves. If the struct is passed as an argument and then sampled, this can't be done: the
program stays as it is, with SPIRV-Tools' verdict.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from shaderlab.compiler.engines import Engine
from shaderlab.compiler.sources import Source
from shaderlab.model.records import Diagnostic

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
    for struct in _STRUCT.finditer(code):
        members = list(_MEMBER.finditer(code, *struct.span("body")))
        uniforms = list(re.finditer(rf"\buniform\s+{struct['name']}\s+([^;=]+);", code))
        if not (members and uniforms):
            continue
        opaque = [(m["type"], *own) for m in members for own in _declarators(m["names"])]
        for member in members:
            edits.append((*member.span(), re.sub(r"[^\n]", " ", member["all"])))
        if not _MEMBER.sub("", struct["body"]).strip():
            edits.append((struct.end("body"), struct.end("body"), "float lifted;"))
        for uniform in uniforms:
            declared = ""
            for variable, array in _declarators(uniform[1]):
                for kind, member_name, suffix in opaque:
                    declared += f"uniform {kind} {variable}_{member_name}{array}{suffix}; "
                    pattern = rf"\b{variable}\s*(\[[^\[\]]*\])?\s*\.\s*{member_name}\b"
                    for use in re.finditer(pattern, code):
                        edits.append((*use.span(), f"{variable}_{member_name}{use[1] or ''}"))
            edits.append((uniform.start(), uniform.start(), declared))
        line = code.count("\n", 0, struct.start()) + 1
        name, lifted = struct["name"], ", ".join(own[1] for own in opaque)
        message = f"'{name}' : Vulkan has no samplers in structs; compiled with {lifted} lifted out"
        notes.append(source.diagnostic(message, line, severity="info", token=name))
    text = source.text
    for start, end, new in sorted(edits, key=lambda edit: edit[0], reverse=True):
        text = text[:start] + new + text[end:]
    return replace(source, text=text, stripped=None), notes


def _declarators(names: str) -> list[tuple[str, str]]:
    """The declared names, each with its array suffix or ""."""
    return [(found["name"], found["array"] or "") for found in _DECLARATOR.finditer(names)]
