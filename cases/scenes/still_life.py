"""A still life for passes that need a picture to work on: clear colours on a chessboard floor."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab import Output, Pass, Ramp, Target, measure
from shaderlab.assets.meshes import Geometry, joined, moved, sphere, torus
from shaderlab.model.textures import TextureSource
from shaderlab.reference.rasterisation import samples_seen

from .cameras import camera
from .figures import figure, ground
from .painted_solids import box, painted
from .panels import WHOLE, panel_pass
from .props import letter_f
from .remembered import remembered
from .stage import SKY, prop, prop_checks
from .studio import studio_color

Array = npt.NDArray[Any]

CAMERA = camera((0.0, 2.4, 4.4), (0.0, 0.35, 0.1), 38.0)
CORAL, BLUE, GREEN = (1.0, 0.5, 0.31), (0.10, 0.22, 0.75), (0.16, 0.52, 0.20)
SCENE = Output("scene.FragColor")
"""What `photographed` draws, to be read by the next pass."""
HUES = {"coral": CORAL, "blue": BLUE, "green": GREEN}


@remembered
def still_life() -> Geometry:
    """A letter, a coral ball, a blue ring and a green box on a floor of 4 × 4, as one mesh.

    >>> sorted(still_life()["attributes"])
    ['aColor', 'aNormal', 'aPos']
    """
    return joined(
        moved(painted(sphere(0.42), CORAL), _at(0.35, 0.42, 0.55)),
        moved(painted(torus(0.46, 0.17), BLUE), _at(-0.75, 0.18, 0.95)),
        moved(letter_f(), _at(-0.95, 0.01, -0.35)),
        painted(box((0.75, 0.01, -1.1), (1.45, 1.05, -0.4)), GREEN),
        *(_field(x, z) for x in range(-4, 4) for z in range(-4, 4)),
    )


def photographed(name: str = "scene", size: tuple[int, int] | None = None) -> Pass:
    """A pass that draws the still life, turned a little to the left; `size` is the target's."""
    target = Target(depth="depth24", clear=SKY, size=size)
    model = np.eye(4)
    c, s = np.cos(0.2), np.sin(0.2)
    model[:3, :3] = (c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)
    draw = prop(still_life(), CAMERA, model=model)
    return Pass(name=name, target=target, draws=(draw,))


def post_processed(
    shader: str,
    source: TextureSource,
    name: str = "picture",
    *,
    domain: Mapping[str, Ramp] = WHOLE,
    size: tuple[int, int] | None = None,
    **uniforms: Any,
) -> Pass:
    """A pass over the whole target that reads a picture as `screenTexture`.

    Args:
        shader: its name in chapter 8.
        source: the picture: `SCENE`, another pass's output, or a texture.
        name: of the pass.
        domain: where it reads, if not each place once.
        size: of the target; a case's own by default.
        uniforms: what else the shader asks for.

    >>> post_processed("post_inversion", SCENE).name
    'picture'
    """
    fragment, textures = f"ch08_techniques/{shader}.frag", {"screenTexture": source}
    return panel_pass(name, fragment, domain, uniforms, textures=textures, size=size)


def photograph_checks(*, side: int = 64, pass_name: str = "scene") -> tuple[Any, ...]:
    """What must hold of the still life: as of a prop; and what is in front hides what is behind, so
    that coral, blue and green each have as much of the picture as the mesh says.

    `side` is that of its target, by default as cases are judged.
    """
    return (
        *prop_checks(pass_name=pass_name),
        figure(
            f"{pass_name}.FragColor",
            "black, facing up",
            {"Color": (0.0, 0.0, 0.0), "Normal": (0.0, 2.0, 0.0)},
            (0.0, 0.0, 0.0, 1.0),
            reference=studio_color,
        ),
        *hue_checks(side, pass_name),
    )


def hue_checks(side: int, pass_name: str, of: str = "") -> Iterator[Any]:
    """Coral, blue and green each have as much of a pass of `side` pixels as the mesh says, and the
    sky has its corners; `of` tells passes apart.

    >>> [check.name for check in hue_checks(64, "scene")]
    ['coral in the picture', 'blue in the picture', 'green in the picture', 'sky']
    """
    for word, counts in zip(HUES, _in_sight(side), strict=True):
        yield measure(
            f"{of}{word} in the picture",
            _count,
            reads={"picture": f"{pass_name}.FragColor"},
            given={"of": HUES[word]},
            between=counts,
            note="pixels; what stands in front hides the rest",
        )
    yield ground(f"{pass_name}.FragColor", SKY, f"{of}sky")


@functools.cache
def _in_sight(side: int) -> tuple[tuple[int, int], ...]:
    """How many pixels of each hue are seen, at least and at most: from the mesh."""
    geometry, draw = still_life(), photographed().draws[0]
    matrices = (np.asarray(draw.uniforms[name]) for name in ("projection", "view", "model"))
    places = np.insert(geometry["attributes"]["aPos"], 3, 1.0, axis=1)
    corners = geometry["indices"].reshape(-1, 3)
    clip = (places @ functools.reduce(np.matmul, matrices).T)[corners]
    # What a closed solid turns away lies behind what it turns here.
    here = _turned_here(clip)
    clip, colors = clip[here], geometry["attributes"]["aColor"][corners[here, 0]]
    of = [np.isclose(colors, hue).all(axis=1) for hue in HUES.values()]
    draws = [*(clip[mine] for mine in of), clip[~np.any(of, axis=0)]]
    return samples_seen(draws, (side, side))[: len(HUES)]


def _turned_here(clip: Array) -> Array:
    """Which triangles, given in clip coordinates, have their corners counter-clockwise."""
    a, b, c = np.moveaxis(clip[..., :2] / clip[..., 3:], 1, 0)
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0.0)


def _count(picture: Array, of: Array) -> int:
    """The pixels that are one colour in some light, cut off at white."""
    shown = np.clip(picture[..., :3], 0.0, 1.0) ** 2.2
    least = np.argmin(of)
    light = shown[..., least, None] / of[least]
    alike = np.abs(np.minimum(light * of, 1.0) - shown).max(axis=-1) < 0.02 * shown.max(axis=-1)
    return int(np.count_nonzero(alike))


def _field(x: int, z: int) -> Geometry:
    paper = (0.78, 0.76, 0.70) if (x + z) % 2 else (0.42, 0.44, 0.47)
    return painted(box((x / 2, -0.06, z / 2), ((x + 1) / 2, 0.0, (z + 1) / 2)), paper)


def _at(x: float, y: float, z: float) -> Array:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix
