"""A plan on several drivers, `shaderlab run --drivers`, and what comparing them gives."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from shaderlab.cli.recorded_run import RecordedRun
from shaderlab.model.observations import Look, Pixel
from shaderlab.workers.journal import RunPlan

if TYPE_CHECKING:
    from shaderlab.cli.showing import Show
    from shaderlab.model.observations import Observation
    from shaderlab.model.records import Disagreement
    from shaderlab.workers import Executor, Job
    from shaderlab.workers.drivers import Difference

FRAMES = "drawn"
"""The folder in the run's own that holds what each driver drew, until that is compared."""

Observed = Mapping[tuple[str, str, str], Mapping[str, "Observation"]]
"""What was seen, by a job's key and by output."""


def on_each(plan: RunPlan, drivers: Sequence[str]) -> RunPlan:
    """The plan with a job for each driver; unchanged if none is named."""
    if not drivers:
        return plan
    assert plan.options.folder is not None
    jobs = tuple(replace(job, driver=name) for name in drivers for job in plan.jobs)
    frames = plan.options.folder / FRAMES
    return replace(plan, jobs=jobs, options=replace(plan.options, frames=frames))


def compared_drivers(
    recorded: RecordedRun, plan: RunPlan, executor: Executor, show: Show
) -> RecordedRun:
    """The run with its drivers compared; unchanged where it has one, or was interrupted.

    Where outputs differ, each driver draws the scene once more, and is looked at there.
    """
    frames = plan.options.frames
    if frames is None or not recorded.complete:
        return recorded
    from shaderlab.workers.difference_pictures import write_picture
    from shaderlab.workers.drivers import disagreements, results

    differences = list(disagreements(recorded.records, frames))
    observed = _observed(differences, plan, executor, show)
    apart = []
    for difference in differences:
        found = _attributed(difference.found, observed)
        if plan.options.pictures and difference.shades is not None:
            found = replace(found, image=write_picture(recorded.folder, found, difference.shades))
        apart.append(found)
    shutil.rmtree(frames, ignore_errors=True)
    drivers = tuple(results(recorded.records, apart))
    return replace(recorded, run=replace(recorded.run, drivers=drivers, disagreements=tuple(apart)))


def _observed(
    differences: Sequence[Difference], plan: RunPlan, executor: Executor, show: Show
) -> Observed:
    """What each driver does at some pixels that differ."""
    pixels: dict[tuple[str, str], dict[str, dict[Pixel, None]]] = {}
    drivers: dict[tuple[str, str], set[str]] = {}
    for each in differences:
        if each.pixels:
            scene = each.found.id, each.found.variant
            chosen = pixels.setdefault(scene, {}).setdefault(each.found.output, {})
            chosen.update(dict.fromkeys(each.pixels))
            drivers.setdefault(scene, set()).update(each.found.drivers)
    jobs: list[Job] = []
    for job in plan.jobs:
        scene = job.id, job.variant
        if job.driver in drivers.get(scene, ()):
            looks = tuple(Look(output=n, pixels=tuple(p)) for n, p in pixels[scene].items())
            jobs.append(replace(job, looks=looks))
    options = replace(plan.options, frames=None, pictures=False)
    found: dict[tuple[str, str, str], Mapping[str, Observation]] = {}
    with show.progress(len(jobs)) as progress:
        for job, record in executor.run(jobs, options):
            found[job.key] = {seen.output: seen for seen in record.observed}
            if record.message:
                show.console.print(f"{job.id} on {job.driver}: not looked at: {record.message}")
            progress.advance()
    return found


def _attributed(found: Disagreement, observed: Observed) -> Disagreement:
    from shaderlab.workers.attribution import attributed

    if found.verdict == "equal":
        return found
    one, two = (
        observed.get((found.id, found.variant, driver), {}).get(found.output)
        for driver in found.drivers
    )
    return attributed(found, one, two)
