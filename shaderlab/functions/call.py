"""The arguments of a call: made to fit an overload's types, textures included."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.drivers.programs.textures import texture_contents, texture_kind
from shaderlab.errors import ArgumentsError, CallError, suggest
from shaderlab.functions.signatures import DTYPES, Input, Signature, Type
from shaderlab.model.checked import UNMASK, is_array, is_masked
from shaderlab.model.frame import Array, Texels
from shaderlab.model.textures import CompressedTexture, CubeTexture, Texture, TextureArray

_ACCEPTED = {"float": "fiu", "int": "iu", "uint": "iu", "bool": "b"}
_WORD = {"f": np.dtype(np.float32), "i": np.dtype(np.int32)}
_SHOWN = 60


@dataclass(frozen=True)
class Argument:
    """A value that fits its type: its numbers in the order of the type's words, each leaf (batch…,
    words of the leaf), where the batch may be any shape that broadcasts, and the kind of the
    integers that were given, "i" or "u" as in NumPy; "" for others."""

    type: Type
    batch: tuple[int, ...]
    leaves: tuple[Array, ...]
    whole: str = ""

    @property
    def varies(self) -> bool:
        return math.prod(self.batch) != 1

    @property
    def value(self) -> Any:
        """The value as the function gets it: floats are float32's."""
        return _rebuild(iter(self.leaves), self.type)

    def fill(self, layers: Array, batch: tuple[int, ...]) -> None:
        """Write each word's elements, broadcast to `batch`, to the start of a layer (uint32)."""
        at, count = 0, math.prod(batch)
        for leaf in self.leaves:
            dtype = _WORD.get(leaf.dtype.kind, np.dtype(np.uint32))
            for n in range(leaf.shape[-1]):
                layer = layers[at].reshape(-1)[:count].view(dtype).reshape(batch)
                with np.errstate(over="ignore", invalid="ignore"):
                    np.copyto(layer, leaf[..., n], casting="unsafe")
                at += 1


def _rebuild(leaves: Iterator[Array], kind: Type) -> Any:
    if kind.members and kind.dims:
        return [_rebuild(leaves, kind.element) for _ in range(kind.dims[0])]
    if kind.members:
        return {name: _rebuild(leaves, member) for name, member in kind.members}
    leaf = next(leaves)
    shape = (*leaf.shape[:-1], *kind.shape)
    return (leaf.astype(np.float32) if kind.kind == "float" else leaf).reshape(shape)


def fit_argument(value: Any, kind: Type, label: str) -> Argument:
    """The value of a parameter or a global. Raises CallError: it does not fit; names the label, the
    type and what was given."""
    leaves = tuple(_numbers(leaf, its, name) for name, its, leaf in _walk(value, kind, label))
    try:
        batch = np.broadcast_shapes(*(leaf.shape[:-1] for leaf in leaves))
    except ValueError:
        shapes = ", ".join(dict.fromkeys(str(leaf.shape[:-1]) for leaf in leaves))
        raise CallError(f"{label}: members of shapes {shapes} do not broadcast") from None
    given = "" if kind.members else np.asarray(value).dtype.kind
    return Argument(kind, batch, leaves, given if given in ("i", "u") else "")


def _walk(value: Any, kind: Type, label: str) -> Iterator[tuple[str, Type, Any]]:
    """The name, the type and the value of each member that is no struct, as in `Type.leaves`."""
    if kind.dims and (kind.members or kind.opaque):
        count = kind.dims[0]
        if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str):
            raise _misfit_error(value, kind, label, f"a sequence of {count} values")
        if len(value) != count:
            raise _misfit_error(value, kind, label, f"a sequence of {count} values")
        for number, element in enumerate(value):
            yield from _walk(element, kind.element, f"{label}[{number}]")
    elif kind.members:
        names = [name for name, _ in kind.members]
        if not isinstance(value, Mapping):
            raise _misfit_error(value, kind, label, f"a mapping of {', '.join(names)}")
        if set(value) != set(names):
            missing = [name for name in names if name not in value]
            surplus = [repr(name) for name in value if name not in names]
            what = f"lacks {', '.join(missing)}" if missing else f"has no member {surplus[0]}"
            raise CallError(f"{label}: {kind} {what}", remedy=f"it has {', '.join(names)}")
        for name, member in kind.members:
            yield from _walk(value[name], member, f"{label}.{name}")
    else:
        yield label, kind, value


