"""Attenuation: how a point source's light decreases with distance.

Source: "The OpenGL Graphics System: A Specification", version 1.0 (M. Segal, K. Akeley, 1992),
section 2.13.1, the distance attenuation factor of a positional light: 1 / (k0 + k1·d + k2·d²).
"""

from __future__ import annotations

from shaderlab.glslmath import Value, sqrt


def attenuation(
    distance: Value, light_constant: Value, light_linear: Value, light_quadratic: Value
) -> Value:
    """The fraction of the light that remains: F(d) = 1 / (Kc + Kl·d + Kq·d²).

    Args:
        distance: d ≥ 0, from the light to the lit point, in units of the scene.
        light_constant: Kc, without unit; 1 keeps F(0) = 1.
        light_linear: Kl ≥ 0, per unit of distance.
        light_quadratic: Kq ≥ 0, per unit of distance squared.

    Returns F in 0…1/Kc.

    >>> print(f"{attenuation(50.0, 1.0, 0.09, 0.032):.9f}")
    0.011695906
    """
    return 1.0 / (
        light_constant + light_linear * distance + light_quadratic * (distance * distance)
    )


def reach(
    fraction: Value, light_constant: Value, light_linear: Value, light_quadratic: Value
) -> Value:
    """The distance at which `fraction` of the light remains: the inverse of `attenuation`.

    It is the positive root of Kq·d² + Kl·d − c = 0 with c = 1/f − Kc, in a form without
    cancellation: d = 2c / (Kl + √(Kl² + 4·Kq·c)). It is the radius of a light volume in deferred
    shading.

    Args:
        fraction: f in 0…1/Kc, above 0.
        light_constant, light_linear, light_quadratic: as for `attenuation`; Kl > 0.

    Returns d ≥ 0, in units of the scene.

    >>> print(f"{reach(0.05, 1.0, 0.09, 0.032).item():.6f}")
    23.001280
    """
    missing = 1.0 / fraction - light_constant
    root = sqrt(light_linear * light_linear + 4.0 * light_quadratic * missing)
    return 2.0 * missing / (light_linear + root)


def crossover(light_linear: Value, light_quadratic: Value) -> Value:
    """The distance beyond which the quadratic term exceeds the linear one: Kl / Kq.

    >>> crossover(0.09, 0.032)
    2.8125
    """
    return light_linear / light_quadratic
