"""What a lesson lets one try: each change of a shader shows in the lesson's picture."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from shaderlab.engine.pictures import with_read_passes
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderError
from shaderlab.model.case import Case, Scene
from shaderlab.model.options import RunOptions
from shaderlab.model.scene import Pass
from tests.catalogue import shipped
from tests.negative.broken import mistaken

_TRY = re.compile(r"Try: in `([^`]+)` write `([^`]+)` for `([^`]+)`: ")
CHAPTERS = sorted({Path(case.file).parent.name for case in shipped().values()})


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(modules=False)) as opened:
        yield opened


def smaller(one: Pass) -> Pass:
    """The pass with a large target a third as wide and as high, which takes less time."""
    size = one.target.size
    if size is None or min(size) < 256:
        return one
    return replace(one, target=replace(one.target, size=(size[0] // 3, size[1] // 3)))


def picture(lab: SceneRunner, scene: Scene, texts: Mapping[str, str]) -> npt.NDArray[Any]:
    """What people see of a scene, with the text of a shader changed."""
    last = scene.passes[-1]
    name = scene.picture.pass_name if scene.picture else last.name
    needed = with_read_passes(scene, {name})
    passes = tuple(smaller(p) for p in scene.passes if p.name in needed)
    part = replace(scene, passes=passes, expect=())
    programs = lab.prepare_for_opengl(part, texts)
    with lab.evaluation(part, programs) as evaluation:
        images = {out: image for (of, out), image in evaluation.drawn.images.items() if of == name}
    shown = images[scene.picture.name] if scene.picture else next(iter(images.values()))
    values = np.nan_to_num(np.asarray(shown.values)[..., :3])
    return np.clip(values / (255.0 if values.dtype == np.uint8 else 1.0), 0.0, 1.0)


def shows(lab: SceneRunner, case: Case, edit: Mapping[str, str]) -> bool:
    """Whether a variant's picture changes in a thousandth of its pixels, and is not of one colour;
    a change that the driver refuses to link shows as well."""
    for scene in case.scenes():
        try:
            before, after = picture(lab, scene, {}), picture(lab, scene, edit)
        except ShaderError:
            return True
        changed = np.abs(after - before).max(axis=-1) > 0.5 / 255.0
        if changed.mean() > 0.001 and np.ptp(after, axis=(0, 1)).max() > 0.1:
            return True
    return False


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_what_one_may_try_changes_the_picture(lab: SceneRunner, chapter: str) -> None:
    without = []
    for case in shipped().values():
        found = _TRY.search(" ".join(case.lesson.split()))
        if found and Path(case.file).parent.name == chapter:
            file, new, old = found.groups()
            if not shows(lab, case, mistaken(file, old, new)):
                without.append(case.id)
    assert without == []
