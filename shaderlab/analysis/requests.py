"""What `audit`, `diff` and `explain` ask of a worker, where a shader that never ends costs one
answer.

Commands import this before the first worker is started, so it imports little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.analysis.hazards import Audit, Plan
from shaderlab.compiler.shader_files import ShaderFile, holds_glsl
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.translation import MODULES
from shaderlab.errors import FormulaError, NotInterpretedError, UsageError, in_file
from shaderlab.files import display_path
from shaderlab.model.options import RunOptions

if TYPE_CHECKING:
    from shaderlab.analysis.interpreter import Program
    from shaderlab.engine.jobs import BareWorker
    from shaderlab.engine.worker import Worker


@dataclass(frozen=True)
class ShaderOfFile:
    """A shader file, and the folders that it includes from besides its own."""

    file: ShaderFile
    include: Sequence[str] = ()

    @property
    def folders(self) -> list[Path]:
        return [Path(folder) for folder in dict.fromkeys([self.file.root, *self.include])]

    def source(self, stage: str | None) -> Source:
        """Its text with includes expanded. Raises ShaderError."""
        return Shaders(self.folders).load(self.file.name, stage)

    def program(
        self, worker: BareWorker, stage: str | None, conditions: Sequence[str] = ()
    ) -> Program:
        """As the interpreter runs it, where conditions are met. Raises as `load`, `assume`."""
        from shaderlab.analysis.interpreter import load, read_file

        worker.note(f"compiling {self.file.path}")
        with in_file(self.file.path):
            if self.is_module and not conditions:
                program = read_file(Path(self.file.path), stage)
            else:
                program = load(assume(self.source(stage), conditions))
        worker.note(f"interpreting {self.file.path}")
        return program

    @property
    def is_module(self) -> bool:
        """Whether it is SPIR-V or becomes it, and no GLSL."""
        return self.file.path.lower().endswith(MODULES) and not holds_glsl(self.file.path)


def assume(source: Source, conditions: Sequence[str]) -> Source:
    """A fragment stage that discards what does not meet some conditions. Raises UsageError: it is
    another stage."""
    if not conditions:
        return source
    if source.stage != "fragment":
        raise UsageError("--assume takes fragment shaders and functions")
    from shaderlab.compiler.syntax import Syntax

    body = Syntax(source.text).functions["main"][0].child_by_field_name("body")
    assert body is not None
    data, start = source.text.encode(), body.start_byte + 1
    added = "".join(f" if (!({one})) discard;" for one in conditions).encode()
    return replace(source, text=(data[:start] + added + data[start:]).decode(), stripped=None)


@dataclass(frozen=True)
class AuditFile:
    """Asks for the `Audit` of a shader file, as a list."""

    shader: ShaderOfFile
    stage: str | None
    plan: Plan

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return self.shader.file.path

    def perform(self, worker: BareWorker) -> list[Audit]:
        from shaderlab.analysis.audit import audit_program

        program = self.shader.program(worker, self.stage, self.plan.assume)
        with in_file(self.shader.file.path):
            return [audit_program(program, self.plan)]


@dataclass(frozen=True)
class AuditCase:
    """Asks for an `Audit` of each stage of a case's draws, on what those give it."""

    case: Path
    plan: Plan
    options: RunOptions

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return str(self.case)

    def perform(self, worker: Worker) -> list[Audit]:
        from shaderlab.analysis.audit import audit_program
        from shaderlab.analysis.interpreter import load
        from shaderlab.analysis.invocations import case_stages

        worker.note("drawing the case")
        lab, case = worker.lab(self.options), worker.case(str(self.case))
        audits = []
        for source, given in case_stages(lab, case):
            worker.note(f"interpreting {source.path}")
            try:
                if not given:
                    raise NotInterpretedError(
                        f"not audited: what the case gives a {source.stage} stage can't be "
                        "captured; audit the file",
                        file=source.path,
                    )
                with in_file(display_path(source.path)):
                    audits.append(audit_program(load(source), self.plan, given))
            except (NotInterpretedError, FormulaError) as error:
                audits.append(Audit(file=source.path, hazards=(), tried=0, refused=str(error)))
        return audits
