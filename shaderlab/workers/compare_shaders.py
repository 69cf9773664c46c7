"""What `shaderlab diff` asks of a worker, where a shader that never ends costs one answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.analysis.equivalence.answer import Answer
from shaderlab.analysis.equivalence.comparison import Plan, compare_programs
from shaderlab.analysis.interpreter import Program, load
from shaderlab.compiler.shader_files import ShaderFile
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.errors import in_file
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from .lab_worker import LabWorker


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
    """Asks for the `Answer` on two shader files, as a list.

    Raises as `shaderlab.analysis.interpreter.load` and `compare_programs`.
    """

    old: ShaderOfFile
    new: ShaderOfFile
    stage: str | None
    plan: Plan

    def perform(self, worker: LabWorker) -> list[Answer]:
        worker.note("compiling")
        old, new = (_program(shader.source(self.stage)) for shader in (self.old, self.new))
        worker.note("interpreting")
        with in_file(self.old.file.path):
            return [compare_programs(old, new, self.plan)]


@dataclass(frozen=True)
class CompareInCase:
    """Asks for an `Answer` on each stage of a case's draws that other files for some of its shaders
    change, on the inputs that the case gives it. `reverse` if those files are the old shaders.

    Raises as `rewritten`, `shaderlab.analysis.interpreter.load` and `compare_programs`.
    """

    case: Path
    files: Mapping[str, Path]
    reverse: bool
    plan: Plan
    options: RunOptions

    def perform(self, worker: LabWorker) -> list[Answer]:
        from shaderlab.analysis.case_stages import rewritten

        worker.note("drawing the case")
        lab, case = worker.lab(self.options), worker.case(str(self.case))
        (found,) = rewritten(lab, case, [self.files])
        answers = []
        for one in found:
            worker.note("interpreting")
            pair = (one.new, one.old) if self.reverse else (one.old, one.new)
            old, new = map(_program, pair)
            with in_file(pair[0].path):
                answers.append(compare_programs(old, new, self.plan, one.given))
        return answers


def _program(source: Source) -> Program:
    with in_file(source.path):
        return load(source)
