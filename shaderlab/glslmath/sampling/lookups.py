"""GLSL's other texture functions (GLSL 4.60, 8.9.2): with an offset, a projection, derivatives.

Offsets are in texels, (x, y), the same for all values. A projection divides by the last coordinate.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.errors import FormulaError

from . import reading
from .filters import WEIGHT
from .functions import Offset, sampled, texelFetch
from .reading import Sampler
from .spans import Span, component, components, span_of, widened

# How far log2(m) lies above m - 1 for m in 1…2, at most (where m = 1 / ln 2).
LINEAR_LOGARITHM = 0.0861


def textureOffset(sampler: Sampler, p: Any, offset: Offset, lod: Any = None) -> Any:
    """GLSL's `textureOffset`; `lod` as for `texture`."""
    return sampled(sampler, p, _level(lod), offset)


def textureLodOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `textureLodOffset`."""
    return sampled(sampler, p, _level(lod), offset)


def texelFetchOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `texelFetchOffset`: the texel at p + `offset`; undefined outside the texture."""
    low, high = span_of(p)
    if not np.array_equal(np.rint(low), np.rint(high)):
        raise FormulaError("texelFetchOffset(): a band holds several texels")
    step = np.zeros(low.shape[-1])
    step[:2] = offset
    return texelFetch(sampler, np.rint(low) + step, lod)


def textureProj(sampler: Sampler, p: Any, lod: Any = None) -> Any:
    """GLSL's `textureProj`: p's coordinates are divided by its last one."""
    return sampled(sampler, _projected(sampler, p), _level(lod))


def textureProjOffset(sampler: Sampler, p: Any, offset: Offset, lod: Any = None) -> Any:
    """GLSL's `textureProjOffset`."""
    return sampled(sampler, _projected(sampler, p), _level(lod), offset)


def textureProjLod(sampler: Sampler, p: Any, lod: Any) -> Any:
    """GLSL's `textureProjLod`."""
    return sampled(sampler, _projected(sampler, p), _level(lod))


def textureProjLodOffset(sampler: Sampler, p: Any, lod: Any, offset: Offset) -> Any:
    """GLSL's `textureProjLodOffset`."""
    return sampled(sampler, _projected(sampler, p), _level(lod), offset)


def textureGrad(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any) -> Any:
    """GLSL's `textureGrad`: the level follows from these derivatives of p, (…, 2)."""
    return sampled(sampler, p, level_of(sampler, dPdx, dPdy))


def textureGradOffset(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any, offset: Offset) -> Any:
    """GLSL's `textureGradOffset`."""
    return sampled(sampler, p, level_of(sampler, dPdx, dPdy), offset)


def textureProjGrad(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any) -> Any:
    """GLSL's `textureProjGrad`: the derivatives are those of the projected coordinates."""
    return sampled(sampler, _projected(sampler, p), level_of(sampler, dPdx, dPdy))


def textureProjGradOffset(sampler: Sampler, p: Any, dPdx: Any, dPdy: Any, offset: Offset) -> Any:
    """GLSL's `textureProjGradOffset`."""
    return sampled(sampler, _projected(sampler, p), level_of(sampler, dPdx, dPdy), offset)


def level_of(sampler: Sampler, dPdx: Any, dPdy: Any) -> Span:
    """The level of detail λ that derivatives of s and t give, before it is clamped.

    A device may take any scale between the larger of mᵤ and mᵥ and their sum, where mᵤ is the
    larger of |∂u/∂x| and |∂u/∂y| (OpenGL 4.5, §8.14, equations 8.7 to 8.10). It leaves open how
    precise the logarithm is; llvmpipe's is linear between powers of two.
    """
    if sampler.texels.kind == "Cube":
        raise FormulaError("derivatives on cubes are not known; give the level to textureLod()")
    height, width = reading.level_values(sampler, 0).shape[1:3]
    du_dx, du_dy, dv_dx, dv_dy = (
        _sizes(component(span_of(d), k)) for k in (0, 1) for d in (dPdx, dPdy)
    )
    with np.errstate(divide="ignore"):
        if sampler.rules is None:
            by_x = np.hypot(du_dx[0] * width, dv_dx[0] * height)
            by_y = np.hypot(du_dy[0] * width, dv_dy[0] * height)
            level = np.log2(np.maximum(by_x, by_y))
            return level, level
        m_u = [np.maximum(a, b) * width for a, b in zip(du_dx, du_dy, strict=True)]
        m_v = [np.maximum(a, b) * height for a, b in zip(dv_dx, dv_dy, strict=True)]
        least, most = np.log2(np.maximum(m_u[0], m_v[0])), np.log2(m_u[1] + m_v[1])
    return widened((least - LINEAR_LOGARITHM, most), WEIGHT)


def _sizes(span: Span) -> Span:
    """The absolute values of a span."""
    low, high = np.abs(span[0]), np.abs(span[1])
    crosses = (span[0] < 0.0) & (span[1] > 0.0)
    return np.where(crosses, 0.0, np.minimum(low, high)), np.maximum(low, high)


def _level(lod: Any) -> Span | None:
    return None if lod is None else component(span_of(lod), 0)


def _projected(sampler: Sampler, p: Any) -> Any:
    """(s, t)/q, or (s, t, r)/q of a shadow sampler; of four coordinates without a comparison the
    third is not used."""
    if sampler.texels.kind != "2D":
        raise FormulaError(f"GLSL projects onto no sampler{sampler.texels.kind}")
    shadow = sampler.texels.compare is not None
    given = components(span_of(p))
    if given not in ((4,) if shadow else (3, 4)):
        raise FormulaError(f"textureProj() takes 4 coordinates, or 3 without shadow, not {given}")
    p = p if isinstance(p, Band) else np.asarray(p, np.float64)
    return p[..., : 3 if shadow else 2] / p[..., given - 1 :]
