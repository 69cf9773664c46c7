"""A file's functions as fragment shaders: arguments are inputs, results outputs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

from shaderlab.compiler.sources import LineMap, Source
from shaderlab.functions.declarations import declarations
from shaderlab.functions.kernels import own
from shaderlab.functions.signatures import PREFIX, Signature, declaration, signatures
from shaderlab.functions.types import Type

_RANGES = {"bool": " // range: 0..1"}
_VERSION = re.compile(r"#version \d+")


@dataclass(frozen=True)
class EntryPoint:
    """A function with a `main` that calls it once.

    Attributes:
        signature: the function.
        sources: the fragment shader, by one version of GLSL after the other that may take it;
            inputs have the parameters' names.
    """

    signature: Signature
    sources: tuple[Source, ...]


def entry_points(source: Source, preprocessed: str, versions: Sequence[int]) -> list[EntryPoint]:
    """The functions that a file defines itself, not in what it includes, in order.

    Args:
        source: the file, with a `#version`.
        preprocessed: its text after the preprocessor, line for line.
        versions: to try, where the file says none.

    Raises:
        ShaderError: its brackets do not match.
    """
    known = declarations(preprocessed)
    taken = {name for item in known.items for name in item.declares}
    own_file = source.parts[0][0] if source.parts else source.path
    found = []
    for overloads in signatures(known).values():
        for signature in overloads:
            place = source.place(signature.line)
            if place[0] == own_file:
                made = _source(source, signature, place, taken)
                found.append(EntryPoint(signature, _by_version(made, versions)))
    return sorted(found, key=lambda one: one.signature.line)


def _source(
    source: Source, signature: Signature, place: tuple[str, int], taken: Collection[str]
) -> Source:
    added = "\n".join(_main(signature, taken)) + "\n"
    spans = [(*source.place(n + 1), 1) for n in range(source.text.count("\n") + 1)]
    spans += [(*place, 1)] * added.count("\n")
    text = f"{source.text}\n{added}"
    return replace(source, stage="fragment", text=text, lines=LineMap.of(spans), stripped=None)


def _by_version(source: Source, versions: Sequence[int]) -> tuple[Source, ...]:
    if len(versions) == 1:
        return (source,)
    texts = [_VERSION.sub(f"#version {number}", source.text, count=1) for number in versions]
    return tuple(replace(source, text=text) for text in texts)


def _main(signature: Signature, taken: Collection[str]) -> Iterator[str]:
    """Inputs, outputs and the `main` between them."""
    body, arguments, written = [], [], []
    for parameter in signature.parameters:
        name = own(parameter.name)
        arguments.append(name)
        if parameter.type.opaque:
            arguments[-1] = _free(parameter.name, taken)
            yield f"uniform {declaration(parameter.type, arguments[-1])};"
            continue
        body.append(f"{declaration(parameter.type, name)};")
        if parameter.direction != "out":
            for target, label, kind in _leaves(name, parameter.name, parameter.type):
                given = _free(label, taken)
                held = _held(kind)
                flat = "" if kind.kind == "float" else "flat "
                yield f"{flat}in {held} {given};{_RANGES.get(kind.kind, '')}"
                body.append(f"{target} = {kind.name}({given});")
        if parameter.direction != "in":
            after = "_after" if parameter.direction == "inout" else ""
            written.append((name, parameter.name + after, parameter.type))
    call = f"{signature.name}({', '.join(arguments)})"
    if signature.result.name != "void":
        result = f"{PREFIX}result"
        dims = "".join(f"[{n}]" for n in signature.result.dims)
        call = f"{signature.result.name}{dims} {result} = {call}"
        written.insert(0, (result, signature.outputs[0][0], signature.result))
    body.append(f"{call};")
    for value, name, kind in written:
        for target, label, leaf in _leaves(value, name, kind):
            for n, (part, held) in enumerate(_columns(target, leaf)):
                out = _free(f"{label}_{n}" if len(leaf.base_shape) == 2 else label, taken)
                yield f"out {held} {out};"
                body.append(f"{out} = {held}({part});")
    yield "void main() {"
    yield from body
    yield "}"


def _leaves(target: str, label: str, kind: Type) -> Iterator[tuple[str, str, Type]]:
    """The numbers, vectors and matrices of a value, each with a name of its own."""
    if kind.dims:
        for n in range(kind.dims[0]):
            yield from _leaves(f"{target}[{n}]", f"{label}_{n}", kind.element)
    elif kind.members:
        for name, member in kind.members:
            yield from _leaves(f"{target}.{name}", f"{label}_{name}", member)
    else:
        yield target, label, kind


def _held(kind: Type) -> str:
    """The type that carries such a value between stages, which have no conditions."""
    return re.sub(r"^bool$", "int", re.sub(r"^bvec", "ivec", kind.name))


def _columns(value: str, kind: Type) -> Iterator[tuple[str, str]]:
    """What is written of a value, with its type: matrices column by column."""
    if len(kind.base_shape) < 2:
        yield value, _held(kind)
        return
    rows, columns = kind.base_shape
    for n in range(columns):
        yield f"{value}[{n}]", f"vec{rows}"


def _free(name: str, taken: Collection[str]) -> str:
    """The name, or one like it where the file has something of this name."""
    while name in taken:
        name += "_"
    return name
