"""The record of a job whose process did not live to write one."""

from __future__ import annotations

from typing import cast

from shaderlab.discovery import chapter_title
from shaderlab.records import Record, Status
from shaderlab.running.jobs import Job


def lost(
    job: Job, status: str, message: str, *, step: str = "", driver: str = "", seconds: float = 0.0
) -> Record:
    """A record that says how far a job came.

    Args:
        job: what was to be run.
        status: "timeout", "crash" or "error".
        message: how it ended.
        step: the last thing it was about to do, in words.
        driver: the renderer it ran on.
        seconds: how long it took until then.
    """
    lines = [message]
    if step:
        lines.append(f"last step: {step}")
    if driver:
        lines.append(f"driver: {driver}")
    return Record(
        id=job.id,
        variant=job.variant,
        title=job.title,
        section=job.section,
        chapter=chapter_title(job.file, job.section),
        lesson="",
        formula="",
        file=job.file,
        status=cast(Status, status),
        message="\n".join(lines),
        seconds=seconds,
    )
