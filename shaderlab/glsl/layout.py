"""Where the members of a uniform or storage block lie, by the std140 and std430 rules.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §7.6.2.2, "Standard uniform block layout", rules 1 to 10.
"""

from __future__ import annotations

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
    """A member as it is declared: `type` is GLSL's name of it, or a struct's own fields; `array`
    are its lengths, the outermost first."""

    name: str
    type: str | tuple[Field, ...]
    array: tuple[int, ...] = ()
    row_major: bool = False


@dataclass(frozen=True)
class Slot:
    """Where a member lies, all in bytes; strides are 0 where none apply."""

    offset: int
    size: int
    array_stride: int = 0
    matrix_stride: int = 0


@dataclass(frozen=True)
class Layout:
    """Slots by a member's name less the block's own, and the whole size in bytes."""

    slots: Mapping[str, Slot]
    size: int


@dataclass(frozen=True)
class _Extent:
    """What one element takes: its alignment, its size, and the stride of a matrix's vectors."""

    align: int
    size: int
    matrix_stride: int = 0


def layout(fields: Sequence[Field], rules: Rules = "std140") -> Layout:
    """The members' places: each begins at the next multiple of its own alignment.

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
    """A block's fields out of its reflected members, whose names are paths ("lights[0].color").

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
    # The elements of an array of structs, or of arrays, are alike: its first one tells all.
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
    of_struct = not isinstance(field.type, str)
    if len(lengths) > 1 or (lengths and of_struct):
        step = _stride(one, lengths, rules)[0]
        for index in range(lengths[0]):
            yield from _leaves(field, f"{name}[{index}]", offset + index * step, lengths[1:], rules)
    elif not isinstance(field.type, str):
        yield from _placed(field.type, f"{name}.", offset, rules)
    elif lengths:
        step = _stride(one, lengths, rules)[0]
        yield name, Slot(offset, step * lengths[0], step, one.matrix_stride)
    else:
        yield name, Slot(offset, one.size, 0, one.matrix_stride)


def _whole(field: Field, rules: Rules) -> tuple[int, int]:
    """Alignment and size of a member with all elements of its arrays."""
    one = _extent(field.type, field.row_major, rules)
    if not field.array:
        return one.align, one.size
    strides = _stride(one, field.array, rules)
    align = _up(one.align, _VEC4) if rules == "std140" else one.align
    return align, strides[0] * field.array[0]


def _stride(one: _Extent, lengths: tuple[int, ...], rules: Rules) -> list[int]:
    """The stride of each of an array's dimensions, the outermost first."""
    align = _up(one.align, _VEC4) if rules == "std140" else one.align
    strides = [_up(one.size, align)]
    for length in reversed(lengths[1:]):
        strides.insert(0, strides[0] * length)
    return strides


def _extent(type_: str | tuple[Field, ...], row_major: bool, rules: Rules) -> _Extent:
    if not isinstance(type_, str):
        return _struct(type_, rules)
    unit = 8 if type_.startswith("d") else 4
    if "mat" in type_:
        sizes = type_.split("mat")[1]
        columns, rows = (int(n) for n in (sizes.split("x") if "x" in sizes else (sizes, sizes)))
        count, length = (rows, columns) if row_major else (columns, rows)
        vector = _vector(length, unit)
        align = _up(vector.align, _VEC4) if rules == "std140" else vector.align
        return _Extent(align, count * _up(vector.size, align), _up(vector.size, align))
    return _vector(int(type_[-1]) if "vec" in type_ else 1, unit)


def _vector(length: int, unit: int) -> _Extent:
    return _Extent({1: 1, 2: 2, 3: 4, 4: 4}[length] * unit, length * unit)


def _struct(fields: Sequence[Field], rules: Rules) -> _Extent:
    align, end = 1, 0
    for field in fields:
        own, size = _whole(field, rules)
        end = _up(end, own) + size
        align = max(align, own)
    align = _up(align, _VEC4) if rules == "std140" else align
    return _Extent(align, _up(end, align))


def _up(number: int, unit: int) -> int:
    return -(-number // unit) * unit
