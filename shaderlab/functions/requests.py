"""What calling functions asks of a worker, where a hang or a crash costs one call."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.engines import choose
from shaderlab.compiler.sources import Source
from shaderlab.drivers import Evaluation
from shaderlab.errors import ShaderError
from shaderlab.functions.memory import Region
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.workers.lab_worker import LabWorker

_VERSION = re.compile(r"#version \d+")


@dataclass(frozen=True)
class Preprocess:
    """Asks for a text after the preprocessor, line for line. Raises ShaderError."""

    source: Source

    def perform(self, worker: LabWorker) -> str:
        worker.note("preprocessing")
        text = choose().preprocess(self.source)
        if text is None:
            cached_compiler()((self.source,), ("glsl",)).require()
            raise ShaderError("the preprocessor fails", file=self.source.path)
        return text


@dataclass(frozen=True)
class Evaluate:
    """Asks for an evaluation; inputs are at the start of the memory, outputs behind them.

    Attributes:
        evaluation: what to run.
        versions: of GLSL to try, one after the other; later ones than the driver's become that.
        layers, words: of the inputs and of the outputs.
        region: the memory.
        note: what runs, for messages.
        driver: as in `shaderlab.drivers.open_backend`.
    """

    evaluation: Evaluation
    versions: tuple[int, ...]
    layers: int
    words: int
    region: Region
    note: str
    driver: str | None

    def perform(self, worker: LabWorker) -> None:
        """See `shaderlab.workers.jobs.Request`. Raises as `Backend.evaluate`."""
        worker.note(self.note)
        lab = worker.lab(RunOptions(driver=self.driver))
        memory = worker.keep("memory", self.region, self.region.opened)
        width, height = self.evaluation.size
        shape = (height, width, self.evaluation.lanes)
        count = self.layers + self.words
        whole = np.frombuffer(memory, np.uint32, count * int(np.prod(shape)))
        layers = whole.reshape(count, *shape)
        newest = int(lab.backend.info["glsl"].replace(".", "")[:3])
        refused: ShaderError | None = None
        for version in self.versions:
            passes = tuple((_as(s, min(version, newest)), n) for s, n in self.evaluation.passes)
            evaluation = replace(self.evaluation, passes=passes)
            try:
                lab.backend.evaluate(evaluation, layers[: self.layers], layers[self.layers :])
            except ShaderError as error:
                refused = refused or error
            else:
                return
        assert refused is not None
        for source, _ in self.evaluation.passes:  # glslang's words are the better ones
            cached_compiler()((source,), ("glsl",)).require()
        raise refused


def _as(source: Source, version: int) -> Source:
    """The source in another version of GLSL."""
    text = _VERSION.sub(f"#version {version}", source.text, count=1)
    return source if text == source.text else replace(source, text=text, stripped=None)
