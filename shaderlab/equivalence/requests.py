"""What `shaderlab diff` asks of a worker, where a shader that never ends costs one answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shaderlab.compiler.shader_files import ShaderFile
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.equivalence.answer import Answer
from shaderlab.equivalence.comparison import Plan, compare_programs
from shaderlab.interpreter import load


@dataclass(frozen=True)
class ShaderOfFile:
    """A shader file, and the folders that it includes from besides its own."""

    file: ShaderFile
    include: Sequence[str] = ()

    def source(self, stage: str | None) -> Source:
        """Its text with includes expanded. Raises ShaderError."""
        folders = dict.fromkeys([self.file.root, *self.include])
        return Shaders([Path(folder) for folder in folders]).load(self.file.name, stage)


@dataclass(frozen=True)
class CompareFiles:
    """Asks for the `Answer` on two shader files.

    Raises as `shaderlab.interpreter.load` and `compare_programs`.
    """

    old: ShaderOfFile
    new: ShaderOfFile
    stage: str | None
    plan: Plan

    def perform(self, worker: Any) -> Answer:
        """See `shaderlab.execution.jobs.Request`."""
        worker.note("compiling")
        old, new = (load(shader.source(self.stage)) for shader in (self.old, self.new))
        worker.note("interpreting")
        return compare_programs(old, new, self.plan)