def _numbers(value: Any, kind: Type, label: str) -> Array:
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        raise _misfit_error(value, kind, label, "an array of numbers") from None
    if is_masked(value):
        raise CallError(f"{label} holds a masked value, which is no number", remedy=UNMASK)
    if array.dtype.kind not in _ACCEPTED[kind.kind]:
        whole = array.dtype.kind == "f" and kind.kind in ("int", "uint")
        wanted = {"float": "numbers", "bool": "booleans"}.get(kind.kind, "whole numbers")
        remedy = "make them whole with .astype(int)" if whole else f"give {wanted}"
        raise _misfit_error(value, kind, label, remedy=remedy)
    own = len(kind.shape)
    if array.ndim < own or array.shape[array.ndim - own :] != kind.shape:
        wanted = ", ".join(map(str, kind.shape))
        raise _misfit_error(value, kind, label, f"an array whose last axes are ({wanted})")
    if kind.kind in ("int", "uint"):
        array = _in_range(array, kind, label)
    elif kind.kind == "float" and array.dtype != np.float32:
        array = array.astype(np.float64, copy=False)
    return array.reshape(*array.shape[: array.ndim - own], math.prod(kind.shape))


def _in_range(array: Array, kind: Type, label: str) -> Array:
    limits = np.iinfo(DTYPES[kind.kind])
    if array.dtype != limits.dtype and array.size:
        low, high = int(array.min()), int(array.max())
        if low < limits.min or high > limits.max:
            wrong = low if low < limits.min else high
            raise CallError(f"{label}: {kind} can't hold {wrong}")
    return array.astype(limits.dtype, copy=False)


def _misfit_error(
    value: Any, kind: Type, label: str, wanted: str = "", remedy: str | None = None
) -> CallError:
    if isinstance(value, np.ndarray):
        given = f"an array of {value.dtype}, shape {value.shape}"
    else:
        text = repr(value)
        text = text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…"
        given = f"{type(value).__name__} {text}"
    return CallError(f"{label} is {kind}; given was {given}", remedy=remedy or f"give {wanted}")


def build_result(words: Array, kind: Type, batch: tuple[int, ...]) -> Any:
    """A value of a type from its words, (words, count) of uint32: an array of the batch's shape and
    the type's, a mapping for a struct, a list for an array of structs. It may be a view of them."""
    if kind.members and kind.dims:
        size = kind.element.words
        parts = range(kind.dims[0])
        return [build_result(words[n * size : (n + 1) * size], kind.element, batch) for n in parts]
    if kind.members:
        found, at = {}, 0
        for name, member in kind.members:
            found[name] = build_result(words[at : at + member.words], member, batch)
            at += member.words
        return found
    values = words != 0 if kind.kind == "bool" else words.view(DTYPES[kind.kind])
    if not kind.shape:
        return values[0].reshape(batch)[()]
    return np.ascontiguousarray(values.T).reshape(*batch, *kind.shape)


def _misfit_of(kind: str, whole: str) -> int:
    """How far a type is from whole numbers: `whole` as in `Argument`."""
    if not whole or kind == "bool":
        return 0
    return 2 if kind == "float" else kind != {"i": "int", "u": "uint"}[whole]


