"""What the two shaders of the shadow cases must give, output by output.

Sources: as in `shaderlab.reference.shadows` and, for the lamp's terms, in
`shaderlab.reference.blinn_phong`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from shaderlab.glslmath import Value, dot, max, mul, normalize, swizzle, vec4
from shaderlab.reference.blinn_phong import lobe
from shaderlab.reference.shadows import shadow_of_fragment
from shaderlab.reference.transforms import clip_position, world_normal, world_position

from .studio import handed_on

Reference = Callable[..., Any]


def light_position(aPos: Value, model: Value, lightSpaceMatrix: Value) -> Value:
    """Clip coordinates seen from the light, (…, 4).

    >>> light_position(np.ones(3), np.eye(4), 2.0 * np.eye(4)).tolist()
    [2.0, 2.0, 2.0, 2.0]
    """
    return mul(lightSpaceMatrix, mul(model, vec4(aPos, 1.0)))


def stored_depth(frag_coord: Value) -> Value:
    """What a shadow map keeps of a fragment: its window depth.

    >>> stored_depth(np.array([3.5, 4.5, 0.25, 1.0])).tolist()
    [0.25]
    """
    return swizzle(frag_coord, "z")


def unit_normal(Normal: Value) -> Value:
    """The interpolated normal, of length 1 again.

    >>> unit_normal(np.array([0.0, 3.0, 4.0])).tolist()
    [0.0, 0.6, 0.8]
    """
    return normalize(Normal)


def seen_place(FragPos: Value) -> Value:
    """The fragment's place in the world.

    >>> seen_place(2.0)
    2.0
    """
    return FragPos


def sunlit(
    FragPos: Value, Normal: Value, Color: Value, shadow: Value, lightPos: Value, viewPos: Value
) -> Value:
    """(0.15 + (1 − s)(N·L + 0.2 (N·H)³²)) · colour: a shadow takes the sun, not the sky.

    Args:
        FragPos, viewPos: places, (…, 3).
        Normal, lightPos: directions of any length, the latter to the sun.
        Color: (…, 3).
        shadow: s, 0 … 1.

    >>> up, grey = np.array([0.0, 1.0, 0.0]), np.full(3, 0.5)
    >>> sunlit(np.zeros(3), up, grey, 1.0, up, up).round(6).tolist()
    [0.075, 0.075, 0.075, 1.0]
    """
    normal, to_sun = normalize(Normal), normalize(lightPos)
    lambert = max(dot(normal, to_sun), 0.0)
    halfway = normalize(to_sun + normalize(viewPos - FragPos))
    glint = 0.2 * lobe(dot(normal, halfway), 32.0)
    return vec4((0.15 + (1.0 - shadow) * (lambert + glint)) * Color, 1.0)


def courtyard_references(texture: Callable[[Any, Value], Value]) -> Mapping[str, Reference]:
    """A reference for each output of the pass from the camera.

    Args:
        texture: how the shadow map is read; `shaderlab.sampling.texture`.

    >>> sorted(courtyard_references(lambda map, uv: uv))[:3]
    ['Color', 'FragColor', 'FragPos']
    """
    dark = shadow_of_fragment(texture)

    def color(
        FragPos: Value, Normal: Value, Color: Value, FragPosLightSpace: Value, shadowMap: Any,
        lightPos: Value, viewPos: Value, leastBias: Value, mostBias: Value, radius: Value,
    ) -> Value:  # fmt: skip
        shadow = dark(Normal, FragPosLightSpace, shadowMap, lightPos, leastBias, mostBias, radius)
        return sunlit(FragPos, Normal, Color, shadow, lightPos, viewPos)

    return {
        "gl_Position": clip_position,
        "FragPos": world_position,
        "Normal": world_normal,
        "FragPosLightSpace": light_position,
        "Color": handed_on,
        "shadow": dark,
        "place": seen_place,
        "upright": unit_normal,
        "FragColor": color,
    }
