"""Textures before any device: the values that are uploaded, and the samplers that may read them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from shaderlab.compiler.interface import Variable
from shaderlab.errors import CaseError, nearest
from shaderlab.model.frame import Array, Image
from shaderlab.model.textures import (
    CubeTexture,
    Output,
    Texture,
    Texture3D,
    TextureArray,
    TextureSource,
    level_sizes,
)

from .formats import format_of

MADE = 20 << 20
"""Bytes of what functions made that are kept for the next scenes, the last used of it."""
_MADE: WeakKeyDictionary[Callable[[], Any], Array] = WeakKeyDictionary()
Images = Mapping[tuple[str, str], Image]
"""What earlier passes have drawn, by (pass, output)."""


@dataclass(frozen=True)
class Contents:
    """What a texture is made of: `layers` of one size (one image, an array's, or a cube's six),
    each (height, width, channels) of the format's own type, and further levels of one image."""

    layers: Sequence[Array]
    smaller: Sequence[Array] = ()


def contents(
    source: Texture | TextureArray | CubeTexture, folder: Path, images: Images
) -> Contents:
    """The values of a texture that are uploaded.

    Args:
        source: the texture.
        folder: where paths of image files begin.
        images: what its layers may be copied from.

    Raises:
        CaseError: an image does not fit the format or the others, or does not exist.
        AssetError: an image file can't be read.
    """

    def values(image: Any, owner: str) -> Array:
        image = find_image(image, images) if isinstance(image, Output) else image
        return pixel_values(image, source.format, folder, owner)

    if isinstance(source, Texture):
        first = values(source.image, "Texture")
        if isinstance(source.mipmaps, bool):
            return Contents([first])
        smaller = [values(level, "Texture: a mipmap level") for level in source.mipmaps]
        _check_levels(first, smaller)
        return Contents([first], smaller)
    cube = isinstance(source, CubeTexture)
    owner = "CubeTexture: face" if cube else f"{type(source).__name__}: layer"
    given = source.faces if isinstance(source, CubeTexture) else source.layers
    layers = [values(image, f"{owner} {number}") for number, image in enumerate(given)]
    if cube:  # t runs down on a cube: files begin with the row that its faces begin with
        files = [isinstance(image, str | Path) for image in given]
        layers = [
            np.ascontiguousarray(layer[::-1]) if file else layer
            for layer, file in zip(layers, files, strict=True)
        ]
    height, width = layers[0].shape[:2]
    for number, image in enumerate(layers):
        if image.shape != layers[0].shape:
            raise CaseError(
                f"{owner} {number} is {image.shape[1]} × {image.shape[0]}, "
                f"the first one {width} × {height}"
            )
    if cube and height != width:
        raise CaseError(f"CubeTexture: its faces are {width} × {height}, not square")
    return Contents(layers)


def layers_of(image: Image) -> Contents:
    """What a texture of a dispatch's image is made of."""
    if not image.layers:
        return Contents([image.values])
    return Contents(list(image.values.reshape(image.layers, -1, *image.values.shape[1:])))


def find_image(source: Output, images: Images) -> Image:
    """The output of an earlier pass. Raises CaseError if there is none."""
    key = (source.pass_name, source.name)
    if key not in images:
        known = [f"{p}.{n}" for p, n in images]
        raise CaseError(
            f"no earlier pass gives {source.path}",
            remedy=nearest(source.path, known),
        )
    return images[key]


