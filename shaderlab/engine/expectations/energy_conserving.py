"""energy_conserving: the light that leaves a surface is no more than what falls on it."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Array, Samples
from shaderlab.model.records import Row

from ..judging.banded import format_value
from .laws import OutputLaw

MAX_QUADRATURE_ERROR = 0.01


@dataclass(frozen=True)
class EnergyConserving(OutputLaw):
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
    """

    kind = "energy"

    output: str
    _: KW_ONLY
    over: str
    normal: Sequence[float] = (0.0, 0.0, 1.0)
    limit: float = 1.0
    cosine: bool = True
    polar: int = 32
    around: int = 64

    @property
    def default_name(self) -> str:
        return f"{self.output} conserves energy"

    def __post_init__(self) -> None:
        if min(self.polar, self.around) < 4 or self.polar % 2 or self.around % 2:
            raise CaseError("energy_conserving: polar and around must be even, 4 or more")
        if np.shape(self.normal) != (3,) or not np.any(self.normal):
            raise CaseError(f"energy_conserving: {self.normal} is not a normal")
        if not 0.0 < self.limit < np.inf:
            raise CaseError(f"energy_conserving: a limit of {self.limit} limits nothing")

    @property
    def steps(self) -> Sequence[Mapping[str, Any]]:
        """The directions of the quadrature, then those of the coarser one."""
        return [{self.over: direction} for direction in self._quadratures[0].tolist()]

    @functools.cached_property
    def _quadratures(self) -> tuple[Array, Array]:
        """Directions (count, 3) and weights (count,) of both quadratures, the finer one first."""
        fine = _hemisphere(self.normal, self.polar, self.around, self.cosine)
        coarse = _hemisphere(self.normal, self.polar // 2, self.around // 2, self.cosine)
        directions, weights = (np.concatenate(both) for both in zip(fine, coarse, strict=True))
        return directions, weights

    def judge_runs(self, measured: Array, samples: Samples) -> Judgement:
        weighted = self._quadratures[1][:, None] * measured
        fine = self.polar * self.around
        total = weighted[:fine].sum(axis=0)
        error = np.abs(total - weighted[fine:].sum(axis=0))
        above = total > self.limit + error
        rough = error > MAX_QUADRATURE_ERROR * self.limit
        known_to = f"{float(error.max()):.2g}"
        message = ""
        if above.any():
            message = (
                f"it reflects {total.max():.6f} of the light, more than {format_value(self.limit)}"
            )
        elif rough.any():
            message = (
                f"the error of the quadrature, {known_to}, is too large to judge: "
                "give it more points (polar, around)"
            )
        elif not total.any():
            message = "it reflects nothing at all: any limit would hold"
        row = Row(
            label="∫ over the hemisphere",
            expected=f"at most {format_value(self.limit)}",
            measured=format_value(total, 6),
            ok=not (above.any() or rough.any()),
            note=f"{fine} directions; quadrature known to {known_to}",
        )
        return self.judge_rows([row], message, judged=measured.size)


def _hemisphere(
    normal: Sequence[float], polar: int, around: int, cosine: bool
) -> tuple[Array, Array]:
    """Unit vectors (count, 3) and their solid angles (count,), times cos θ if `cosine`."""
    z = np.asarray(normal, float)
    z = z / np.linalg.norm(z)
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
    return np.asarray(directions), solid * cos_theta if cosine else solid


energy_conserving = EnergyConserving
