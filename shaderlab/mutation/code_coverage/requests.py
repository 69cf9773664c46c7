"""What `run --coverage` asks of workers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.model.options import RunOptions
from shaderlab.model.records import CodeCoverage

if TYPE_CHECKING:
    from shaderlab.model.case import Scene
    from shaderlab.workers.lab_worker import LabWorker


@dataclass(frozen=True)
class CoverCase:
    """Asks for the `CodeCoverage` of some variants of a case."""

    file: Path
    variants: tuple[str, ...]
    options: RunOptions

    def perform(self, worker: LabWorker) -> CodeCoverage:
        from .measure import code_coverage

        scenes = worker.scenes(str(self.file))

        def each() -> Iterator[Scene]:
            for name in self.variants:
                worker.restart_limit()  # it is that of a scene
                yield scenes[name]

        return code_coverage(worker.lab(self.options), each())
