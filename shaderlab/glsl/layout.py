"""The layout of a uniform or storage block by the std140 and std430 rules.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §7.6.2.2, "Standard uniform block layout", rules 1 to 10.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from shaderlab.glsl.interface import Member

Rules = Literal["std140", "std430"]
_VEC4 = 16
_PATH = re.compile(r"\w+|\[\d+\]")


@dataclass(frozen=True, kw_only=True)
class Field:
    """A declared member: `type` is GLSL's name, or a struct's fields; `array` has its lengths, the
    outermost first."""

    name: str
    type: str | tuple[Field, ...]
    array: tuple[int, ...] = ()
    row_major: bool = False


@dataclass(frozen=True)
class Slot:
    """A member's place in bytes; strides are 0 if they don't apply."""

    offset: int
    size: int
    array_stride: int = 0
    matrix_stride: int = 0


@dataclass(frozen=True)
class Layout:
    """Slots by the member's name without the block's, and the size of the block in bytes."""

    slots: Mapping[str, Slot]
    size: int


@dataclass(frozen=True)
class _Extent:
    """One element's alignment and size, and the stride of a matrix's vectors."""

    align: int
    size: int
    matrix_stride: int = 0


def layout(fields: Sequence[Field], rules: Rules = "std140") -> Layout:
    """The members' places. Each begins at the next multiple of its own alignment.

    A scalar of N bytes is aligned to N, a vec2 to 2N, a vec3 or vec4 to 4N. A matrix is an array
    of its columns (of its rows, if it is row-major). Elements of an array stand at a stride of
    their size rounded up to their alignment; std140 rounds that alignment, and a struct's, up to
    that of a vec4.

    Args:
        fields: in the order in which they are declared.
        rules: "std140", or "std430", which storage blocks alone may have.

    >>> three = [Field(name="a", type="float"), Field(name="b", type="vec3"),
    ...          Field(name="c", type="float", array=(2,)), Field(name="d", type="float")]
    >>> [slot.offset for slot in layout(three).slots.values()], layout(three).size
    ([0, 16, 32, 64], 80)
    >>> [slot.offset for slot in layout(three, "std430").slots.values()]
    [0, 16, 28, 36]
    """
    slots = dict(_placed(fields, "", 0, rules))
    end = max((slot.offset + slot.size for slot in slots.values()), default=0)
    whole = _extent(tuple(fields), False, rules) if fields else _Extent(1, 0)
    return Layout(slots, _up(end, _VEC4) if rules == "std140" else _up(end, whole.align))


def declared(members: Iterable[Member]) -> tuple[Field, ...]:
    """A block's fields from its reflected members, whose names are paths ("lights[0].color").

    >>> path = [Member(name=f"l[{i}].p", type="vec3", offset=0, size=12) for i in (0, 1)]
    >>> declared(path)[0].array, declared(path)[0].type[0].name
    ((2,), 'p')
    """
    return _grouped([(_PATH.findall(member.name), member) for member in members])


def _grouped(paths: Sequence[tuple[Sequence[str], Member]]) -> tuple[Field, ...]:
    groups: dict[str, list[tuple[Sequence[str], Member]]] = {}
    for (head, *rest), member in paths:
        groups.setdefault(head, []).append((rest, member))
    return tuple(_field(name, group) for name, group in groups.items())


def _field(name: str, group: Sequence[tuple[Sequence[str], Member]]) -> Field:
    lengths: list[int] = []
    # The elements of an array of structs, or of arrays, are alike: the first stands for all.
    while group[0][0] and group[0][0][0].startswith("["):
        lengths.append(len({path[0] for path, _ in group}))
        group = [(path[1:], member) for path, member in group if path[0] == "[0]"]
    path, member = group[0]
    if path:
        return Field(name=name, type=_grouped(group), array=tuple(lengths))
    if member.array is not None:
        lengths.append(member.array)
    return Field(name=name, type=member.type, array=tuple(lengths), row_major=member.row_major)


def _placed(
    fields: Sequence[Field], prefix: str, base: int, rules: Rules
) -> Iterator[tuple[str, Slot]]:
    offset = base
    for field in fields:
        align, size = _whole(field, rules)
        offset = _up(offset, align)
        yield from _leaves(field, prefix + field.name, offset, field.array, rules)
        offset += size


def _leaves(
    field: Field, name: str, offset: int, lengths: tuple[int, ...], rules: Rules
) -> Iterator[tuple[str, Slot]]:
    one = _extent(field.type, field.row_major, rules)
    stride = _stride(one, lengths, rules) if lengths else 0
    if len(lengths) > 1 or (lengths and not isinstance(field.type, str)):
        for index in range(lengths[0]):
            yield from _leaves(
                field, f"{name}[{index}]", offset + index * stride, lengths[1:], rules
            )
    elif not isinstance(field.type, str):
        yield from _placed(field.type, f"{name}.", offset, rules)
    else:
        size = stride * lengths[0] if lengths else one.size
        yield name, Slot(offset, size, stride, one.matrix_stride)


def _whole(field: Field, rules: Rules) -> tuple[int, int]:
    """Alignment and size of a member with all elements of its arrays."""
    one = _extent(field.type, field.row_major, rules)
    if not field.array:
        return one.align, one.size
    return _rounded(one.align, rules), _stride(one, field.array, rules) * field.array[0]


def _stride(one: _Extent, lengths: Sequence[int], rules: Rules) -> int:
    """The stride of an array's outermost dimension."""
    return _up(one.size, _rounded(one.align, rules)) * math.prod(lengths[1:])


def _extent(type_: str | tuple[Field, ...], row_major: bool, rules: Rules) -> _Extent:
    if not isinstance(type_, str):
        return _struct(type_, rules)
    unit = 8 if type_.startswith("d") else 4
    if "mat" not in type_:
        return _vector(int(type_[-1]) if "vec" in type_ else 1, unit)
    columns, _, rows = type_.partition("mat")[2].partition("x")
    shape = int(columns), int(rows or columns)
    count, length = reversed(shape) if row_major else shape
    vector = _vector(length, unit)
    align = _rounded(vector.align, rules)
    return _Extent(align, count * _up(vector.size, align), _up(vector.size, align))


def _vector(length: int, unit: int) -> _Extent:
    return _Extent((1, 2, 4, 4)[length - 1] * unit, length * unit)


def _struct(fields: Sequence[Field], rules: Rules) -> _Extent:
    align, end = 1, 0
    for field in fields:
        own, size = _whole(field, rules)
        end = _up(end, own) + size
        align = max(align, own)
    align = _rounded(align, rules)
    return _Extent(align, _up(end, align))


def _rounded(align: int, rules: Rules) -> int:
    """The alignment of an array's elements, or of a struct, by that of its parts."""
    return _up(align, _VEC4) if rules == "std140" else align


def _up(number: int, unit: int) -> int:
    return -(-number // unit) * unit
