"""Microfacets: a rough surface as many small mirrors, with the Cook–Torrance reflectance D·F·G.

Sources: R. L. Cook, K. E. Torrance, "A Reflectance Model for Computer Graphics", ACM Transactions
on Graphics 1(1), 1982 (the product); B. Walter, S. R. Marschner, H. Li, K. E. Torrance, "Microfacet
Models for Refraction through Rough Surfaces", EGSR 2007, equations 33 (D, "GGX") and 34 (its
masking); C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", Computer Graphics
Forum 13(3), 1994, equation 15 (F) and section 4 (the rational G); B. Karis, "Real Shading in Unreal
Engine 4", SIGGRAPH course notes 2013 (α = roughness², k = (roughness + 1)² / 8 for direct light,
k = α / 2 for light from everywhere).

Cosines and factors are (…, 1), colours (…, 3).
"""

from __future__ import annotations

import math

from shaderlab.glslmath import Value, cross, dot, either, max, mix, normalize, sqrt

PI = 3.14159265359


def distribution(normal_half: Value, roughness: Value) -> Value:
    """D: the density of microfacets that face the halfway vector.

    α² / (π ((n·h)² (α² − 1) + 1)²) with α = roughness². Over the hemisphere D·(n·h) has the
    integral 1: seen from above, the microfacets cover the surface once.

    Args:
        normal_half: n·h, 0…1.
        roughness: above 0, up to 1.

    >>> print(f"{distribution(1.0, 0.5):.6f}")
    5.092958
    """
    alpha = roughness * roughness
    squared = alpha * alpha
    bracket = normal_half * normal_half * (squared - 1.0) + 1.0
    return squared / (PI * bracket * bracket)


def distribution_of(normal: Value, half: Value, roughness: Value) -> Value:
    """`distribution` from the vectors, in a form without cancellation where n and h are close.

    (n·h)² (α² − 1) + 1 = α² (n·h)² + |n × h|² for unit vectors; exactly the same number.

    >>> print(f"{distribution_of(np.eye(3)[2], np.array([0.6, 0.0, 0.8]), 0.5).item():.6f}")
    0.124340
    """
    alpha = roughness * roughness
    squared = alpha * alpha
    cosine = dot(normal, half)
    aside = cross(normal, half)
    bracket = squared * cosine * cosine + dot(aside, aside)
    return squared / (PI * bracket * bracket)


def distribution_either(normal: Value, half: Value, roughness: Value) -> Value:
    """`distribution_of`, or `distribution` of max(n·h, 0) as printed: a shader may use either.
    They differ only where h lies below the surface, which reflects nothing there.

    >>> up, half = np.eye(3)[2], np.array([0.6, 0.0, 0.8])
    >>> print(f"{distribution_either(up, half, 0.5).item():.6f}")
    0.124340
    """
    printed = distribution(max(dot(normal, half), 0.0), roughness)
    return either(distribution_of(normal, half, roughness), printed)


def shadowing(cosine: Value, roughness: Value) -> Value:
    """One factor of G: the share of microfacets that others do not hide at an angle.

    >>> print(f"{shadowing(1.0, 0.5):.6f} {shadowing(0.5, 0.5):.6f}")
    1.000000 0.780488
    """
    grown = roughness + 1.0
    k = grown * grown / 8.0
    return cosine / (cosine * (1.0 - k) + k)


def shadowing_under_sky(cosine: Value, roughness: Value) -> Value:
    """The rational factor of G with k = α/2, for light from everywhere.

    >>> print(f"{shadowing_under_sky(0.5, 0.5):.6f}")
    0.888889
    """
    k = 0.5 * (roughness * roughness)
    return cosine / (cosine * (1.0 - k) + k)


def masking(cosine: Value, roughness: Value) -> Value:
    """The factor of G that follows from GGX's distribution: 2c / (c + √(α² + (1 − α²) c²)).

    >>> print(f"{masking(0.5, 0.5):.6f}")
    0.957064
    """
    alpha = roughness * roughness
    squared = alpha * alpha
    return 2.0 * cosine / (cosine + sqrt(squared + (1.0 - squared) * (cosine * cosine)))


def geometry(normal_view: Value, normal_light: Value, roughness: Value) -> Value:
    """G: the share visible to both viewer and light (B. Smith, 1967).

    >>> print(f"{geometry(0.5, 0.5, 0.5):.6f}")
    0.609161
    """
    return shadowing(normal_view, roughness) * shadowing(normal_light, roughness)


def fresnel(cosine: Value, f0: Value) -> Value:
    """F: a mirror reflects f0 at normal incidence, and everything at a grazing angle.

    f0 + (1 − f0)(1 − cos θ)⁵, θ between the viewer and the halfway vector.

    >>> print(f"{fresnel(1.0, 0.04):.6f} {fresnel(0.5, 0.04):.6f} {fresnel(0.0, 0.04):.6f}")
    0.040000 0.070000 1.000000
    """
    grazing = 1.0 - cosine
    grazing2 = grazing * grazing
    return f0 + (1.0 - f0) * (grazing2 * grazing2 * grazing)


def base_reflectance(albedo: Value, metallic: Value) -> Value:
    """f0: 0.04 for dielectrics, the albedo for metals.

    0.04 is ((n − 1) / (n + 1))² for an index of 1.5; glass of 1.52 has 0.0426.

    >>> float(base_reflectance(0.9, 0.0)), float(base_reflectance(0.9, 1.0))
    (0.04, 0.9)
    """
    return mix(0.04, albedo, metallic)


def radiance(
    normal: Value, view: Value, light: Value, albedo: Value, metallic: Value, roughness: Value
) -> Value:
    """The radiance reflected of light of strength 1: (k_d·albedo/π + D·F·G/(4 n·v n·l)) n·l.

    Args:
        normal, view, light: unit vectors away from the surface.
        albedo: (…, 3), linear.
        metallic, roughness: 0…1; roughness above 0.

    The denominator has 0.0001 added against a division by zero.

    >>> up, grey = np.array([0.0, 0.0, 1.0]), np.full(3, 0.5)
    >>> radiance(up, up, up, grey, 0.0, 0.5).round(6).tolist()
    [0.203717, 0.203717, 0.203717]
    """
    half = normalize(view + light)
    normal_view = max(dot(normal, view), 0.0)
    normal_light = max(dot(normal, light), 0.0)
    d = distribution_either(normal, half, roughness)
    g = geometry(normal_view, normal_light, roughness)
    f = fresnel(dot(half, view), base_reflectance(albedo, metallic))
    specular = d * g * f / (4.0 * normal_view * normal_light + 0.0001)
    diffuse = (1.0 - f) * (1.0 - metallic) * albedo / PI
    return (diffuse + specular) * normal_light


def facing_share(roughness: float, points: int = 256) -> float:
    """The integral of D·(n·h) over the hemisphere, by Gauss–Legendre quadrature: 1.

    The variable is u = (n·h)², over which D·(n·h) dω = π D(u) du.

    >>> print(f"{facing_share(0.5):.9f}")
    1.000000000
    """
    import numpy as np

    # u = 1 − t⁶ crowds the points where a smooth surface has its peak.
    nodes, weights = np.polynomial.legendre.leggauss(points)
    t = 0.5 * (nodes + 1.0)
    u, du = 1.0 - t**6, 6.0 * t**5
    values = distribution(np.sqrt(u), roughness)
    return float(math.pi * np.sum(0.5 * weights * values * du))