@dataclass(frozen=True)
class Call:
    """A function with the arguments that it is called with; `batch` is the shape of the calls."""

    signature: Signature
    values: Mapping[str, Argument]
    opaque: Mapping[str, Any]
    batch: tuple[int, ...]

    @property
    def fit(self) -> tuple[int, int]:
        """How well it fits: the more of an argument's axes are the type's own, the better. Whole
        numbers fit integers better, signed ones `int` unless they are unsigned in NumPy. Then the
        fewer parameters are left out, the better."""
        types = sum(
            4 * len(given.type.shape) - _misfit_of(given.type.kind, given.whole)
            for given in self.values.values()
        )
        return types, -len(self.signature.parameters)


def bind_arguments(
    overloads: Sequence[Signature],
    arguments: Sequence[Any],
    named: Mapping[str, Any],
    defaults: Mapping[str, Any],
) -> Call:
    """The overload that arguments fit best, with them. Raises CallError: none fits, or two fit
    alike."""
    found: list[Call] = []
    errors: list[CallError] = []
    for signature in overloads:
        try:
            found.append(_fit_overload(signature, arguments, named, defaults))
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


def _fit_overload(
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
    for one, value in _pair(signature, arguments, named, defaults):
        if one.type.opaque:
            opaque[one.name] = value
        else:
            values[one.name] = fit_argument(value, one.type, f"{name}: {one.name}")
    return _call(signature, values, opaque)


def find_ranges(
    signature: Signature, arguments: Sequence[Any], named: Mapping[str, Any]
) -> Iterator[tuple[Input, tuple[Any, Any]]]:
    """Yield the floats and integers for which both ends of a range are given: a pair. Lists and
    arrays are values, one for each call."""
    given = {p.name: v for p, v in zip(signature.given, arguments, strict=False)} | {**named}
    for one in (*signature.given, *signature.globals):
        ends: Any = given.get(one.name)
        if is_range(ends, one.type, f"{signature.name}: {one.name}"):
            yield one, ends


def is_range(value: Any, kind: Type, label: str) -> bool:
    """Whether a number is given as both ends of a range. Raises CallError: they are none."""
    if kind.name not in ("float", "int", "uint") or type(value) is not tuple or len(value) != 2:
        return False
    fit_argument(list(value), kind, label)
    if any(map(np.ndim, value)) or not value[0] <= value[1]:
        raise CallError(
            f"{label}={value} is no range", remedy="give two numbers, the lower one first"
        )
    return True


def replace_arguments(call: Call, new: Mapping[str, Any]) -> Call:
    """A call with other values of some arguments, by name. Raises CallError."""
    inputs = {i.name: i for i in (*call.signature.given, *call.signature.globals)}
    name = call.signature.name
    made = {word: fit_argument(v, inputs[word].type, f"{name}: {word}") for word, v in new.items()}
    return _call(call.signature, {**call.values, **made}, call.opaque)


def _call(signature: Signature, values: Mapping[str, Argument], opaque: Mapping[str, Any]) -> Call:
    shapes = {word: a.batch for word, a in values.items()}
    try:
        batch = np.broadcast_shapes(*shapes.values())
    except ValueError:
        shown = ", ".join(f"{word} {shape}" for word, shape in shapes.items() if shape)
        raise CallError(f"{signature.name}: these shapes do not broadcast: {shown}") from None
    return Call(signature, values, opaque, batch)


def _pair(
    signature: Signature,
    arguments: Sequence[Any],
    named: Mapping[str, Any],
    defaults: Mapping[str, Any],
) -> Iterator[tuple[Input, Any]]:
    name, given = signature.name, signature.given
    if len(arguments) > len(given):
        raise ArgumentsError(
            f"{signature} takes {len(given)} arguments; given were {len(arguments)}"
        )
    values = {p.name: v for p, v in zip(given, arguments, strict=False)}
    known = [*(p.name for p in given), *(g.name for g in signature.globals)]
    for word, value in named.items():
        if word in values:
            raise ArgumentsError(f"{name}: {word} is given twice")
        if word not in known:
            raise ArgumentsError(f"{name} takes no {word!r}", remedy=suggest(word, known))
        values[word] = value
    for one in given:
        if one.name not in values:
            raise ArgumentsError(f"{signature}: {one.type} {one.name} is missing")
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


_TEXTURES = (Texture, TextureArray, CubeTexture, CompressedTexture)
Textures = dict[str, tuple[str, Any]]
"""The type of each sampler, and its texture."""


def collect_opaque(
    call: Call, name_of: Callable[[str], str] = str
) -> tuple[dict[str, Array], Textures]:
    """The uniforms and the textures of a call's samplers, and of structs with samplers, by the
    names that a driver has for them: "material.shininess", "maps[0]". `name_of` gives the name of
    the variable for that of a parameter or global. Raises CallError."""
    uniforms: dict[str, Array] = {}
    textures: Textures = {}
    for one in (*call.signature.given, *call.signature.globals):
        if one.name not in call.opaque:
            continue
        label = f"{call.signature.name}: {one.name}"
        for place, kind, value in _walk(call.opaque[one.name], one.type, label):
            name = name_of(one.name) + place.removeprefix(label)
            if kind.opaque:
                textures[name] = kind.name, _texture(value, kind, place)
                continue
            given = fit_argument(value, kind, place)
            if given.varies:
                raise CallError(
                    f"{place} is in a struct with samplers: it has one value for a call"
                )
            array = given.leaves[0].reshape(kind.shape or (1,))
            uniforms[name] = array.astype(np.float32) if kind.kind == "float" else array
    return uniforms, textures


def read_texels(source: Any, label: str, folder: Path) -> Texels:
    """A texture as references sample it. Raises CallError: its texels are not known without a
    driver; CaseError, AssetError: as `shaderlab.drivers.programs.textures.texture_contents`."""
    depth = getattr(source, "format", "").startswith("depth") and source.format != "depth32f"
    if depth or isinstance(source, CompressedTexture) or source.mipmaps is True:
        raise CallError(
            f"{label}: a reference can't read mipmaps, blocks or depths that the driver makes",
            remedy="give levels as arrays, without compression, depths as depth32f; or write a "
            "case, where the driver's texels are read back",
        )
    made = texture_contents(source, folder, {})
    kind = texture_kind(source, "", 0)
    return Texels(
        made.layers[0] if kind == "2D" else np.stack(made.layers),
        source.filter, source.wrap, source.border,
        kind=kind, format=source.format, smaller=tuple(made.smaller),
        compare=source.compare, lod=source.lod, seamless=getattr(source, "seamless", True),
    )  # fmt: skip


def _texture(value: Any, kind: Type, label: str) -> Any:
    if isinstance(value, _TEXTURES):
        return value
    array = np.asarray(value if is_array(value) else ())
    letter = kind.name.removesuffix("sampler2D")
    if letter not in ("", "i", "u") or array.ndim not in (2, 3) or array.dtype.kind not in "fiu":
        raise CallError(
            f"{label} is {kind}; given was {type(value).__name__}",
            remedy="give a shaderlab.Texture, TextureArray or CubeTexture, or for a sampler2D an "
            "array (height, width, channels)",
        )
    pixels = array.reshape(*array.shape[:2], -1)
    if letter:
        if array.dtype.kind == "f" or pixels.shape[2] == 3:
            raise CallError(f"{label} is {kind}: it takes whole numbers in 1, 2 or 4 channels")
        word = {1: "r32", 2: "rg32", 4: "rgba32"}[pixels.shape[2]] + {"i": "i", "u": "ui"}[letter]
        return Texture(image=pixels, format=word)
    channels = ("r", "rg", "rgb", "rgba")[pixels.shape[2] - 1]
    if array.dtype == np.uint8:
        return Texture(image=pixels, format=f"{channels}8")
    return Texture(image=pixels.astype(np.float32), format=f"{channels}32f")
