"""The worker's side: one open lab, case files loaded once each, and an answer for each question.

This module is what a worker imports before it says that it is ready, so that the time limit of
its first job is not spent on imports.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.catalogue import load_case
from shaderlab.errors import CaseError
from shaderlab.evaluation import Lab
from shaderlab.model import Ramp, Scene
from shaderlab.options import RunOptions
from shaderlab.records import Record
from shaderlab.running.jobs import About, CaseFacts, Describe, Job, Load, Perform, Question, Setup
from shaderlab.running.steps import Steps


def answer(questions: Sequence[Question]) -> Iterator[About | CaseFacts | Record]:
    """An answer to each question, in order."""
    for question in questions:
        if isinstance(question, Describe):
            lab = _station().open(question.driver)
            yield About(driver=dict(lab.driver))
        elif isinstance(question, Load):
            yield facts(question.file)
        else:
            yield _station().perform(question)


def facts(file: Path) -> CaseFacts:
    """What is in a case file. Raises CaseError."""
    scenes = list(scenes_of(str(file)).values())
    case = scenes[0].case
    inputs = {name: value for scene in scenes for name, value in scene.inputs.items()}
    return CaseFacts(
        file=case.file,
        id=case.id,
        title=case.title,
        section=case.section,
        variants=tuple(scene.variant for scene in scenes),
        formulas=tuple(len(scene.formulas()) for scene in scenes),
        parameters={name: _components(value) for name, value in inputs.items()},
        sized=any(p.target.size is None for scene in scenes for p in scene.passes),
    )


def perform(lab: Lab, setup: Setup, job: Job) -> Record:
    """Run one job in a lab. Raises CaseError where the case file is wrong."""
    size = setup.size if job.point is None else job.point.size or setup.size
    options = options_of(replace(setup, size=size))
    if options != lab.options:
        lab.configure(options)
    return lab.run(_scene_of(job))


def options_of(setup: Setup) -> RunOptions:
    """The lab's options for a run."""
    return RunOptions(
        size=setup.size,
        folder=setup.folder,
        pictures=setup.pictures,
        shaders=dict(setup.shaders),
        driver=setup.driver,
        frames=setup.frames,
    )


def _scene_of(job: Job) -> Scene:
    scenes = scenes_of(job.file)
    if job.point is None:
        return scenes[job.variant]
    scene = scenes[job.point.variant]
    try:
        scene = scene.changed(job.variant, job.point.changes)
    except CaseError as error:
        raise CaseError(error.message, file=job.file, remedy=error.remedy) from error
    return replace(scene, expect=scene.formulas())


def _components(value: Any) -> int:
    value = value.origin if isinstance(value, Ramp) else value
    return int(np.size(value))


class _Station:
    """An open lab that writes down what it does."""

    def __init__(self) -> None:
        self._lab: Lab | None = None
        self._steps: Steps | None = None
        self._place: tuple[Path, int] | None = None

    def open(self, driver: str | None) -> Lab:
        if self._lab is None:
            self._lab = Lab(RunOptions(driver=driver), self._note)
        return self._lab

    def perform(self, question: Perform) -> Record:
        lab = self.open(question.setup.driver)
        if lab.exhausted:
            # What ran out of memory may have left the driver half way. A new process costs less
            # than a doubt about every later record; the parent starts it and asks again.
            os._exit(1)
        if self._place is None or self._place[0] != question.steps:
            self._steps = Steps(question.steps)
        self._place = (question.steps, question.slot)
        self._note("loading the case file")
        return perform(lab, question.setup, question.job)

    def _note(self, step: str) -> None:
        if self._steps is not None and self._place is not None:
            self._steps.write(self._place[1], step)


@lru_cache(maxsize=1)
def _station() -> _Station:
    return _Station()


@cache
def scenes_of(file: str) -> Mapping[str, Scene]:
    """The scenes of a case file by variant, loaded once. Raises CaseError."""
    return {scene.variant: scene for scene in load_case(Path(file)).scenes()}
