"""The fragment shader that calls a function for each element of arrays.

Arguments that differ from element to element come as layers of one texture, a 32-bit word each;
those that are the same for all as one array of words; results leave as words, one an attachment.
A pixel stands for one element.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from shaderlab.functions.signatures import PREFIX, Input, Signature, Type, declare, rename

MAX_WORDS = 8
"""Attachments that every driver has; what is more goes into another pass."""
_UNROLLED = 8
_INPUT, _SHARED = f"{PREFIX}input", f"{PREFIX}shared"
_READS = {
    "float": "uintBitsToFloat({})", "int": "int({})", "uint": "{}", "bool": "(({}) != 0u)",
}  # fmt: skip
_WRITES = {
    "float": "floatBitsToUint({})", "int": "uint({})", "uint": "{}", "bool": "({} ? 1u : 0u)",
}  # fmt: skip


@dataclass(frozen=True)
class Kernel:
    """A function's shader for one way to give its arguments.

    Attributes:
        signature: the function.
        varying: the arguments that differ from element to element, in their order.
        shared: those that are the same for all.
        opaque: those that stay uniforms: samplers, and structs with samplers.
    """

    signature: Signature
    varying: tuple[Input, ...]
    shared: tuple[Input, ...]
    opaque: tuple[Input, ...]

    @property
    def planes(self) -> int:
        """How many layers the varying arguments take."""
        return sum(i.type.words for i in self.varying)

    @property
    def shared_words(self) -> int:
        """How many words the shared arguments take."""
        return sum(i.type.words for i in self.shared)

    @property
    def result_words(self) -> int:
        """How many words a call returns; one more than its outputs' where it may discard."""
        words = sum(kind.words for _, kind in self.signature.outputs)
        return words + self.signature.discards

    def head(self, version: int, words: int) -> str:
        """What comes before the function's own text, for a pass that writes so many words."""
        lines = [f"#version {version} core"]
        lines += [e.replace("require", "enable") for e in self.signature.extensions]
        if self.varying:
            lines.append(f"uniform usampler2DArray {_INPUT};")
        if self.shared:
            lines.append(f"uniform uvec4 {_SHARED}[{-(-self.shared_words // 4)}];")
        for n in range(words):
            lines.append(f"layout(location = {n}) out uint {PREFIX}out{n};")
        return "\n".join(lines) + "\n"

    def main(self, first: int, words: int) -> str:
        """What comes after it: `main`, writing `words` words of the results from the first on."""
        signature = self.signature
        parameters = {p.name for p in signature.parameters}
        opaque = [i for i in self.opaque if i.name in parameters]
        lines = [f"uniform {declare(i.type, local_name(i.name))};" for i in opaque]
        lines.append("void main() {")
        if self.varying:
            size = f"textureSize({_INPUT}, 0).xy - 1"
            lines.append(f"  uint {PREFIX}words[{self.planes}];")
            lines.append(f"  ivec2 {PREFIX}place = min(ivec2(gl_FragCoord.xy), {size});")
            lines.append(f"  for (int n = 0; n < {self.planes}; n++)")
            fetch = f"texelFetch({_INPUT}, ivec3({PREFIX}place, n), 0).x"
            lines.append(f"    {PREFIX}words[n] = {fetch};")
        lines += self._reading()
        for parameter in signature.parameters:
            if parameter.direction == "out":
                lines.append(f"  {declare(parameter.type, local_name(parameter.name))};")
        call = f"{signature.name}({', '.join(local_name(p.name) for p in signature.parameters)})"
        values = [local_name(p.name) for p in signature.parameters if p.direction != "in"]
        if signature.result.name != "void":
            dims = "".join(f"[{n}]" for n in signature.result.dims)
            call = f"{signature.result.name}{dims} {PREFIX}result = {call}"
            values.insert(0, f"{PREFIX}result")
        lines.append(f"  {call};")
        outputs = zip(values, signature.outputs, strict=True)
        written = [word for value, (_, kind) in outputs for word in _write_words(value, kind)]
        if signature.discards:
            written.append("1u")
        for n, text in enumerate(written[first : first + words]):
            lines.append(f"  {PREFIX}out{n} = {text};")
        return "\n".join([*lines, "}"]) + "\n"

    def _reading(self) -> Iterator[str]:
        """Declares arguments and reads them; sets the globals."""
        parameters = {p.name for p in self.signature.parameters}
        for inputs, word in ((self.varying, _varying_word), (self.shared, _shared_word)):
            at = 0
            for given in inputs:
                name = rename(given.name)
                if given.name in parameters:
                    name = local_name(given.name)
                    yield f"  {declare(given.type, name)};"
                yield from _assign(name, given.type, word, str(at))
                at += given.type.words
        for name, default in self.signature.state:
            yield f"  {name} = {' '.join(default.split())};"


def local_name(name: str) -> str:
    """The wrapper's variable for a parameter."""
    return f"{PREFIX}p_{name}"


def _varying_word(index: str) -> str:
    return f"{PREFIX}words[{index}]"


def _shared_word(index: str) -> str:
    if index.isdecimal():
        return f"{_SHARED}[{int(index) // 4}].{'xyzw'[int(index) % 4]}"
    return f"{_SHARED}[({index}) >> 2][({index}) & 3]"


def _assign(
    target: str, kind: Type, word: Callable[[str], str], at: str, depth: int = 0
) -> Iterator[str]:
    """Statements that read a value from its words, the first of which is `at`."""
    if kind.dims:
        inner, count = kind.element, kind.dims[0]
        if count <= _UNROLLED:
            for n in range(count):
                yield from _assign(f"{target}[{n}]", inner, word, _plus(at, n * inner.words), depth)
            return
        i = f"i{depth}"
        yield f"  for (int {i} = 0; {i} < {count}; {i}++) {{"
        where = f"{at} + {i} * {inner.words}"
        yield from _assign(f"{target}[{i}]", inner, word, where, depth + 1)
        yield "  }"
    elif kind.members:
        for name, member in kind.members:
            yield from _assign(f"{target}.{name}", member, word, at, depth)
            at = _plus(at, member.words)
    else:
        read = [_READS[kind.kind].format(word(_plus(at, n))) for n in _constructor_order(kind)]
        yield f"  {target} = {kind.name}({', '.join(read)});"


def _plus(at: str, n: int) -> str:
    return str(int(at) + n) if at.isdecimal() else f"{at} + {n}"


def _constructor_order(kind: Type) -> list[int]:
    """The words of one element in the order of GLSL's constructor; a matrix's words are row by row,
    as in NumPy."""
    if len(kind.base_shape) == 2:
        rows, columns = kind.base_shape
        return [r * columns + c for c in range(columns) for r in range(rows)]
    return list(range(kind.words))


def _write_words(value: str, kind: Type) -> Iterator[str]:
    """The words of a value, as expressions."""
    if kind.dims:
        for n in range(kind.dims[0]):
            yield from _write_words(f"{value}[{n}]", kind.element)
    elif kind.members:
        for name, member in kind.members:
            yield from _write_words(f"{value}.{name}", member)
    elif len(kind.base_shape) == 2:
        rows, columns = kind.base_shape
        for r in range(rows):
            for c in range(columns):
                yield _WRITES[kind.kind].format(f"{value}[{c}][{r}]")
    elif kind.base_shape:
        for n in range(kind.words):
            yield _WRITES[kind.kind].format(f"{value}[{n}]")
    else:
        yield _WRITES[kind.kind].format(value)
