"""Lifts samplers out of uniform structs for Vulkan, which allows none there.

`uniform Material material;` with a member `sampler2D diffuse` becomes a struct without it, a
`uniform sampler2D material_diffuse;` beside it, and `material_diffuse` for `material.diffuse`.
No line moves. If the struct is passed as an argument and then sampled, this can't be done: the
program stays as it is, with SPIRV-Tools' verdict.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from shaderlab.glsl.engines import Engine
from shaderlab.glsl.sources import Source
from shaderlab.records import Diagnostic

_STRUCT = re.compile(r"\bstruct\s+(?P<name>\w+)\s*\{(?P<body>[^{}]*)\}")
_MEMBER = re.compile(r"(?P<all>[^;]*?\b(?P<type>[iu]?(?:sampler|image)\w+)\s+(?P<names>[^;]+);)")
_OPAQUE = re.compile(r"\b[iu]?(?:sampler|image)")
_DECLARATOR = re.compile(r"\s*(?P<name>\w+)\s*(?P<array>\[[^\]]*\])?\s*")


@dataclass(frozen=True)
class _Edit:
    start: int
    end: int
    text: str


@dataclass(frozen=True)
class _Opaque:
    """A member that can't be in a Vulkan struct: its type, name and array suffix."""

    type: str
    name: str
    array: str


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
    edits: list[_Edit] = []
    notes = []
    for struct in _STRUCT.finditer(code):
        opaque, removals = _opaque_members(struct)
        uniforms = list(_uniforms(code, struct["name"])) if opaque else []
        if not uniforms:
            continue
        edits += removals
        for at, variables in uniforms:
            edits.append(_Edit(at, at, _declarations(variables, opaque)))
            for variable, _ in variables:
                edits += _uses(code, variable, opaque)
        line = code.count("\n", 0, struct.start()) + 1
        notes.append(_note(source, line, struct["name"], opaque))
    text = source.text
    for edit in sorted(edits, key=lambda edit: edit.start, reverse=True):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return replace(source, text=text, stripped=None), notes


def _opaque_members(struct: re.Match[str]) -> tuple[list[_Opaque], list[_Edit]]:
    """The struct's samplers and images, and the edits that remove them."""
    found: list[_Opaque] = []
    edits = []
    start = struct.start("body")
    for member in _MEMBER.finditer(struct["body"]):
        for declarator in _DECLARATOR.finditer(member["names"]):
            found.append(_Opaque(member["type"], declarator["name"], declarator["array"] or ""))
        blank = re.sub(r"[^\n]", " ", member["all"])
        edits.append(_Edit(start + member.start(), start + member.end(), blank))
    rest = _MEMBER.sub("", struct["body"])
    if found and not rest.strip():
        # A struct needs a member.
        edits.append(_Edit(struct.end("body"), struct.end("body"), "float lifted;"))
    return found, edits


def _uniforms(code: str, struct: str) -> Iterator[tuple[int, list[tuple[str, str]]]]:
    """Declarations of the struct's uniforms: the place, and each one's name and array suffix."""
    for match in re.finditer(rf"\buniform\s+{struct}\s+([^;=]+);", code):
        declared = [
            (declarator["name"], declarator["array"] or "")
            for declarator in _DECLARATOR.finditer(match[1])
        ]
        yield match.start(), declared


def _declarations(variables: Sequence[tuple[str, str]], opaque: Sequence[_Opaque]) -> str:
    return "".join(
        f"uniform {member.type} {name}_{member.name}{array}{member.array}; "
        for name, array in variables
        for member in opaque
    )


def _uses(code: str, variable: str, opaque: Sequence[_Opaque]) -> Iterator[_Edit]:
    for member in opaque:
        pattern = rf"\b{variable}\s*(\[[^\[\]]*\])?\s*\.\s*{member.name}\b"
        for use in re.finditer(pattern, code):
            yield _Edit(use.start(), use.end(), f"{variable}_{member.name}{use[1] or ''}")


def _note(source: Source, line: int, struct: str, opaque: Sequence[_Opaque]) -> Diagnostic:
    file, place = source.place(line)
    names = ", ".join(member.name for member in opaque)
    message = f"'{struct}' : Vulkan has no samplers in structs; compiled with {names} lifted out"
    return Diagnostic(file=file, line=place, severity="info", message=message, token=struct)
