"""GLSL's types as the arrays that stand for them in Python.

A value of a type is an array whose last axes are the type's own `shape`; all axes before those are
the batch, over which a function is called. A struct is a mapping of its members, an array of
structs a sequence of such mappings.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

_BASIC = re.compile(
    r"(?P<scalar>float|int|uint|bool)|(?P<kind>[iub]?)vec(?P<size>[234])"
    r"|mat(?P<columns>[234])(?:x(?P<rows>[234]))?"
)
_OPAQUE = re.compile(r"[iu]?(sampler|image|texture|subpassInput)\w*|sampler|atomic_uint")
_KINDS = {"": "float", "i": "int", "u": "uint", "b": "bool"}
DTYPES = {"float": "float32", "int": "int32", "uint": "uint32", "bool": "bool"}
"""NumPy's type for each kind of number."""


@dataclass(frozen=True)
class Type:
    """A GLSL type.

    Attributes:
        name: without array lengths: "vec3", "Light", "sampler2D".
        dims: array lengths, the outermost first.
        members: of a struct, by name, in order.
    """

    name: str
    dims: tuple[int, ...] = ()
    members: tuple[tuple[str, Type], ...] = ()

    def __str__(self) -> str:
        return self.name + "".join(f"[{n}]" for n in self.dims)

    @cached_property
    def kind(self) -> str:
        """What its numbers are: "float", "int", "uint" or "bool"; "" for any other type."""
        found = _BASIC.fullmatch(self.name)
        if found is None:
            return ""
        return found["scalar"] or _KINDS[found["kind"] or ""]

    @cached_property
    def base_shape(self) -> tuple[int, ...]:
        """The shape of one element: () for a scalar, (n,), or (rows, columns)."""
        found = _BASIC.fullmatch(self.name)
        if found is None or found["scalar"]:
            return ()
        if found["size"]:
            return (int(found["size"]),)
        return (int(found["rows"] or found["columns"]), int(found["columns"]))

    @property
    def shape(self) -> tuple[int, ...]:
        """The last axes of an array of such values: array lengths, then `base_shape`."""
        return self.dims + self.base_shape

    @property
    def element(self) -> Type:
        """What an array's outermost axis counts."""
        return Type(self.name, self.dims[1:], self.members)

    @cached_property
    def opaque(self) -> bool:
        """Whether it is a sampler, or holds one."""
        return bool(_OPAQUE.fullmatch(self.name)) or any(t.opaque for _, t in self.members)

    @cached_property
    def known(self) -> bool:
        """Whether it can be given and returned as numbers."""
        if self.members:
            return all(t.known for _, t in self.members)
        return bool(self.kind)

    @cached_property
    def words(self) -> int:
        """How many 32-bit words a value takes."""
        inner = sum(t.words for _, t in self.members)
        return math.prod(self.dims) * (inner or math.prod(self.base_shape))

    def leaves(self, name: str) -> Iterator[tuple[str, Type]]:
        """The whole name and the type of each member that is no struct: "lights[0].power"."""
        if self.dims and (self.members or self.opaque):
            for n in range(self.dims[0]):
                yield from self.element.leaves(f"{name}[{n}]")
        elif self.members:
            for member, its in self.members:
                yield from its.leaves(f"{name}.{member}")
        else:
            yield name, self
