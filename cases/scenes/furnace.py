"""The white furnace: what a rough surface reflects of a light that is 1 from every side.

A mirror that absorbs nothing (F = 1) must give all of it back. A microfacet model that follows one
bounce only gives back less: what a second bounce would bring out is lost.

Sources: B. Walter, S. R. Marschner, H. Li, K. E. Torrance, "Microfacet Models for Refraction
through Rough Surfaces", EGSR 2007, equations 35, 36 and 41 (sampling by D and the weight of a
sample); E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", Journal
of Computer Graphics Techniques 3(2), 2014, section 5 (the furnace as a test); C. Kulla, A. Conty,
"Revisiting Physically Based Shading at Imageworks", SIGGRAPH course, 2017 (later bounces).

Cosines and factors are (…, 1). α is roughness².
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab.glslmath import Value, max, sqrt, swizzle, vec4
from shaderlab.reference.microfacets import PI, distribution

Masking = Callable[[Value, Value], Value]


def reflected_share(
    normal_view: Value, roughness: Value, half_of_g: Masking, levels: int, ring: Any
) -> Value:
    """The share of a white furnace's light that leaves towards the viewer, for F = 1.

    The mean of G (v·h) / ((n·v) (n·h)) over halfway vectors chosen as D·(n·h) is distributed: at
    the middles of `levels` equal parts of their cumulative distribution, at azimuths whose
    cosines are `ring`. The other half of the azimuths gives the same.

    Args:
        normal_view: n·v, above 0.
        roughness: above 0, up to 1.
        half_of_g: `shadowing`, `shadowing_under_sky` or `masking`.
        levels: how many parts.
        ring: cosines of azimuths to the viewer, evenly over 0…π, as a sequence.

    >>> from shaderlab.reference.microfacets import masking
    >>> ring = np.cos((np.arange(8) + 0.5) / 8.0 * np.pi)
    >>> print(f"{reflected_share(0.7, 0.5, masking, 16, ring).item():.4f}")
    0.8940
    """
    alpha = roughness * roughness
    squared = alpha * alpha
    sine_view = sqrt(max(1.0 - normal_view * normal_view, 0.0))
    fours = [vec4(*ring[k : k + 4]) for k in range(0, len(ring), 4)]  # four azimuths at a time
    total: Value = 0.0
    for level in range(levels):
        u = (level + 0.5) / levels
        around = 1.0 - u + squared * u
        cosine = sqrt((1.0 - u) / around)
        sine = sqrt(squared * u / around)
        aside, upward = sine_view * sine, normal_view * cosine
        for azimuths in fours:
            view_half = max(aside * azimuths + upward, 0.0)
            normal_light = max(2.0 * view_half * cosine - normal_view, 0.0)
            parts = half_of_g(normal_light, roughness) * view_half / cosine
            for name in "xyzw":
                total = total + swizzle(parts, name)
    share = total * half_of_g(normal_view, roughness) / normal_view
    return share / float(levels * len(ring))


def reflected_share_by_directions(
    normal_view: float, roughness: float, half_of_g: Masking, points: int = 400
) -> float:
    """The same share by its definition, ∫ D G / (4 (n·v)) dω over directions of light.

    Gauss–Legendre in cos θ by the trapezoidal rule in the azimuth; for roughness 0.3 and more.

    >>> from shaderlab.reference.microfacets import masking
    >>> print(f"{reflected_share_by_directions(0.7, 0.5, masking):.4f}")
    0.8848
    """
    # In parts of 20 points: the nodes of 400 at once are the roots of a large matrix.
    nodes, weights = np.polynomial.legendre.leggauss(20)
    parts = points // 20
    cosine = ((np.arange(parts)[:, None] + 0.5 * (nodes + 1.0)) / parts).reshape(-1, 1)
    weights = np.tile(weights / parts, parts)
    phi = (np.arange(points) + 0.5)[None, :] * (2.0 * math.pi / points)
    sine = np.sqrt(1.0 - cosine * cosine)
    view = np.array([math.sqrt(1.0 - normal_view**2), 0.0, normal_view])
    x, y, z = sine * np.cos(phi) + view[0], sine * np.sin(phi), cosine + view[2]
    normal_half = z / np.sqrt(x * x + y * y + z * z)
    reflected = distribution(normal_half, roughness) * half_of_g(cosine, roughness)
    share = np.mean(reflected, axis=1) @ (0.5 * weights) * (2.0 * math.pi)
    return float(share * half_of_g(normal_view, roughness) / (4.0 * normal_view))


def later_bounces(lost: Value, lost_there: Value, mean: Value, f0: Value) -> Value:
    """The lobe of all bounces but the first, (1 − E(v)) (1 − E(l)) / (π (1 − m)), in colour.

    Args:
        lost, lost_there: 1 − E towards the viewer and the light.
        mean: m, E's mean over all directions, 2 ∫ E(μ) μ dμ.
        f0: the metal's colour; what its mirrors reflect on average is (20 f0 + 1) / 21.

    >>> print(f"{later_bounces(0.5, 0.5, 0.5, 1.0):.6f}")
    0.159155
    """
    mirrors = (20.0 * f0 + 1.0) / 21.0
    tint = mirrors * mirrors * mean / (1.0 - mirrors * (1.0 - mean))
    return tint * (lost * lost_there / (PI * (1.0 - mean)))