def pixel_values(image: Any, format: str, folder: Path, owner: str) -> Array:
    """One image: an array, a function that makes one, a file's path, or an earlier pass's output.
    Floats for an 8-bit format are taken as 0…1 and rounded to the nearest code.

    Raises:
        CaseError: it has another shape than the format takes.
        AssetError: a file can't be read.
    """
    wanted, channels = format_of(format).numpy, format_of(format).components
    if isinstance(image, str | Path):
        from shaderlab.model.pictures import load

        image = load(folder / image)
    elif callable(image):
        image = _made(image)
    if isinstance(image, Image):
        if image.layers:
            raise CaseError(f"{owner}: an image of {image.layers} layers is no layer of another")
        codes = image.values.dtype == np.uint8 and wanted is not np.uint8
        values = image.values / 255.0 if codes else image.values
    else:
        values = np.asarray(image)
    if values.ndim == 2:
        values = values[:, :, None]
    if values.ndim != 3 or values.shape[2] < channels or 0 in values.shape:
        raise CaseError(
            f"{owner}: a {format} texture takes (height, width, {channels}), not {values.shape}"
        )
    values = values[:, :, :channels]
    if wanted is np.uint8 and values.dtype.kind == "f":
        values = np.rint(np.clip(values, 0.0, 1.0) * 255.0)
    # What nobody can write to is what it was when it is uploaded: it needs no copy.
    return np.ascontiguousarray(values.astype(wanted, copy=values.flags.writeable))


def _made(function: Callable[[], Any]) -> Array:
    """What a function makes. It is called once while there is room, though each scene that is
    drawn asks for it."""
    try:
        known = _MADE.get(function)
    except TypeError:  # an object that can't be a key
        return np.asarray(function())
    if known is None:
        known = np.array(function())
        known.flags.writeable = False
        while _MADE and sum(values.nbytes for values in _MADE.values()) + known.nbytes > MADE:
            del _MADE[next(iter(_MADE))]  # the one whose use is longest ago
    else:
        del _MADE[function]
    _MADE[function] = known
    return known


def forget_made() -> None:
    """Free what functions have made; the next scene that asks has them called again."""
    _MADE.clear()


def _check_levels(first: Array, smaller: Sequence[Array]) -> None:
    """Raise CaseError unless these are all the levels below `first`, in order."""
    sizes = level_sizes(first.shape[1], first.shape[0])[1:]
    given = [(level.shape[1], level.shape[0]) for level in smaller]
    if given != sizes:
        listed = ", ".join(f"{w} × {h}" for w, h in given) or "nothing"
        raise CaseError(
            f"a texture of {first.shape[1]} × {first.shape[0]}: its smaller mipmap levels are "
            f"{listed}",
            remedy=f"mipmaps=True, or all of {', '.join(f'{w} × {h}' for w, h in sizes)}",
        )


def kind_of(source: TextureSource, declared: str, samples: int, layers: int = 0) -> str:
    """The kind that a texture is when it is read by a sampler of the type `declared`.

    Args:
        source: the texture.
        declared: the sampler's type: the output of a multisampled target is "2DMS" to a
            sampler2DMS, and "2D", its samples averaged, to all others.
        samples: how many samples the target has that `source` is an output of; 0 for one.
        layers: how many layers the image has that `source` is an output of.
    """
    if isinstance(source, CubeTexture):
        return "Cube"
    if isinstance(source, TextureArray):
        return "3D" if isinstance(source, Texture3D) else "2DArray"
    if layers:
        return "2DArray"
    return "2DMS" if samples and "2DMS" in declared and isinstance(source, Output) else "2D"


def check_sampler(
    program: str, variable: Variable, source: TextureSource, kind: str, format: str
) -> None:
    """Check that a sampler's type is that of its texture.

    Raises:
        CaseError: it is another; names the sampler's type and the texture's.
    """
    shadow = source.compare is not None
    fitting = f"{format_of(format).scalar}sampler{kind}{'Shadow' * shadow}"
    if variable.type == fitting:
        return
    what = type(source).__name__
    described = f"{what}(compare={source.compare!r})" if shadow else what
    remedy = f"declare it {fitting}"
    if variable.type.endswith("Shadow") and not shadow:
        remedy = 'give the texture compare="lequal", or declare it ' + fitting
    elif shadow and variable.type == fitting.removesuffix("Shadow"):
        remedy = f"declare it {fitting}, or leave compare= out"
    raise CaseError(
        f"{program}: {variable.name!r} is a {variable.type}, but the {described} given for it, "
        f"{format}, is read by a {fitting}",
        remedy=remedy,
    )
