"""What stays a uniform: samplers, and structs that hold some."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.drivers.programs.textures import contents, kind_of
from shaderlab.errors import CallError
from shaderlab.functions.arguments import argument
from shaderlab.functions.binding import Call
from shaderlab.functions.types import Type
from shaderlab.model.frame import Array, Texels
from shaderlab.model.textures import CompressedTexture, CubeTexture, Texture, TextureArray

_ARRAY = "give a shaderlab.Texture, or an array (height, width, channels)"
_REMEDIES = {
    **dict.fromkeys(("sampler2D", "isampler2D", "usampler2D"), _ARRAY),
    **dict.fromkeys(
        ("sampler2DArray", "isampler2DArray", "usampler2DArray"), "give a shaderlab.TextureArray"
    ),
    "samplerCube": "give a shaderlab.CubeTexture",
    "sampler2DShadow": 'give a shaderlab.Texture with compare="lequal"',
}
_TEXTURES = (Texture, TextureArray, CubeTexture, CompressedTexture)


def spread(
    name: str,
    value: Any,
    kind: Type,
    label: str,
    uniforms: dict[str, Array],
    textures: dict[str, tuple[str, Any]],
) -> None:
    """Uniforms by the names that a driver has for them: "material.shininess", "maps[0]"."""
    if kind.dims and (kind.opaque or kind.members):
        if isinstance(value, Mapping | str) or len(value) != kind.dims[0]:
            raise CallError(f"{label} is {kind}: give a sequence of {kind.dims[0]} values")
        for n, element in enumerate(value):
            spread(f"{name}[{n}]", element, kind.element, f"{label}[{n}]", uniforms, textures)
    elif kind.members:
        names = [member for member, _ in kind.members]
        if not isinstance(value, Mapping) or set(value) != set(names):
            raise CallError(f"{label} is {kind}: give a mapping of {', '.join(names)}")
        for member, its in kind.members:
            spread(f"{name}.{member}", value[member], its, f"{label}.{member}", uniforms, textures)
    elif kind.opaque:
        textures[name] = kind.name, _texture(value, kind, label)
    else:
        given = argument(value, kind, label)
        if given.varies:
            raise CallError(f"{label} is in a struct with samplers: it has one value for a call")
        array = given.leaves[0].reshape(kind.shape or (1,))
        uniforms[name] = array.astype(np.float32) if kind.kind == "float" else array


@dataclass(frozen=True)
class Opaque:
    """What a call's samplers, and structs with samplers, are to references.

    Attributes:
        uniforms: the numbers beside samplers in structs, by name.
        textures: those whose texels are known without a driver, by name.
        unread: why the others can't be read, by name.
    """

    uniforms: Mapping[str, Array]
    textures: Mapping[str, Texels]
    unread: Mapping[str, CallError]


def of_references(call: Call, folder: Path) -> Opaque:
    """A call's textures, as references sample them.

    Args:
        call: the function's arguments.
        folder: what paths of textures are relative to.

    Raises:
        CaseError, AssetError: as `shaderlab.drivers.programs.textures.contents`.
    """
    uniforms: dict[str, Array] = {}
    sources: dict[str, tuple[str, Any]] = {}
    for one in (*call.signature.given, *call.signature.globals):
        if one.name in call.opaque:
            label = f"{call.signature.name}: {one.name}"
            spread(one.name, call.opaque[one.name], one.type, label, uniforms, sources)
    textures, unread = {}, {}
    for name, (_, source) in sources.items():
        try:
            textures[name] = _texels(source, f"{call.signature.name}: {name}", folder)
        except CallError as error:
            unread[name] = error
    return Opaque(uniforms, textures, unread)


def _texels(source: Any, label: str, folder: Path) -> Texels:
    depth = getattr(source, "format", "").startswith("depth") and source.format != "depth32f"
    if depth or isinstance(source, CompressedTexture) or source.mipmaps is True:
        raise CallError(
            f"{label}: a reference can't read mipmaps, blocks or depths that the driver makes",
            remedy="give levels as arrays, without compression, depths as depth32f; or write a "
            "case, where the driver's texels are read back",
        )
    made = contents(source, folder, {})
    single = kind_of(source, "", 0) == "2D"
    return Texels(
        made.layers[0] if single else np.stack(made.layers),
        source.filter, source.wrap, source.border,
        kind=kind_of(source, "", 0), format=source.format, smaller=tuple(made.smaller),
        compare=source.compare, lod=source.lod, seamless=getattr(source, "seamless", True),
    )  # fmt: skip


def _texture(value: Any, kind: Type, label: str) -> Any:
    if isinstance(value, _TEXTURES):
        return value
    array = np.asarray(value)
    letter = kind.name.removesuffix("sampler2D")
    if letter not in ("", "i", "u") or array.ndim not in (2, 3) or array.dtype.kind not in "fiu":
        raise CallError(
            f"{label} is {kind}; given was {type(value).__name__}",
            remedy=_REMEDIES.get(kind.name, "the lab has no textures for it"),
        )
    pixels = array.reshape(*array.shape[:2], -1)
    if letter:
        if array.dtype.kind == "f" or pixels.shape[2] == 3:
            raise CallError(f"{label} is {kind}: it takes whole numbers in 1, 2 or 4 channels")
        word = {1: "r32", 2: "rg32", 4: "rgba32"}[pixels.shape[2]] + {"i": "i", "u": "ui"}[letter]
        return Texture(image=pixels, format=word)
    if array.dtype == np.uint8:
        return Texture(image=pixels, format=("r8", "rg8", "rgb8", "rgba8")[pixels.shape[2] - 1])
    format = ("r32f", "rg32f", "rgb32f", "rgba32f")[pixels.shape[2] - 1]
    return Texture(image=pixels.astype(np.float32), format=format)
