"""A plan on several drivers, `shaderlab run --drivers`, and what comparing them gives."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace

from shaderlab.cli.recorded_run import RecordedRun
from shaderlab.workers.journal import RunPlan

FRAMES = "drawn"
"""The folder in the run's own that holds what each driver drew, until that is compared."""


def on_each(plan: RunPlan, drivers: Sequence[str]) -> RunPlan:
    """The plan with a job for each driver; unchanged if none is named."""
    if not drivers:
        return plan
    assert plan.options.folder is not None
    jobs = tuple(replace(job, driver=name) for name in drivers for job in plan.jobs)
    frames = plan.options.folder / FRAMES
    return replace(plan, jobs=jobs, options=replace(plan.options, frames=frames))


def compared_drivers(recorded: RecordedRun, plan: RunPlan) -> RecordedRun:
    """The run with its drivers compared; unchanged where it has one, or was interrupted."""
    frames = plan.options.frames
    if frames is None or not recorded.complete:
        return recorded
    from shaderlab.workers.difference_pictures import write_picture
    from shaderlab.workers.drivers import disagreements, results

    apart = []
    for difference in disagreements(recorded.records, frames):
        found = difference.found
        if plan.options.pictures and difference.shades is not None:
            found = replace(found, image=write_picture(recorded.folder, found, difference.shades))
        apart.append(found)
    shutil.rmtree(frames, ignore_errors=True)
    drivers = tuple(results(recorded.records, apart))
    return replace(recorded, run=replace(recorded.run, drivers=drivers, disagreements=tuple(apart)))
