"""One scene on several drivers: how far their pixels lie apart, and each from the reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.model.records import Agreement, Disagreement, DrawnOutput, DriverResult, Record

from .difference_pictures import shades

if TYPE_CHECKING:
    from shaderlab.model.frame import Array

_ORDER: tuple[Agreement, ...] = ("equal", "within", "outside")
_MOST = 3


def results(records: Sequence[Record], apart: Sequence[Disagreement]) -> Iterator[DriverResult]:
    """What became of each scene on each driver.

    Args:
        records: of all drivers, those of the first one first.
        apart: how they compare.
    """
    renderers: dict[str, str] = {}
    for record in records:
        if record.driver:
            renderers.setdefault(record.driver_name, record.driver.partition(";")[0])
    first = records[0].driver_name if records else ""
    agreement: dict[tuple[str, str, str], Agreement] = {}
    for each in apart:
        if each.drivers[0] == first:
            key = (each.id, each.variant, each.drivers[1])
            agreement[key] = max(agreement.get(key, "equal"), each.verdict, key=_ORDER.index)
    for record in records:
        worst = [o.worst for o in record.expectations if o.worst is not None]
        yield DriverResult(
            driver=record.driver_name,
            renderer=renderers.get(record.driver_name, ""),
            id=record.id,
            variant=record.variant,
            status=record.status,
            ulp=max((w.ulp for w in worst), default=0.0),
            widths=max((w.widths for w in worst), default=0.0),
            message=_reason(record),
            agrees=agreement.get(record.key, ""),
            not_asked=len(record.not_asked),
        )


def _reason(record: Record) -> str:
    """Why a record did not pass, in a few lines."""
    if record.status == "pass":
        return ""
    lines = record.message.splitlines()[:1]
    wrong = [outcome for outcome in record.expectations if outcome.status != "pass"]
    for outcome in wrong[:_MOST]:
        said = outcome.message.splitlines()[:1]
        said = said or [f"{outcome.outside} of {outcome.judged} values outside"]
        if outcome.explanation is not None and outcome.explanation.verdict:
            said.append(outcome.explanation.verdict)
        lines.append(f"{outcome.name}: {'; '.join(said)}")
    if len(wrong) > _MOST:
        lines.append(f"… and {len(wrong) - _MOST} more")
    return "\n".join(lines)


@dataclass(frozen=True)
class Difference:
    """A disagreement, and its picture's shades; None where the outputs are equal."""

    found: Disagreement
    shades: Array | None = None


def disagreements(records: Sequence[Record], frames: Path) -> Iterator[Difference]:
    """Each output of each scene, compared between every two drivers.

    Arrays are read only where digests differ; without them nothing is said of an output.

    Args:
        records: of all drivers.
        frames: the folder in which each driver's frames were stored in a folder of its own.
    """
    scenes: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        scenes.setdefault((record.id, record.variant), []).append(record)
    for scene in scenes.values():
        arrays: dict[str, Mapping[str, Array]] = {}
        for first, second in combinations(scene, 2):
            others = {output.name: output for output in second.drawn}
            for output in first.drawn:
                other = others.get(output.name)
                if other is not None and other.size == output.size:
                    yield from _compared(first, second, output, other, frames, arrays)


def _compared(
    first: Record,
    second: Record,
    output: DrawnOutput,
    other: DrawnOutput,
    frames: Path,
    arrays: dict[str, Mapping[str, Array]],
) -> Iterator[Difference]:
    from shaderlab.engine.pictures import load_frames

    steps = None
    if output.digest != other.digest:
        for record in (first, second):
            name = record.driver_name
            if name not in arrays:
                arrays[name] = load_frames(frames / name, record.id, record.variant)
        values = [arrays[record.driver_name].get(output.name) for record in (first, second)]
        one, two = values
        if one is None or two is None or one.shape != two.shape:
            return
        steps = apart(one, two)
    differing = 0 if steps is None else int((steps > 0).sum())
    outside = tuple(
        record.driver_name
        for record, drawn in ((first, output), (second, other))
        if differing and drawn.failed
    )
    found = Disagreement(
        id=first.id,
        variant=first.variant,
        output=output.name,
        drivers=(first.driver_name, second.driver_name),
        pixels=output.size[0] * output.size[1],
        differing=differing,
        ulp=0.0 if steps is None else float(steps.max(initial=0.0)),
        verdict="outside" if outside else "within" if differing else "equal",
        outside=outside,
    )
    if steps is None or not differing:
        yield Difference(found)
        return
    row, column = np.unravel_index(int(steps.argmax()), steps.shape)
    yield Difference(replace(found, pixel=(int(column), int(row))), shades(steps))


def apart(a: Array, b: Array) -> Array:
    """By how much the pixels of two images (height, width, components) differ at most, (height,
    width).

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
    found: Array = steps.max(axis=-1)
    return found


def _ordered(values: Array, kind: type) -> Array:
    """Floats as integers that count them in order: neighbours are 1 apart, both zeros are 0."""
    bits = np.ascontiguousarray(values).view(kind).astype(np.int64)
    return np.where(bits < 0, np.int64(np.iinfo(kind).min) - bits, bits)
