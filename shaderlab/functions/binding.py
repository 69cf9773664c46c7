"""Which overload a call means, and its arguments made to fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CallError, nearest
from shaderlab.functions.arguments import Argument, argument
from shaderlab.functions.signatures import Input, Signature


def _strange(kind: str, whole: str) -> int:
    """How far a type is from whole numbers: `whole` as in `Argument`."""
    if not whole or kind == "bool":
        return 0
    return 2 if kind == "float" else kind != {"i": "int", "u": "uint"}[whole]


@dataclass(frozen=True)
class Call:
    """A function with the arguments that it is called with.

    Attributes:
        signature: the overload that they fit.
        values: its numbers, parameters and globals, by name.
        opaque: its textures, and structs with textures, by name.
        batch: the shape over which it is called.
    """

    signature: Signature
    values: Mapping[str, Argument]
    opaque: Mapping[str, Any]
    batch: tuple[int, ...]

    @property
    def fit(self) -> int:
        """How well it fits: the more of an argument's axes are the type's own, the better. Whole
        numbers fit integers better, signed ones `int` unless they are unsigned in NumPy."""
        return sum(
            4 * len(given.type.shape) - _strange(given.type.kind, given.whole)
            for given in self.values.values()
        )


def bound(
    overloads: Sequence[Signature],
    arguments: Sequence[Any],
    named: Mapping[str, Any],
    defaults: Mapping[str, Any],
) -> Call:
    """The overload that arguments fit best, with them.

    Args:
        overloads: of one name.
        arguments: by position.
        named: by name: parameters and globals.
        defaults: globals that need not be given.

    Raises:
        CallError: none fits, or two fit alike.
    """
    found: list[Call] = []
    errors: list[CallError] = []
    for signature in overloads:
        try:
            found.append(_fitted(signature, arguments, named, defaults))
        except CallError as error:
            errors.append(error)
    name = overloads[0].name
    if not found:
        if len(errors) == 1:
            raise errors[0]
        lines = "\n    ".join(error.message for error in errors)
        raise CallError(f"{name}: no overload fits\n    {lines}")
    best = max(call.fit for call in found)
    calls = [call for call in found if call.fit == best]
    if len(calls) > 1:
        shown = " and ".join(str(call.signature) for call in calls)
        types = ", ".join(str(p.type) for p in calls[0].signature.parameters)
        raise CallError(
            f"{name}: {shown} fit alike", remedy=f'say which one, such as {name}["{types}"](…)'
        )
    return calls[0]


def _fitted(
    signature: Signature,
    arguments: Sequence[Any],
    named: Mapping[str, Any],
    defaults: Mapping[str, Any],
) -> Call:
    name = signature.name
    if signature.obstacle:
        raise CallError(f"{name} can't be called: {signature.obstacle}")
    values: dict[str, Argument] = {}
    opaque: dict[str, Any] = {}
    for one, value in _paired(signature, arguments, named, defaults):
        if one.type.opaque:
            opaque[one.name] = value
        else:
            values[one.name] = argument(value, one.type, f"{name}: {one.name}")
    return _call(signature, values, opaque)


def replaced(call: Call, new: Mapping[str, Any]) -> Call:
    """A call with other values of some arguments, by name. Raises CallError."""
    inputs = {i.name: i for i in (*call.signature.given, *call.signature.globals)}
    name = call.signature.name
    made = {word: argument(v, inputs[word].type, f"{name}: {word}") for word, v in new.items()}
    return _call(call.signature, {**call.values, **made}, call.opaque)


def _call(signature: Signature, values: Mapping[str, Argument], opaque: Mapping[str, Any]) -> Call:
    shapes = {word: a.batch for word, a in values.items()}
    try:
        batch = np.broadcast_shapes(*shapes.values())
    except ValueError:
        shown = ", ".join(f"{word} {shape}" for word, shape in shapes.items() if shape)
        raise CallError(f"{signature.name}: these shapes do not broadcast: {shown}") from None
    return Call(signature, values, opaque, batch)


def _paired(
    signature: Signature,
    arguments: Sequence[Any],
    named: Mapping[str, Any],
    defaults: Mapping[str, Any],
) -> Iterator[tuple[Input, Any]]:
    """Each parameter and global with its value."""
    name, given = signature.name, signature.given
    if len(arguments) > len(given):
        raise CallError(f"{signature} takes {len(given)} arguments; given were {len(arguments)}")
    values = {p.name: v for p, v in zip(given, arguments, strict=False)}
    known = [*(p.name for p in given), *(g.name for g in signature.globals)]
    for word, value in named.items():
        if word in values:
            raise CallError(f"{name}: {word} is given twice")
        if word not in known:
            raise CallError(f"{name} takes no {word!r}", remedy=nearest(word, known))
        values[word] = value
    for one in given:
        if one.name not in values:
            raise CallError(f"{signature}: {one.type} {one.name} is missing")
        yield one, values[one.name]
    parameters = {p.name for p in given}
    for one in signature.globals:
        if one.name in values and one.name not in parameters:
            yield one, values[one.name]
        elif one.name in defaults:
            yield one, defaults[one.name]
        elif not one.optional:
            raise CallError(
                f"{name} reads {one.type} {one.name}, which is not given",
                remedy=f"{name}(…, {one.name}=…), or for all calls glsl.load(…, {one.name}=…)",
            )
