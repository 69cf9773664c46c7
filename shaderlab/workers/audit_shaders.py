"""What `shaderlab audit` asks of a worker, where a shader that never ends costs one answer."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.analysis.audit import Audit, Plan, audit_program
from shaderlab.analysis.interpreter import load
from shaderlab.errors import FormulaError, NotInterpretedError, in_file
from shaderlab.files import display_path
from shaderlab.model.options import RunOptions

from .compare_shaders import ShaderOfFile

if TYPE_CHECKING:
    from .lab_worker import LabWorker


@dataclass(frozen=True)
class AuditFile:
    """Asks for the `Audit` of a shader file, as a list.

    Raises as `shaderlab.analysis.interpreter.load` and `audit_program`.
    """

    shader: ShaderOfFile
    stage: str | None
    plan: Plan

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return self.shader.file.path

    def perform(self, worker: LabWorker) -> list[Audit]:
        worker.note("compiling")
        with in_file(self.shader.file.path):
            program = load(self.shader.source(self.stage))
            worker.note("interpreting")
            return [audit_program(program, self.plan)]


@dataclass(frozen=True)
class AuditCase:
    """Asks for an `Audit` of each stage of a case's draws, on what those give it.

    Raises as `shaderlab.analysis.case_stages.stages` and `shaderlab.analysis.interpreter.load`.
    """

    case: Path
    plan: Plan
    options: RunOptions

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return str(self.case)

    def perform(self, worker: LabWorker) -> list[Audit]:
        from shaderlab.analysis.case_stages import stages

        worker.note("drawing the case")
        lab, case = worker.lab(self.options), worker.case(str(self.case))
        audits = []
        for source, given in stages(lab, case):
            worker.note("interpreting")
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
