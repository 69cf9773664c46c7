"""Images of compute shaders: what they hold before a dispatch, and what is left in them.

Layers of an image2DArray or image3D lie one above the other in a pass's output, the first one
lowest.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Interface, Variable
from shaderlab.errors import CaseError, UnsupportedError
from shaderlab.model.frame import Array, Image, Texels
from shaderlab.model.scene import Draw
from shaderlab.model.textures import COLOR_FORMATS, ImageValue, Output

from . import bind
from .textures import Images, find_image, format_of, pixel_values

KINDS = ("2D", "2DArray", "3D")
FORMATS = tuple(word for word in COLOR_FORMATS if not word.startswith("srgb"))
_NEAREST, _EDGE = ("nearest",) * 2, ("clamp_to_edge",) * 2


def declared(interface: Interface) -> dict[str, Variable]:
    """The images that a program declares."""
    return {name: v for name, v in interface.uniforms.items() if "image" in v.type}


def outputs(interface: Interface) -> dict[str, Variable]:
    """The images that a program may write, by name, each with the type of its texels."""
    return {
        name: Variable(name=name, type=_texel_type(image))
        for name, image in declared(interface).items()
        if not image.readonly
    }


def kind_of(image: Variable) -> str:
    """What comes after "image" in its type: "2D", "2DArray" or "3D"."""
    return image.type.partition("image")[2]


def format_word(image: Variable) -> str:
    """The format of its texels: its layout's, or where it has none (`writeonly`) the widest."""
    letter = image.type.partition("image")[0]
    return image.format or {"": "rgba32f", "i": "rgba32i", "u": "rgba32ui"}[letter]


def require_supported(draw: Draw, interface: Interface) -> None:
    """Check that the lab can give a compute shader the images that it declares.

    Raises:
        UnsupportedError: it can't; names what is declared.
    """
    for name, image in declared(interface).items():
        if kind_of(image) not in KINDS:
            known = ", ".join(f"image{kind}" for kind in KINDS)
            raise UnsupportedError(
                f"{draw.compute}: {name} is an {image.type}; compute passes have {known}"
            )
        if image.array is not None:
            raise UnsupportedError(
                f"{draw.compute}: {name} is an array of images",
                remedy=f"declare {image.array} of them",
            )
        if format_word(image) not in FORMATS:
            raise UnsupportedError(
                f"{draw.compute}: {name} has the format {format_word(image)}; compute passes have "
                + ", ".join(FORMATS)
            )


def bound(draw: Draw, interface: Interface, folder: Path, images: Images) -> dict[str, Texels]:
    """What a dispatch's images hold before it.

    Args:
        draw: the dispatch.
        interface: what its program declares.
        folder: where paths of image files begin.
        images: what earlier passes gave.

    Raises:
        CaseError: what is given for an image is missing, unknown, or does not fit it.
        AssetError: an image file can't be read.
    """
    known = declared(interface)
    bind.compare("image", draw, draw.images, known)
    return {
        name: Texels(
            _contents(draw, known[name], value, folder, images), _NEAREST, _EDGE, (0.0,) * 4,
            kind=kind_of(known[name]), format=format_word(known[name]),
        )
        for name, value in draw.images.items()
    }  # fmt: skip


def output_of(image: Texels) -> Image:
    """What an image holds as a pass's output: its layers one above the other."""
    values = image.values
    if image.kind == "2D":
        return Image(values, image.format)
    return Image(values.reshape(-1, *values.shape[2:]), image.format, layers=len(values))


def texel_places(image: Image) -> Array:
    """Where each texel of an output lies in its image, as imageStore has it: (height, width, 2) of
    column and row; or, with its layer, 3."""
    height, width = image.values.shape[:2]
    y, x = np.indices((height, width), np.int32)
    if not image.layers:
        return np.stack([x, y], axis=-1)
    rows = height // image.layers
    return np.stack([x, y % rows, y // rows], axis=-1)


def _texel_type(image: Variable) -> str:
    form = format_of(format_word(image)) if format_word(image) in FORMATS else None
    count = form.components if form else 4
    letter = image.type.partition("image")[0]
    return f"{letter}vec{count}" if count > 1 else {"": "float", "i": "int", "u": "uint"}[letter]


def _contents(
    draw: Draw, image: Variable, value: ImageValue, folder: Path, images: Images
) -> Array:
    """(height, width, components), or with the layers in front."""
    word, layered = format_word(image), kind_of(image) != "2D"
    form, owner = format_of(word), f"{draw.compute}: image {image.name!r}"
    if isinstance(value, Output):
        return _left(image, find_image(value, images), value, owner)
    if not layered:
        return _checked(pixel_values(value, word, folder, owner), value, owner, word)
    given: Any = value() if callable(value) else value
    whole = given if isinstance(given, str | Path) else np.asarray(given)
    if isinstance(whole, np.ndarray) and whole.ndim == 3 and form.components == 1:
        whole = whole[..., None]
    if not isinstance(whole, np.ndarray) or whole.ndim != 4 or 0 in whole.shape:
        shape = f"not {whole.shape}" if isinstance(whole, np.ndarray) else "no file"
        raise CaseError(
            f"{owner} is an {image.type}: it takes an array (layers, height, width, "
            f"{form.components}), {shape}"
        )
    layers = [pixel_values(layer, word, folder, owner) for layer in whole]
    return _checked(np.stack(layers), whole[..., : form.components], owner, word)


def _checked(values: Array, given: Any, owner: str, word: str) -> Array:
    """The values, if an integer format holds what was given for them."""
    if values.dtype.kind in "iu" and isinstance(given, np.ndarray) and given.dtype != values.dtype:
        same = given.reshape(-1) == values.reshape(-1)[: given.size]
        if format_of(word).integer and given.size == values.size and not same.all():
            raise CaseError(f"{owner} is {word}, which holds not all of what is given for it")
    return values


def _left(image: Variable, found: Image, source: Output, owner: str) -> Array:
    """What an earlier pass left, in the shape that an image takes."""
    word, layered = format_word(image), kind_of(image) != "2D"
    wanted, values = format_of(word), found.values
    fits = values.shape[-1] == wanted.components and values.dtype == np.dtype(wanted.numpy)
    if not fits or layered != bool(found.layers):
        layers = f" in {found.layers} layers" if found.layers else ""
        raise CaseError(
            f"{owner} is an {image.type} of {word}, but {source.path} has {values.shape[-1]} "
            f"components of {values.dtype}{layers}"
        )
    return values.reshape(found.layers, -1, *values.shape[1:]) if layered else values


def laid_out(values: Mapping[str, Array], image: Image) -> dict[str, Array]:
    """Those of some values that there is one of for each texel (or element) of an output, in the
    shape of that output: (height, width, components)."""
    height, width = image.values.shape[:2]
    return {
        name: v.reshape(height, width, *v.shape[2:])
        for name, v in values.items()
        if v.shape[:2] == (height, width)
        or (v.shape[0] * v.shape[1] == height * width and 1 in (v.shape[0], height))
    }
