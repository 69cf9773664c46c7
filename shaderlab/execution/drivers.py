"""One scene on several drivers: how far their pixels lie apart, and each from the reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.execution.jobs import Job
from shaderlab.records import Disagreement, DriverResult, Record

if TYPE_CHECKING:
    from shaderlab.frame import Array


def results(driver: str, renderer: str, records: Sequence[Record]) -> Iterator[DriverResult]:
    """What became of each scene on one driver."""
    for record in records:
        worst = [o.worst for o in record.expectations if o.worst is not None]
        yield DriverResult(
            driver=driver,
            renderer=renderer,
            id=record.id,
            variant=record.variant,
            status=record.status,
            ulp=max((w.ulp for w in worst), default=0.0),
            widths=max((w.widths for w in worst), default=0.0),
        )


def disagreements(jobs: Sequence[Job], frames: Mapping[str, Path]) -> Iterator[Disagreement]:
    """Each output of each scene, compared between every two drivers.

    Args:
        jobs: the scenes.
        frames: by driver, the folder in which its frames were kept.
    """
    from shaderlab.evaluation.stored_images import load

    for job in jobs:
        drawn = {name: load(folder, job.id, job.variant) for name, folder in frames.items()}
        for first, second in combinations(frames, 2):
            for output, values in drawn[first].items():
                other = drawn[second].get(output)
                if other is None or other.shape != values.shape:
                    continue
                differing, distance = apart(values, other)
                yield Disagreement(
                    id=job.id,
                    variant=job.variant,
                    output=output,
                    drivers=(first, second),
                    pixels=values.shape[0] * values.shape[1],
                    differing=differing,
                    ulp=distance,
                )


def apart(a: Array, b: Array) -> tuple[int, float]:
    """How many pixels of two images (height, width, components) differ, and by how much at most.

    The distance is in units in the last place for floats, in steps for integers; two NaN are the
    same, NaN and a number are infinitely far apart.
    """
    if a.dtype.kind != "f":
        steps = np.abs(a.astype(np.int64) - b.astype(np.int64)).astype(np.float64)
    else:
        kind = {2: np.int16, 4: np.int32, 8: np.int64}[a.dtype.itemsize]
        steps = np.abs(_ordered(a, kind) - _ordered(b, kind)).astype(np.float64)
        nan_a, nan_b = np.isnan(a), np.isnan(b)
        steps[nan_a & nan_b] = 0.0
        steps[nan_a ^ nan_b] = np.inf
    return int((steps > 0).any(axis=-1).sum()), float(steps.max(initial=0.0))


def _ordered(values: Array, kind: type) -> Array:
    """Floats as integers that count them in order: neighbours are 1 apart, both zeros are 0."""
    bits = np.ascontiguousarray(values).view(kind).astype(np.int64)
    return np.where(bits < 0, np.int64(np.iinfo(kind).min) - bits, bits)
