"""Crates of wood in the studio's light: boxes that are only turned and moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy.typing as npt

from shaderlab import Cell, Draw, Texture, assets
from shaderlab.glslmath import Value, mul, swizzle
from shaderlab.glslmath.sampling import texture

from .drawing import decoded
from .draws import tested
from .studio import studio_color


def crates(
    models: Sequence[npt.NDArray[Any]],
    camera: Mapping[str, Any],
    wood: Texture,
    cell: Cell | None = None,
) -> list[Draw]:
    """A draw for each crate, numbered from 1.

    Args:
        models: where they stand, from the unit box around the origin.
        camera: the uniforms `view` and `projection`.
        wood: on each of their faces.
        cell: the part of the target to draw into.

    >>> wood = Texture(image=assets.checker)
    >>> [draw.uniforms["number"] for draw in crates([np.eye(4)] * 2, {}, wood)]
    [1.0, 2.0]
    """
    return [
        tested(
            "ch04_spaces/ten_cubes",
            assets.cube(),
            {"model": model, **camera, "number": float(number)},
            textures={"wood": wood},
            cell=cell,
        )
        for number, model in enumerate(models, 1)
    ]


def of_wood(Normal: Value, TexCoords: Value, wood: Any) -> Value:
    """The texel under a pixel, in the studio's light."""
    return wooden(swizzle(texture(wood, TexCoords), "xyz"), Normal)


def wooden(texel: Value, Normal: Value) -> Value:
    """A texel of wood in the studio's light.

    >>> wooden(np.array([0.5, 0.5, 0.5]), np.array([0.0, 2.0, 0.0])).round(6).tolist()
    [0.573462, 0.573462, 0.573462, 1.0]
    """
    return studio_color(1.3 * decoded(texel), Normal)


def turned_normal(aNormal: Value, model: Value) -> Value:
    """A normal of a box that is only turned.

    >>> turned_normal(np.array([1.0, 2.0, 3.0]), np.eye(4)).tolist()
    [1.0, 2.0, 3.0]
    """
    return mul(model[:3, :3], aNormal)
