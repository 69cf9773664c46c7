"""What `shaderlab explain` asks of a worker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.errors import in_file
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Explanation

if TYPE_CHECKING:
    from .compare_shaders import ShaderOfFile
    from .lab_worker import LabWorker


@dataclass(frozen=True)
class ExplainPixel:
    """Asks for the `Explanation` of a draw at a pixel, by default the one whose band is widest.

    `pass_name` is None for the last pass; `draw` counts from 0, from the last one if negative.
    """

    file: Path
    variant: str
    pass_name: str | None
    draw: int
    pixel: tuple[int, int] | None
    options: RunOptions

    def perform(self, worker: LabWorker) -> Explanation:
        from shaderlab.analysis.explain import explain, widest_pixel

        lab, scene = worker.lab(self.options), worker.scenes(str(self.file))[self.variant]
        key = scene.draw_key(self.pass_name, self.draw)
        with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
            return explain(evaluation, key, self.pixel or widest_pixel(evaluation, key))


@dataclass(frozen=True)
class ExplainFile:
    """Asks for the `Explanation` of a shader file at the invocation, of some that are made up,
    whose band is widest; and for what that gets, by name."""

    shader: ShaderOfFile
    ranges: Mapping[str, str]

    def perform(self, worker: LabWorker) -> tuple[Explanation, Mapping[str, tuple[float, ...]]]:
        from shaderlab.analysis.explain import explain_file
        from shaderlab.analysis.interpreter import load

        worker.note("compiling")
        with in_file(self.shader.file.path):
            program = load(self.shader.source(None))
            worker.note("interpreting")
            return explain_file(program, self.ranges)
