"""Judging laws: monotone, bounded, symmetric, energy-conserving, and the mean of many samples."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.checks.figures import ulp_distance
from shaderlab.checks.judgement import Judgement, plain, shown
from shaderlab.frame import Array, Samples
from shaderlab.model import Property
from shaderlab.model.laws import Bounded, EnergyConserving, Law, Mean, Monotone, Symmetric
from shaderlab.records import Outcome, Row, Worst

MAX_QUADRATURE_ERROR = 0.01
Flags = npt.NDArray[np.bool_]


def judge_property(expectation: Property, samples: Samples, name: str) -> Judgement:
    """Hold the runs of one property against its law.

    Args:
        expectation: the property.
        samples: the program run on the inputs of `expectation.steps`, in their order.
        name: the output that is judged.
    """
    law: Law = expectation.law
    measured = samples.outputs[name].astype(np.float64)
    finite = np.isfinite(measured)
    if not finite.all():
        i, c = (int(k) for k in np.argwhere(~finite)[0])
        count = int((~finite).sum())
        worst = _worst(expectation, samples, measured, (i, c), measured[i], -np.inf, np.inf)
        return _judged(expectation, law, measured, count, f"{count} values are not finite", worst)
    match law:
        case Monotone():
            return _monotone(expectation, law, samples, measured)
        case Bounded():
            return _bounded(expectation, law, samples, measured)
        case Symmetric():
            return _symmetric(expectation, law, samples, measured)
        case EnergyConserving():
            return _energy(expectation, law, samples, measured)
        case Mean():
            return _mean(expectation, law, samples, measured)


def _monotone(expectation: Property, law: Monotone, samples: Samples, measured: Array) -> Judgement:
    rises = law.sign * np.diff(measured, axis=0)
    wrong = rises <= 0.0 if law.strict else rises < 0.0
    i, c = _first_least(rises)
    before = measured[i]
    ends = (before, np.full_like(before, np.inf))
    low, high = ends if law.sign > 0 else (-ends[1], before)
    worst = _worst(expectation, samples, measured, (i + 1, c), before, low, high, wrong.any())
    outside = int(wrong.sum())
    verb = "falls" if law.sign > 0 else "rises"
    verb += " or stays" if law.strict else ""
    message = f"it {verb} in {outside} of {rises.size} steps" if outside else ""
    return _judged(expectation, law, measured, outside, message, worst)


def _bounded(expectation: Property, law: Bounded, samples: Samples, measured: Array) -> Judgement:
    low = np.broadcast_to(np.asarray(law.low, np.float64), measured.shape)
    high = np.broadcast_to(np.asarray(law.high, np.float64), measured.shape)
    wrong = (measured < low) | (measured > high)
    room = np.minimum(measured - low, high - measured)
    i, c = _first_least(room)
    nearest = np.clip(measured[i], low[i], high[i])
    worst = _worst(expectation, samples, measured, (i, c), nearest, low[i], high[i], wrong.any())
    outside = int(wrong.sum())
    message = f"{outside} of {measured.size} values are out of bounds" if outside else ""
    return _judged(expectation, law, measured, outside, message, worst)


def _symmetric(
    expectation: Property, law: Symmetric, samples: Samples, measured: Array
) -> Judgement:
    one, other = measured[0::2], law.sign * measured[1::2]
    step = np.spacing(np.maximum(np.abs(one), np.abs(other)).astype(np.float32)).astype(np.float64)
    off = np.abs(one - other) / step
    wrong = off > law.ulps
    i, c = _first_least(-off)
    room = law.ulps * step[i]
    worst = _worst(
        expectation, samples, law.sign * measured, (2 * i + 1, c), one[i], one[i] - room,
        one[i] + room, wrong.any(),
    )  # fmt: skip
    outside = int(wrong.sum())
    message = f"{outside} of {off.size} pairs differ by more than {law.ulps} ULP" if outside else ""
    return _judged(expectation, law, measured, outside, message, worst)


def _energy(
    expectation: Property, law: EnergyConserving, samples: Samples, measured: Array
) -> Judgement:
    weighted = np.asarray(law.weights)[:, None] * measured
    total = weighted[: law.fine].sum(axis=0)
    error = np.abs(total - weighted[law.fine :].sum(axis=0))
    above = total > law.limit + error
    rough = error > MAX_QUADRATURE_ERROR * law.limit
    c = int(np.argmax(total))
    row = Row(
        label="∫ over the hemisphere",
        expected=f"at most {shown(law.limit)}",
        measured=shown(total, 6),
        ok=not (above.any() or rough.any()),
        note=f"{law.fine} directions; quadrature known to {float(error.max()):.2g}",
    )
    message = ""
    if above.any():
        message = f"it reflects {total[c]:.6f} of the light, more than {shown(law.limit)}"
    elif rough.any():
        message = (
            f"the quadrature is known to {float(error.max()):.2g} only, which is too rough to "
            f"judge: give it more points (polar, around)"
        )
    brightest = int(np.argmax(weighted[: law.fine, c]))
    worst = _worst(
        expectation, samples, np.broadcast_to(total, measured.shape), (brightest, c), total,
        np.zeros_like(total), total * 0.0 + law.limit, bool(above.any()),
    )  # fmt: skip
    outside = int((above | rough).sum())
    return _judged(expectation, law, measured, outside, message, worst, (row,))


def _mean(expectation: Property, law: Mean, samples: Samples, measured: Array) -> Judgement:
    count = len(measured)
    expected = np.broadcast_to(np.asarray(law.equals, np.float64), measured.shape[1:])
    mean = measured.mean(axis=0)
    error = measured.std(axis=0, ddof=1) / math.sqrt(count)
    difference = mean - expected
    with np.errstate(all="ignore"):
        z = np.where(difference == 0.0, 0.0, difference / error)
    chance = np.array([math.erfc(abs(value) / math.sqrt(2.0)) for value in z])
    wrong = chance < law.significance
    rows = tuple(
        Row(
            label="mean" if measured.shape[1] == 1 else f"mean of {'xyzw'[k]}",
            expected=shown(expected[k]),
            measured=f"{mean[k]:.6g} ± {error[k]:.2g} (n = {count})",
            ok=not wrong[k],
            note=f"z = {z[k]:.2f}, p = {chance[k]:.2g}, α = {law.significance:g}",
        )
        for k in range(measured.shape[1])
    )
    c = int(np.argmin(chance))
    furthest = int(np.argmax(np.abs(measured[:, c] - expected[c])))
    worst = _worst(
        expectation, samples, np.broadcast_to(mean, measured.shape), (furthest, c), expected,
        expected - error, expected + error, bool(wrong.any()), float(np.abs(z[c])),
    )  # fmt: skip
    message = (
        f"a mean of {mean[c]:.6g} or further off has a chance of {chance[c]:.2g} "
        f"among {count} samples"
        if wrong.any()
        else ""
    )
    return _judged(expectation, law, measured, int(wrong.sum()), message, worst, rows)


def _first_least(values: Array) -> tuple[int, int]:
    index, component = np.unravel_index(int(np.argmin(values)), values.shape)
    return int(index), int(component)


def _worst(
    expectation: Property,
    samples: Samples,
    measured: Array,
    place: tuple[int, int],
    reference: Array,
    low: Any,
    high: Any,
    failed: Any = True,
    widths: float | None = None,
) -> Worst:
    """The run that is nearest to breaking the law, or breaks it most, with its inputs."""
    i, c = place
    names = dict.fromkeys((*expectation.steps[i], *expectation.at))
    shape = measured[i].shape
    return Worst(
        pixel=None,
        component=c,
        measured=plain(measured[i]),
        reference=plain(np.broadcast_to(reference, shape)),
        low=plain(np.broadcast_to(low, shape)),
        high=plain(np.broadcast_to(high, shape)),
        ulp=ulp_distance(measured[i, c], float(np.broadcast_to(reference, shape)[c])),
        widths=(math.inf if failed else 0.0) if widths is None else widths,
        inputs={
            name: plain(samples.inputs[name][i])
            for name in names
            if name in samples.inputs and samples.inputs[name][i].ndim == 1
        },
    )


def _judged(
    expectation: Property,
    law: Law,
    measured: Array,
    outside: int,
    message: str,
    worst: Worst,
    rows: tuple[Row, ...] = (),
) -> Judgement:
    kinds = {Monotone: "monotone", Bounded: "bounded", Symmetric: "symmetric",
             EnergyConserving: "energy", Mean: "mean"}  # fmt: skip
    return Judgement(
        outcome=Outcome(
            name=expectation.name,
            kind=kinds[type(law)],
            status="fail" if message else "pass",
            message=message,
            judged=int(measured.size),
            outside=outside,
            worst=worst,
            rows=rows,
        )
    )
