"""Light sources: directional, point and spot lights with ambient, diffuse and specular parts.

Each gives what the lamp adds to a surface's colour: an ambient, a diffuse and a specular part. The
surface has a colour of its own (for ambient and diffuse), a specular colour and a shininess.

Sources: "The OpenGL Graphics System: A Specification", version 1.0 (M. Segal, K. Akeley, 1992),
section 2.13.1, equation 2.1 (lights at infinity, positional lights, distance attenuation, hard
spotlight cut-off); J. de Vries, "Learn OpenGL" (2020), chapter "Light casters" (soft spotlight
edges).

Places, directions and colours are (…, 3), factors (…, 1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from shaderlab.glslmath import Value, length, normalize, where
from shaderlab.reference.attenuation import attenuation
from shaderlab.reference.lighting import diffuse, phong
from shaderlab.reference.spotlight import spot_cosine, spot_intensity


def directed(
    direction: Value,
    view: Value,
    Normal: Value,
    Color: Value,
    specular: Value,
    shininess: Value,
    light_diffuse: Value,
    light_specular: Value,
    highlight: Callable[..., Value] = phong,
) -> Value:
    """Diffuse and specular part of light from one direction, (…, 3).

    Args:
        direction, view: from the surface to the lamp and to the viewer, of any length but 0.
        highlight: the lobe of the specular part, of the arguments of `lighting.phong`.

    >>> up, white = np.eye(3)[2], np.ones(3)
    >>> directed(up, up, up, 0.25 * white, 0.5 * white, 8.0, white, white).tolist()
    [0.75, 0.75, 0.75]
    """
    diff = diffuse(Normal, direction)
    spec = highlight(Normal, direction, view, shininess)
    return light_diffuse * (diff * Color) + light_specular * (spec * specular)


def direction_to_light(light_direction: Value) -> Value:
    """The unit vector opposite to the light's direction of travel.

    >>> direction_to_light(np.array([-0.2, -1.0, -0.3])).round(6).tolist()
    [0.188144, 0.940721, 0.282216]
    """
    return normalize(-light_direction)


def directional(
    FragPos: Value,
    Normal: Value,
    Color: Value,
    viewPos: Value,
    specular: Value,
    shininess: Value,
    light_direction: Value,
    light_ambient: Value,
    light_diffuse: Value,
    light_specular: Value,
) -> Value:
    """Directional light: parallel, without attenuation.

    >>> down, white, eye = np.array([0.0, 0.0, -1.0]), np.ones(3), np.array([0.0, 0.0, 3.0])
    >>> dark = np.zeros(3)
    >>> directional(dark, -down, 0.5 * white, eye, dark, 8.0, down, 0.1 * white, white, white)
    array([0.55, 0.55, 0.55])
    """
    surface, lamp = (Normal, Color, specular, shininess), (light_diffuse, light_specular)
    part = directed(-light_direction, viewPos - FragPos, *surface, *lamp)
    return light_ambient * Color + part


def fading(
    FragPos: Value,
    light_position: Value,
    light_constant: Value,
    light_linear: Value,
    light_quadratic: Value,
) -> Value:
    """The attenuation of a lamp's light at a fragment, (…, 1).

    >>> print(f"{fading(np.zeros(3), np.array([0.0, 0.0, 50.0]), 1.0, 0.09, 0.032).item():.9f}")
    0.011695906
    """
    away = length(light_position - FragPos)
    return attenuation(away, light_constant, light_linear, light_quadratic)


def point(
    FragPos: Value,
    Normal: Value,
    Color: Value,
    viewPos: Value,
    specular: Value,
    shininess: Value,
    light_position: Value,
    light_constant: Value,
    light_linear: Value,
    light_quadratic: Value,
    light_ambient: Value,
    light_diffuse: Value,
    light_specular: Value,
    highlight: Callable[..., Value] = phong,
) -> Value:
    """A point light; attenuation applies to all three parts.

    >>> up, white, dark = np.eye(3)[2], np.ones(3), np.zeros(3)
    >>> lit = point(dark, up, white, 3 * up, dark, 8.0, 2 * up, 1.0, 0.0, 0.25, dark, white, white)
    >>> lit.tolist()
    [0.5, 0.5, 0.5]
    """
    surface, lamp = (Normal, Color, specular, shininess), (light_diffuse, light_specular)
    part = directed(light_position - FragPos, viewPos - FragPos, *surface, *lamp, highlight)
    left = fading(FragPos, light_position, light_constant, light_linear, light_quadratic)
    return left * (light_ambient * Color + part)


def hard_spot(
    FragPos: Value,
    Normal: Value,
    Color: Value,
    viewPos: Value,
    specular: Value,
    shininess: Value,
    light_position: Value,
    light_direction: Value,
    light_cutOff: Value,
    light_ambient: Value,
    light_diffuse: Value,
    light_specular: Value,
) -> Value:
    """A spot light with a hard edge: all parts where cos θ > cos φ, else the ambient part alone.

    >>> up, white, dark = np.eye(3)[2], np.ones(3), np.zeros(3)
    >>> hard_spot(dark, up, white, up, dark, 8.0, up, -up, 0.9, 0.1 * white, white, dark)
    array([1.1, 1.1, 1.1])
    >>> hard_spot(dark, up, white, up, dark, 8.0, up, up, 0.9, 0.1 * white, white, dark)
    array([0.1, 0.1, 0.1])
    """
    theta = spot_cosine(FragPos, light_position, light_direction)
    surface, lamp = (Normal, Color, specular, shininess), (light_diffuse, light_specular)
    part = directed(light_position - FragPos, viewPos - FragPos, *surface, *lamp)
    ambient = light_ambient * Color
    return where(theta > light_cutOff, ambient + part, ambient)


def soft_spot(
    FragPos: Value,
    Normal: Value,
    Color: Value,
    viewPos: Value,
    specular: Value,
    shininess: Value,
    light_position: Value,
    light_direction: Value,
    light_cutOff: Value,
    light_outerCutOff: Value,
    light_constant: Value,
    light_linear: Value,
    light_quadratic: Value,
    light_ambient: Value,
    light_diffuse: Value,
    light_specular: Value,
) -> Value:
    """A spot light with a soft edge; the ambient part is not limited to the cone.

    >>> up, white, dark, full = np.eye(3)[2], np.ones(3), np.zeros(3), (1.0, 0.0, 0.0)
    >>> soft_spot(dark, up, white, up, dark, 8.0, up, -up, 0.9, 0.8, *full, dark, white, dark)
    array([1., 1., 1.])
    """
    surface, lamp = (Normal, Color, specular, shininess), (light_diffuse, light_specular)
    part = directed(light_position - FragPos, viewPos - FragPos, *surface, *lamp)
    cone = spot_intensity(FragPos, light_position, light_direction, light_cutOff, light_outerCutOff)
    left = fading(FragPos, light_position, light_constant, light_linear, light_quadratic)
    return left * (light_ambient * Color + cone * part)


def points(
    FragPos: Value,
    Normal: Value,
    Color: Value,
    viewPos: Value,
    specular: Value,
    shininess: Value,
    pointLights_position: Sequence[Value],
    pointLights_constant: Sequence[Value],
    pointLights_linear: Sequence[Value],
    pointLights_quadratic: Sequence[Value],
    pointLights_ambient: Sequence[Value],
    pointLights_diffuse: Sequence[Value],
    pointLights_specular: Sequence[Value],
    highlight: Callable[..., Value] = phong,
) -> Value:
    """The sum of several point lights; each argument of theirs is a list.

    >>> up, white, dark = np.eye(3)[2], np.ones(3), np.zeros(3)
    >>> lamps = [[2 * up, up], [1.0, 1.0], [0.0, 0.0], [0.25, 0.0], [dark] * 2, [white] * 2]
    >>> points(dark, up, white, 3 * up, dark, 8.0, *lamps, [white] * 2).tolist()
    [1.5, 1.5, 1.5]
    """
    surface = (FragPos, Normal, Color, viewPos, specular, shininess)
    lit = partial(point, *surface, highlight=highlight)
    total: Value = np.zeros(1)
    for lamp in zip(
        pointLights_position,
        pointLights_constant,
        pointLights_linear,
        pointLights_quadratic,
        pointLights_ambient,
        pointLights_diffuse,
        pointLights_specular,
        strict=True,
    ):
        total = total + lit(*lamp)
    return total
