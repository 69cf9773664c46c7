"""Laws that an output keeps while its inputs vary: no reference, only a property.

Each runs the program on inputs that it gives itself, as a `sweep` does; inputs that it does not
vary stay as the case has them, or as `at` says. Inputs of the stage are gathered into one draw; a
uniform costs a draw for each of its values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.expect import Figure, Property
from shaderlab.model.scene import UniformValue
from shaderlab.model.state import one_of

Given = Mapping[str, UniformValue] | None


@dataclass(frozen=True, kw_only=True)
class Monotone:
    """From one value to the next the output never falls (`sign` 1) or rises (−1)."""

    sign: int
    strict: bool


@dataclass(frozen=True, kw_only=True)
class Bounded:
    """low ≤ output ≤ high."""

    low: Figure
    high: Figure


@dataclass(frozen=True, kw_only=True)
class Symmetric:
    """Of each two runs, the second gives `sign` times the first, within `ulps`."""

    sign: int
    ulps: int


@dataclass(frozen=True, kw_only=True)
class EnergyConserving:
    """Σ weight · output ≤ limit; the first `fine` runs are one quadrature, the others a coarser
    one that tells how far it can be trusted."""

    weights: tuple[float, ...]
    fine: int
    limit: float


@dataclass(frozen=True, kw_only=True)
class Mean:
    """The mean does not differ from `equals` at this significance (two-sided z-test)."""

    equals: Figure
    significance: float


Law = Monotone | Bounded | Symmetric | EnergyConserving | Mean


def monotone(
    output: str,
    *,
    over: str,
    values: Sequence[float],
    direction: str = "increasing",
    strict: bool = False,
    at: Given = None,
    draw: int = -1,
    name: str = "",
) -> Property:
    """`output` never falls ("increasing") or never rises ("decreasing") while the input `over`
    goes through `values`; with `strict`, it never stays the same either. Of vectors, each
    component.

    Raises:
        CaseError: fewer than two values, or values that do not rise.
    """
    one_of("monotone", "direction", direction, ("increasing", "decreasing"))
    numbers = [float(v) for v in values]
    if len(numbers) < 2 or any(a >= b for a, b in pairwise(numbers)):
        raise CaseError(f"monotone {output!r}: values must be two or more that rise")
    law = Monotone(sign=1 if direction == "increasing" else -1, strict=strict)
    steps = [{over: v} for v in numbers]
    return _property(output, law, over, steps, at, draw, name or f"{output} {direction}")


def bounded(
    output: str,
    low: Figure,
    high: Figure,
    *,
    over: str,
    values: Sequence[UniformValue],
    at: Given = None,
    draw: int = -1,
    name: str = "",
) -> Property:
    """low ≤ `output` ≤ high while the input `over` takes each of `values`. The bounds are numbers,
    or one for each component.

    Raises:
        CaseError: a lower bound above its upper one.
    """
    if not np.all(np.asarray(low, float) <= np.asarray(high, float)):
        raise CaseError(f"bounded {output!r}: {low} … {high} holds no number")
    steps = [{over: v} for v in values]
    law = Bounded(low=low, high=high)
    return _property(output, law, over, steps, at, draw, name or f"{output} bounded")


def symmetric(
    output: str,
    *,
    over: str | tuple[str, str],
    values: Sequence[Any],
    odd: bool = False,
    ulps: int = 0,
    at: Given = None,
    draw: int = -1,
    name: str = "",
) -> Property:
    """f(x) = f(−x) for each of `values` of one input; or, `over` two inputs, f(a, b) = f(b, a) for
    each pair (a, b).

    Args:
        output: what is judged.
        over: an input's name, or two.
        values: numbers or vectors, or pairs of them.
        odd: f(x) = −f(−x), or f(a, b) = −f(b, a), instead.
        ulps: how many float32 steps the two may differ by; none says, the same numbers.
        at: other inputs.
        draw: which draw's program.
        name: how outcomes call it.
    """
    steps: list[dict[str, Any]] = []
    for value in values:
        if isinstance(over, str):
            steps += [{over: value}, {over: np.negative(value).tolist()}]
        else:
            one, other = value
            steps += [dict(zip(over, pair, strict=True)) for pair in ((one, other), (other, one))]
    if not steps or ulps < 0:
        raise CaseError(f"symmetric {output!r}: needs values, and ulps of 0 or more")
    law = Symmetric(sign=-1 if odd else 1, ulps=ulps)
    label = over if isinstance(over, str) else " and ".join(over)
    return _property(output, law, label, steps, at, draw, name or f"{output} symmetric in {label}")


def energy_conserving(
    output: str,
    *,
    over: str,
    normal: Sequence[float] = (0.0, 0.0, 1.0),
    limit: float = 1.0,
    cosine: bool = True,
    polar: int = 32,
    around: int = 64,
    at: Given = None,
    draw: int = -1,
    name: str = "",
) -> Property:
    """∫ output · cos θ dω ≤ limit over the hemisphere of directions around `normal`.

    The quadrature is Gauss–Legendre in cos θ (`polar` points) by the trapezoidal rule in the
    azimuth (`around` points); one of half as many points each way estimates its error, which is
    allowed for and must stay below one hundredth of the limit.

    Args:
        output: a BRDF's value for light from direction `over`, each component by itself.
        over: the input that takes unit vectors, (3,).
        normal: the surface normal, of any length but 0.
        limit: 1 for energy.
        cosine: whether cos θ is still to be multiplied in.
        polar, around: numbers of points, even.
        at: other inputs, such as the direction of view and the roughness.
        draw: which draw's program.
        name: how outcomes call it.
    """
    if polar < 4 or around < 4 or polar % 2 or around % 2:
        raise CaseError("energy_conserving: polar and around must be even, 4 or more")
    fine, weights = _hemisphere(normal, polar, around, cosine)
    coarse, coarse_weights = _hemisphere(normal, polar // 2, around // 2, cosine)
    steps = [{over: direction.tolist()} for direction in (*fine, *coarse)]
    law = EnergyConserving(weights=(*weights, *coarse_weights), fine=len(fine), limit=limit)
    return _property(output, law, over, steps, at, draw, name or f"{output} conserves energy")


def mean_of(
    output: str,
    equals: Figure,
    *,
    over: str,
    values: Sequence[UniformValue],
    significance: float = 1e-3,
    at: Given = None,
    draw: int = -1,
    name: str = "",
) -> Property:
    """The mean of `output` over many samples is `equals`: a two-sided z-test, for each component.

    A shader whose true mean is `equals` fails at `significance` in 1/significance choices of
    samples; the samples are given, so the same shader always gets the same verdict.

    Args:
        output: what is judged.
        equals: the expected mean, a number or one for each component.
        over: the input that the samples are taken over (a seed, a coordinate).
        values: one for each sample, at least 30 for the normal distribution to be a fair guess.
        significance: the test's level α, in 0…1.
        at: other inputs.
        draw: which draw's program.
        name: how outcomes call it.
    """
    steps = [{over: v} for v in values]
    if len(steps) < 30 or not 0.0 < significance < 1.0:
        raise CaseError("mean_of: needs 30 samples or more, and a significance between 0 and 1")
    law = Mean(equals=equals, significance=significance)
    return _property(output, law, over, steps, at, draw, name or f"mean of {output}")


def _property(
    output: str,
    law: Law,
    over: str,
    steps: Sequence[Mapping[str, UniformValue]],
    at: Given,
    draw: int,
    name: str,
) -> Property:
    if not steps:
        raise CaseError(f"{name}: needs values of {over!r}")
    return Property(
        output=output, law=law, over=over, steps=tuple(steps), at=at or {}, draw=draw, name=name
    )


def _hemisphere(normal: Sequence[float], polar: int, around: int, cosine: bool) -> tuple[Any, Any]:
    """Unit vectors (count, 3) and their solid angles (count,), times cos θ if asked for."""
    z = np.asarray(normal, float)
    length = float(np.linalg.norm(z))
    if z.shape != (3,) or length == 0.0:
        raise CaseError(f"energy_conserving: {normal} is no normal")
    z = z / length
    x = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    nodes, weights = np.polynomial.legendre.leggauss(polar)
    cos_theta = np.repeat(0.5 * (nodes + 1.0), around)
    sin_theta = np.sqrt(1.0 - cos_theta**2)
    phi = np.tile((np.arange(around) + 0.5) * (2.0 * np.pi / around), polar)
    parts = (sin_theta * np.cos(phi), sin_theta * np.sin(phi), cos_theta)
    directions = sum(part[:, None] * axis for part, axis in zip(parts, (x, y, z), strict=True))
    solid = np.repeat(0.5 * weights, around) * (2.0 * np.pi / around)
    return directions, (solid * cos_theta if cosine else solid).tolist()
