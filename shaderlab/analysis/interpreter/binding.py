"""Inputs by name as a program's variables, and its outputs by name.

Names are those of the driver's interface: "light.constant", "lights[0].position", "weights" for
a whole array, "Block.member" for members of a block that has an instance name, "gl_FragCoord".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Integer, Truth
from shaderlab.compiler.reflection import Decoration, Storage, leaves, unwrap
from shaderlab.model.frame import Array, Bindings

from .arithmetic import Arithmetic
from .program import INPUTS, Program
from .types import Type
from .values import Missing, Value, broadcast, component, undefined


def memory_of(
    program: Program, each: Mapping[str, Array], bindings: Bindings, arithmetic: Arithmetic
) -> dict[int, Value]:
    """What the program's global variables hold at first, by id.

    What nothing is given for is `Missing`, which only reading makes an error.
    """
    giver = _Giver(each, bindings, arithmetic)
    memory: dict[int, Value] = {}
    for id_, (type_, storage) in program.variables.items():
        if storage in INPUTS:
            memory[id_] = giver.value(type_, called(program, id_))
    return memory


def undefined_outputs(program: Program, arithmetic: Arithmetic) -> dict[int, Value]:
    """What outputs hold before anything is written to them, by id."""
    return {
        id_: undefined(type_, arithmetic)
        for id_, (type_, storage) in program.variables.items()
        if storage == Storage.OUTPUT
    }


def outputs_of(program: Program, memory: Mapping[int, Value], count: int) -> dict[str, Any]:
    """Each output that was written, by name, with a row for every invocation."""
    found: dict[str, Any] = {}
    for id_, (pointee, storage) in program.module.variables.items():
        if storage != Storage.OUTPUT or memory.get(id_) is None:
            continue
        for leaf in leaves(program.module, pointee, called(program, id_)):
            value = memory[id_]
            for index in leaf.path:
                value = None if value is None else component(value, index)
            if value is not None and not isinstance(value, Missing):
                found[leaf.name] = broadcast(value, count)
    return found


def buffers_of(program: Program, memory: Mapping[int, Value], count: int) -> dict[str, Any]:
    """What each storage buffer that a program may write to holds, by name, with a row for every
    invocation: that of its own stores."""
    found: dict[str, Any] = {}
    for id_, (pointee, storage) in program.module.variables.items():
        if is_buffer(program, id_) and storage in INPUTS:
            value, type_ = memory[id_], program.types[pointee]
            name = called(program, id_)
            for (member, _), part in zip(type_.members, value, strict=True):
                if not _is_missing(part):
                    found[f"{name}.{member}" if name else member] = broadcast(part, count)
    return found


def is_buffer(program: Program, id_: int) -> bool:
    """Whether a variable is a storage buffer."""
    pointee, storage = program.module.variables[id_]
    kind = program.module.decorated(pointee, Decoration.BUFFER_BLOCK)
    return storage == Storage.STORAGE_BUFFER or kind is not None


def _is_missing(value: Value) -> bool:
    if isinstance(value, tuple):
        return not value or any(map(_is_missing, value))
    return isinstance(value, Missing)


def called(program: Program, id_: int) -> str:
    """What a variable's parts are called by: a block's own name, which counts only where it has
    an instance name; else the variable's."""
    module = program.module
    name = program.name(id_)
    if id_ not in module.variables:
        return name
    element = unwrap(module, module.variables[id_][0])[1]
    kinds = (Decoration.BLOCK, Decoration.BUFFER_BLOCK)
    if all(module.decorated(element, kind) is None for kind in kinds):
        return name
    return module.names.get(element, "") if name else ""


@dataclass(frozen=True, eq=False)
class _Giver:
    """Finds values by name and turns them into an arithmetic's."""

    _each: Mapping[str, Array]
    _bindings: Bindings
    _arithmetic: Arithmetic

    def value(self, type_: Type, name: str) -> Value:
        """The value of a name, put together of its parts where only those are given."""
        if type_.kind == "image":
            return self._bindings.textures.get(name, Missing(name))
        if name in self._each:
            return self._leaf(type_, np.asarray(self._each[name]))
        if name in self._bindings.uniforms:
            return self._leaf(type_, np.asarray(self._bindings.uniforms[name])[None])
        if type_.kind == "struct":
            return tuple(
                self.value(part, f"{name}.{member}" if name else member)
                for member, part in type_.members
            )
        if type_.kind == "array":
            assert type_.of is not None
            return tuple(self.value(type_.of, f"{name}[{i}]") for i in self._range(type_, name))
        return Missing(name)

    def _range(self, type_: Type, name: str) -> Iterator[int]:
        """The elements of an array; those that are given, of one whose length is not declared."""
        if type_.count:
            yield from range(type_.count)
            return
        given = [*self._each, *self._bindings.uniforms]
        i = 0
        while any(n == f"{name}[{i}]" or n.startswith(f"{name}[{i}].") for n in given):
            yield i
            i += 1

    def _leaf(self, type_: Type, values: Array) -> Value:
        """An array whose first axis counts the invocations (or is 1), as a value."""
        if type_.kind == "array":
            assert type_.of is not None
            return tuple(self._leaf(type_.of, values[:, i]) for i in range(values.shape[1]))
        if type_.kind != "matrix":
            values = values.reshape(values.shape[0], -1)
        if type_.base.kind == "float":
            return self._arithmetic.exact(values)
        if type_.base.kind == "bool":
            return Truth.known(values != 0)
        unsigned = not type_.base.signed
        return Integer(values, unsigned=unsigned, rules=self._arithmetic.rules)
