"""What `audit`, `diff` and `explain` ask of a worker, where a shader that never ends costs one
answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.analysis.answer import Answer
from shaderlab.analysis.audit import Audit, Plan as AuditPlan, audit_program
from shaderlab.analysis.comparison import Plan, compare_programs
from shaderlab.analysis.interpreter import Program, adopt_names, load, read_file
from shaderlab.compiler.shader_files import ShaderFile
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.syntax import Syntax
from shaderlab.compiler.translation import MODULES
from shaderlab.errors import FormulaError, NotInterpretedError, UsageError, in_file
from shaderlab.files import display_path
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Explanation

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker


@dataclass(frozen=True)
class ShaderOfFile:
    """A shader file, and the folders that it includes from besides its own."""

    file: ShaderFile
    include: Sequence[str] = ()

    def source(self, stage: str | None) -> Source:
        """Its text with includes expanded. Raises ShaderError."""
        folders = dict.fromkeys([self.file.root, *self.include])
        return Shaders([Path(folder) for folder in folders]).load(self.file.name, stage)

    def program(self, worker: Worker, stage: str | None, conditions: Sequence[str] = ()) -> Program:
        """As the interpreter runs it, where conditions are met. Raises as `load`, `assume`."""
        worker.note(f"compiling {self.file.path}")
        with in_file(self.file.path):
            if self.is_module and not conditions:
                return read_file(Path(self.file.path), stage)
            return load(assume(self.source(stage), conditions))

    @property
    def is_module(self) -> bool:
        """Whether it is SPIR-V or becomes it, and no GLSL."""
        return self.file.path.lower().endswith(MODULES)


@dataclass(frozen=True)
class CompareFiles:
    """Asks for the `Answer` on two shader files, as a list."""

    old: ShaderOfFile
    new: ShaderOfFile
    stage: str | None
    plan: Plan

    def perform(self, worker: Worker) -> list[Answer]:
        old, new = (shader.program(worker, self.stage) for shader in (self.old, self.new))
        old = adopt_names(old, new) if self.old.is_module else old
        new = adopt_names(new, old) if self.new.is_module else new
        worker.note(f"interpreting {self.old.file.path}")
        with in_file(self.old.file.path):
            return [compare_programs(old, new, self.plan)]


@dataclass(frozen=True)
class CompareInCase:
    """Asks for an `Answer` on each stage of a case's draws that other files for some of its shaders
    change, on the inputs that the case gives it. `reverse` if those files are the old shaders."""

    case: Path
    files: Mapping[str, Path]
    reverse: bool
    plan: Plan
    options: RunOptions

    def perform(self, worker: Worker) -> list[Answer]:
        from shaderlab.analysis.invocations import changed_stages

        worker.note("drawing the case")
        lab, case = worker.lab(self.options), worker.case(str(self.case))
        (found,) = changed_stages(lab, case, [self.files])
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


def assume(source: Source, conditions: Sequence[str]) -> Source:
    """A fragment stage that discards what does not meet some conditions. Raises UsageError: it is
    another stage."""
    if not conditions:
        return source
    if source.stage != "fragment":
        raise UsageError("--assume takes fragment shaders and functions")
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
    plan: AuditPlan

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return self.shader.file.path

    def perform(self, worker: Worker) -> list[Audit]:
        program = self.shader.program(worker, self.stage, self.plan.assume)
        worker.note(f"interpreting {self.shader.file.path}")
        with in_file(self.shader.file.path):
            return [audit_program(program, self.plan)]


@dataclass(frozen=True)
class AuditCase:
    """Asks for an `Audit` of each stage of a case's draws, on what those give it."""

    case: Path
    plan: AuditPlan
    options: RunOptions

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return str(self.case)

    def perform(self, worker: Worker) -> list[Audit]:
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


@dataclass(frozen=True)
class ExplainPixel:
    """Asks for the `Explanation` of a draw at a pixel, by default the one whose band is widest; and
    for what that gets, by name.

    `pass_name` is None for the last pass; `draw` counts from 0, from the last one if negative.
    """

    file: Path
    variant: str
    pass_name: str | None
    draw: int
    pixel: tuple[int, int] | None
    options: RunOptions

    def perform(self, worker: Worker) -> tuple[Explanation, Mapping[str, tuple[float, ...]]]:
        from shaderlab.analysis.explain import explain, inputs_at, widest_pixel

        lab, scene = worker.lab(self.options), worker.scenes(str(self.file))[self.variant]
        key = scene.draw_key(self.pass_name, self.draw)
        with lab.evaluation(scene, lab.prepare_for_opengl(scene)) as evaluation:
            pixel = self.pixel or widest_pixel(evaluation, key)
            return explain(evaluation, key, pixel), inputs_at(evaluation, key, pixel)


@dataclass(frozen=True)
class ExplainFile:
    """Asks for the `Explanation` of a shader file at the invocation, of some that are made up,
    whose band is widest; and for what that gets, by name."""

    shader: ShaderOfFile
    ranges: Mapping[str, str]

    def perform(self, worker: Worker) -> tuple[Explanation, Mapping[str, tuple[float, ...]]]:
        from shaderlab.analysis.explain import explain_file

        program = self.shader.program(worker, None)
        worker.note(f"interpreting {self.shader.file.path}")
        with in_file(self.shader.file.path):
            return explain_file(program, self.ranges)
