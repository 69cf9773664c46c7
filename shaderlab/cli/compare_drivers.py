"""`shaderlab run --drivers`: how far the pixels of each scene lie apart on several drivers, and
which driver lies outside the reference's band."""

import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.text import Text

from shaderlab.cli.recorded_run import RecordedRun, RunPlan
from shaderlab.cli.showing import make_table
from shaderlab.model.frame import Array
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Agreement, Disagreement, DrawnOutput, DriverResult, Record, Run
from shaderlab.report.comparison import AGREEMENTS, compare_drivers
from shaderlab.report.text import clean, format_label

FRAMES = "drawn"
"""The folder in the run's own that holds what each driver drew, until that is compared."""


def plan_for_drivers(plan: RunPlan, drivers: Sequence[str]) -> RunPlan:
    """Return the plan with a job for each driver."""
    assert plan.options.folder is not None
    jobs = tuple(replace(job, driver=name) for name in drivers for job in plan.jobs)
    frames = plan.options.folder / FRAMES
    return replace(plan, jobs=jobs, options=replace(plan.options, frames=frames))


def add_comparison(recorded: RecordedRun, options: RunOptions) -> RecordedRun:
    """Return the run with its drivers compared by the frames that they stored."""
    frames = options.frames
    assert frames is not None
    apart = tuple(find_disagreements(recorded.records, frames))
    shutil.rmtree(frames, ignore_errors=True)
    drivers = tuple(summarise_results(recorded.records, apart))
    return replace(recorded, run=replace(recorded.run, drivers=drivers, disagreements=apart))


_ORDER: tuple[Agreement, ...] = ("equal", "within", "outside")
_MOST_REASONS = 3


def summarise_results(
    records: Sequence[Record], apart: Sequence[Disagreement]
) -> Iterator[DriverResult]:
    """What became of each scene on each driver; records of the first driver come first."""
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
            message=_format_reason(record),
            agrees=agreement.get(record.key, ""),
            not_asked=len(record.not_asked),
        )


def _format_reason(record: Record) -> str:
    """Why a record did not pass, in a few lines."""
    if record.status == "pass":
        return ""
    lines = record.message.splitlines()[:1]
    wrong = [outcome for outcome in record.expectations if outcome.status != "pass"]
    for outcome in wrong[:_MOST_REASONS]:
        said = outcome.message.splitlines()[:1]
        said = said or [f"{outcome.outside} of {outcome.judged} values outside"]
        if outcome.explanation is not None and outcome.explanation.verdict:
            said.append(outcome.explanation.verdict)
        lines.append(f"{outcome.name}: {'; '.join(said)}")
    if len(wrong) > _MOST_REASONS:
        lines.append(f"… and {len(wrong) - _MOST_REASONS} more")
    return "\n".join(lines)


def find_disagreements(records: Sequence[Record], frames: Path) -> Iterator[Disagreement]:
    """Each output of each scene, compared between every two drivers; `frames` has each driver's
    frames in a folder of its own. Arrays are read only where digests differ; without them nothing
    is said of an output."""
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
                    yield from _compare_outputs(first, second, output, other, frames, arrays)


def _compare_outputs(
    first: Record,
    second: Record,
    output: DrawnOutput,
    other: DrawnOutput,
    frames: Path,
    arrays: dict[str, Mapping[str, Array]],
) -> Iterator[Disagreement]:
    from shaderlab.engine.pictures import load_frames

    steps = None
    if output.digest != other.digest:
        for record in (first, second):
            name = record.driver_name
            if name not in arrays:
                arrays[name] = load_frames(frames / name, record.id, record.variant)
        one, two = (arrays[record.driver_name].get(output.name) for record in (first, second))
        if one is None or two is None or one.shape != two.shape:
            return
        steps = pixel_distances(one, two)
    differing = 0 if steps is None else int((steps > 0).sum())
    both = ((first, output), (second, other))
    outside = tuple(record.driver_name for record, drawn in both if differing and drawn.failed)
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
    if steps is not None and differing:
        row, column = np.unravel_index(int(steps.argmax()), steps.shape)
        found = replace(found, pixel=(int(column), int(row)))
    yield found


def pixel_distances(a: Array, b: Array) -> Array:
    """By how much the pixels of two images (height, width, components) differ at most, (height,
    width).

    The distance is in units in the last place for floats, in steps for integers; two NaN are the
    same, NaN and a number are infinitely far apart.
    """
    if a.dtype.kind != "f":
        steps = np.abs(a.astype(np.int64) - b.astype(np.int64)).astype(np.float64)
    else:
        kind = {2: np.int16, 4: np.int32, 8: np.int64}[a.dtype.itemsize]
        one, two = (_to_ordered_integers(each, kind) for each in (a, b))
        steps = np.abs(one - two).astype(np.float64)
        nan_a, nan_b = np.isnan(a), np.isnan(b)
        steps[nan_a & nan_b] = 0.0
        steps[nan_a ^ nan_b] = np.inf
    found: Array = steps.max(axis=-1)
    return found


def _to_ordered_integers(values: Array, kind: type) -> Array:
    """Floats as integers that count them in order: neighbours are 1 apart, both zeros are 0."""
    bits = np.ascontiguousarray(values).view(kind).astype(np.int64)
    return np.where(bits < 0, np.int64(np.iinfo(kind).min) - bits, bits)


_STYLES = {"✓": "green", "–": "yellow", "✗": "red"}
_MOST_LINES = 40


def show_drivers(run: Run, console: Console) -> None:
    """A table of cases and drivers, why a driver did not pass, and what lies outside of a band;
    nothing for a run on one driver."""
    table = compare_drivers(run, {})
    if table is None:
        return
    names = [name for name, _ in table.drivers]
    shown = make_table("case", "variants", *names, right={"variants"}, whole={"case", *names})
    for case_id, count, cells in table.by_case():
        texts = (Text(cell, _STYLES.get(cell[0], "")) for cell in cells)
        shown.add_row(Text(clean(case_id)), Text(str(count)), *texts)
    console.print()
    console.print(shown)
    console.print()
    total = table.outputs.total()
    for verdict, words in AGREEMENTS.items():
        console.print(f"{table.outputs[verdict]} of {total} outputs: {words}")
    for result, labels in _group_alike(run.drivers):
        style = "yellow" if result.status == "unsupported" else "red"
        head = f"{result.status} on {result.driver}: {', '.join(labels)}"
        console.print(clean("\n  ".join([head, *result.message.splitlines()])), style=style)
    outside = [each for each in table.differences if each.verdict == "outside"]
    for each in outside[:_MOST_LINES]:
        console.print(clean(_line(each)))
    if len(outside) > _MOST_LINES:
        console.print(f"… and {len(outside) - _MOST_LINES} more")


def _group_alike(results: Iterable[DriverResult]) -> Iterator[tuple[DriverResult, list[str]]]:
    """What did not pass: one result and the scenes of all that say the same."""
    found: dict[tuple[str, str, str], list[DriverResult]] = {}
    for result in results:
        if result.status != "pass":
            found.setdefault((result.driver, result.status, result.message), []).append(result)
    for alike in found.values():
        yield alike[0], [format_label(result.id, result.variant) for result in alike]


def _line(each: Disagreement) -> str:
    name = f"{format_label(each.id, each.variant)}: {each.output}"
    pair = " | ".join(each.drivers)
    return (
        f"{name}  {pair}: {each.differing} of {each.pixels} pixels differ, by {each.ulp:.4g} ULP "
        f"at most; outside on {', '.join(each.outside)}"
    )
