"""What a reference formula is given of a call: the numbers and textures that the function got."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from shaderlab.engine.judging.inputs import Inputs, parameter_name
from shaderlab.errors import CallError
from shaderlab.functions.binding import Call
from shaderlab.functions.opaque import Opaque, of_references
from shaderlab.functions.parts import Reference
from shaderlab.model.frame import Array

Input = TypeVar("Input")


def reference_inputs(reference: Reference, call: Call, kept: Array, folder: str) -> Inputs:
    """The inputs under the names that the reference has for them: the function's own, or in the
    order of its parameters.

    Args:
        reference: the formula.
        call: the arguments.
        kept: which elements are judged, (count,).
        folder: what paths of textures are relative to.

    Raises:
        CallError: the reference's parameters are not the function's.
    """
    opaque = of_references(call, Path(folder))
    inputs = _inputs(call, kept, opaque)
    wanted = [p for p in inspect.signature(reference).parameters.values()]
    required = [p.name for p in wanted if p.default is p.empty]
    known = inputs.parameters()
    if all(name in known for name in required):
        return inputs
    for name, error in opaque.unread.items():
        if parameter_name(name) in required:
            raise error
    every = [*_in_order(call, [*inputs.exact, *inputs.textures, *opaque.unread])]
    numbers = [name for name in every if name in inputs.exact]
    for names in (every, numbers):
        if len(names) in (len(required), len(wanted)):
            return _by_order(inputs, names, [p.name for p in wanted], opaque)
    shown = ", ".join(parameter_name(n) for n in every)
    raise CallError(
        f"{reference.__name__} takes {', '.join(p.name for p in wanted)}; "
        f"{call.signature.name} gets {shown}",
        remedy="name the reference's parameters so, or take as many in the same order",
    )


def _by_order(
    inputs: Inputs, names: Sequence[str], wanted: Sequence[str], opaque: Opaque
) -> Inputs:
    new = dict(zip(names, wanted, strict=False))
    for name in new.keys() & opaque.unread.keys():
        raise opaque.unread[name]
    return Inputs(
        shared=_renamed(inputs.shared, new),
        each=_renamed(inputs.each, new),
        textures=_renamed(inputs.textures, new),
        arrays=frozenset(new[name] for name in inputs.arrays if name in new),
    )


def leaves(call: Call) -> Iterator[tuple[str, Array]]:
    """Each number or vector that a call has, with its name: "light.constant"."""
    for name, given in call.values.items():
        for (word, _), leaf in zip(given.type.leaves(name), given.leaves, strict=True):
            yield word, leaf


def _in_order(call: Call, known: Sequence[str]) -> Iterator[str]:
    """The inputs in the order of the function's parameters, then the others'."""
    for one in (*call.signature.given, *call.signature.globals):
        yield from (name for name, _ in one.type.leaves(one.name) if name in known)


def _inputs(call: Call, kept: Array, opaque: Opaque) -> Inputs:
    shared: dict[str, Array] = {}
    each: dict[str, Array] = {}
    arrays = set()
    for name, given in call.values.items():
        for (word, kind), leaf in zip(given.type.leaves(name), given.leaves, strict=True):
            exact = leaf.astype(np.float32) if leaf.dtype.kind in "fb" else leaf
            if kind.kind == "float":
                exact = leaf.astype(np.float32)
            own = kind.shape or (1,)
            if kind.dims:
                arrays.add(word)
                own = (*kind.dims, *(kind.base_shape or (1,)))
            if math.prod(leaf.shape[:-1]) == 1:
                shared[word] = exact.reshape(own)
            else:
                whole = np.broadcast_to(exact, (*call.batch, exact.shape[-1]))
                each[word] = whole.reshape(-1, *own)[kept]
    return Inputs(
        shared={**shared, **opaque.uniforms},
        each=each,
        textures=opaque.textures,
        arrays=frozenset(arrays),
    )


def _renamed(values: Mapping[str, Input], new: Mapping[str, str]) -> dict[str, Input]:
    return {new[name]: value for name, value in values.items() if name in new}
