"""A spotlight's soft edge: a linear ramp between two cosines.

Source: J. de Vries, "Learn OpenGL" (2020), chapter "Light casters", soft edges; the ratio is the
inverse of a linear interpolation over the cosine, not over the angle.
"""

from __future__ import annotations

from shaderlab.glslmath import Value, clamp, dot, normalize


def spot_cosine(FragPos: Value, light_position: Value, light_direction: Value) -> Value:
    """θ as a cosine: between the axis of the spot and the ray from the light to the fragment.

    Args:
        FragPos: the fragment, (…, 3), not at the light itself.
        light_position: the light, (3,).
        light_direction: where it points, (3,), of any length but 0.

    Returns cos θ in −1…1, (…, 1).

    >>> fragment, lamp, axis = np.eye(3)[0], np.zeros(3), np.array([1.0, 0.0, -1.0])
    >>> print(f"{spot_cosine(fragment, lamp, axis).item():.6f}")
    0.707107
    """
    light_dir = normalize(light_position - FragPos)
    return dot(light_dir, normalize(-light_direction))


def ratio_of_cosines(theta: Value, light_cutOff: Value, light_outerCutOff: Value) -> Value:
    """(θ − γ) / (φ − γ), all three as cosines; 1 on the inner cone, 0 on the outer, unclamped.

    Args:
        theta: cos θ of the fragment.
        light_cutOff: cos φ, φ the half angle of the fully lit inner cone.
        light_outerCutOff: cos γ, γ > φ the half angle beyond which it is dark.

    >>> from math import cos, radians
    >>> angles = (30.0, 25.0, 35.0)
    >>> print(f"{ratio_of_cosines(*(cos(radians(a)) for a in angles)):.6f}")
    0.537811
    """
    return (theta - light_outerCutOff) / (light_cutOff - light_outerCutOff)


def spot_ratio(
    FragPos: Value,
    light_position: Value,
    light_direction: Value,
    light_cutOff: Value,
    light_outerCutOff: Value,
) -> Value:
    """`ratio_of_cosines` at a fragment: above 1 inside the inner cone, negative outside.

    >>> lamp, down = np.zeros(3), np.array([0.0, 0.0, -1.0])
    >>> print(f"{spot_ratio(np.array([0.6, 0.0, -0.8]), lamp, down, 0.9, 0.7).item():.6f}")
    0.500000
    """
    theta = spot_cosine(FragPos, light_position, light_direction)
    return ratio_of_cosines(theta, light_cutOff, light_outerCutOff)


def spot_intensity(
    FragPos: Value,
    light_position: Value,
    light_direction: Value,
    light_cutOff: Value,
    light_outerCutOff: Value,
) -> Value:
    """I = clamp((θ − γ) / (φ − γ), 0, 1): the share of the spot's light, 0…1.

    >>> lamp, down = np.zeros(3), np.array([0.0, 0.0, -1.0])
    >>> print(f"{spot_intensity(np.array([0.8, 0.0, -0.6]), lamp, down, 0.9, 0.7).item():.6f}")
    0.000000
    """
    ratio = spot_ratio(FragPos, light_position, light_direction, light_cutOff, light_outerCutOff)
    return clamp(ratio, 0.0, 1.0)
