"""What `audit` and `diff` ask of a worker about a file of functions: each of them by itself."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

from shaderlab.analysis.audit import Audit, Plan as AuditPlan, audit_program
from shaderlab.analysis.equivalence.answer import Answer, OutputAnswer
from shaderlab.analysis.equivalence.comparison import Plan as ComparisonPlan, compare_programs
from shaderlab.analysis.inputs import inputs_of, unknown_names
from shaderlab.analysis.interpreter import Program, load
from shaderlab.errors import ShaderError, ShaderlabError, UsageError, nearest
from shaderlab.functions.entry_points import EntryPoint, entry_points
from shaderlab.functions.library import readable
from shaderlab.functions.requests import Preprocess
from shaderlab.functions.running import versions
from shaderlab.workers.compare_shaders import ShaderOfFile

if TYPE_CHECKING:
    from shaderlab.workers.lab_worker import LabWorker

Plan = TypeVar("Plan", AuditPlan, ComparisonPlan)


@dataclass(frozen=True)
class AuditFunctions:
    """Asks for the `Audit` of a file's functions as one, and for one of each that is refused."""

    shader: ShaderOfFile
    plan: AuditPlan

    @property
    def name(self) -> str:
        """What is audited, in words."""
        return self.shader.file.path

    def perform(self, worker: LabWorker) -> list[Audit]:
        """See `shaderlab.workers.jobs.Request`."""
        found, refused = [], []
        functions = _functions(worker, self.shader)
        _check_ranges(self.plan.ranges, functions)
        for function in functions:
            worker.note(f"interpreting {function.signature.name}")
            try:
                program = _program(function)
                audit = audit_program(program, _plan_of(self.plan, program))
            except UsageError:
                raise
            except ShaderlabError as error:
                why = f"{self.shader.file.path}: {function.signature.name}: {error}"
                refused.append(Audit(file=self.shader.file.path, hazards=(), tried=0, refused=why))
                continue
            name = function.signature.name
            inputs = {f"{name}: {word}": role for word, role in audit.inputs.items()}
            spreads = tuple(replace(s, output=f"{name}: {s.output}") for s in audit.spreads)
            found.append(replace(audit, inputs=inputs, spreads=spreads))
        return [*_one(self.shader.file.path, found), *refused]


@dataclass(frozen=True)
class CompareFunctions:
    """Asks for the `Answer` on the functions of two files, each an output of it, as a list."""

    old: ShaderOfFile
    new: ShaderOfFile
    plan: ComparisonPlan

    def perform(self, worker: LabWorker) -> list[Answer]:
        """See `shaderlab.workers.jobs.Request`."""
        old, new = (_functions(worker, shader) for shader in (self.old, self.new))
        _check_ranges(self.plan.ranges, [*old, *new])
        others = {str(one.signature): one for one in new}
        outputs: list[OutputAnswer] = []
        inputs: dict[str, str] = {}
        notes: list[str] = []
        for one in old:
            other = others.pop(str(one.signature), None)
            if other is None:
                outputs.append(OutputAnswer(name=str(one.signature), why="missing"))
                continue
            worker.note(f"interpreting {one.signature.name}")
            name = one.signature.name
            try:
                pair = _program(one), _program(other)
                answer = compare_programs(*pair, _plan_of(self.plan, *pair))
            except UsageError:
                raise
            except ShaderlabError as error:
                outputs.append(OutputAnswer(name=name))
                notes.append(f"can't say of {name}: {error}")
                continue
            alone = len(answer.outputs) == 1
            outputs += [
                replace(o, name=name if alone else f"{name}: {o.name}") for o in answer.outputs
            ]
            notes += [f"{name}: {note}" for note in answer.notes]
            inputs |= {f"{name}: {word}": role for word, role in answer.inputs.items()}
        notes += [f"only {self.new.file.path} has {signature}" for signature in others]
        files = self.old.file.path, self.new.file.path
        return [
            Answer(
                old=files[0],
                new=files[1],
                outputs=tuple(outputs),
                notes=tuple(notes),
                inputs=inputs,
            )
        ]


def _functions(worker: LabWorker, shader: ShaderOfFile) -> list[EntryPoint]:
    worker.note("preprocessing")
    written = shader.source("fragment")
    source = readable(written)
    found = entry_points(source, Preprocess(source).perform(worker), versions(written))
    if not found:
        raise ShaderError("there is no function in it, and no main", file=shader.file.path)
    return found


def _program(function: EntryPoint) -> Program:
    """The function's shader, of the first version of GLSL that takes it.

    Raises:
        ShaderError: none takes it; what the first one says.
    """
    errors = []
    for source in function.sources:
        try:
            return load(source)
        except ShaderError as error:
            errors.append(error)
    raise errors[0]


def _check_ranges(ranges: Mapping[str, str], functions: Sequence[EntryPoint]) -> None:
    """Raise UsageError where a range is of an input that no function has."""
    known: set[str] = set()
    for function in functions if ranges else ():
        with contextlib.suppress(ShaderlabError):
            known |= inputs_of(_program(function)).keys()
    for name in unknown_names(list(ranges), known):
        raise UsageError(f"no function takes {name!r}", remedy=nearest(name, known))


def _plan_of(plan: Plan, *programs: Program) -> Plan:
    """The plan with the ranges of what these programs read."""
    known = [name for program in programs for name in inputs_of(program)]
    unknown = unknown_names(list(plan.ranges), known)
    return replace(plan, ranges={n: r for n, r in plan.ranges.items() if n not in unknown})


def _one(file: str, audits: Sequence[Audit]) -> Iterator[Audit]:
    """What was found in any of the functions, with the inputs of those that have a hazard. What two
    of them call was found in both."""
    hazards = {(h.line, h.file, h.kind): h for audit in audits[::-1] for h in audit.hazards}
    shown = [audit for audit in audits if not audit.clean] or audits
    if audits:
        yield Audit(
            file=file,
            hazards=tuple(hazards[key] for key in sorted(hazards)),
            tried=sum(audit.tried for audit in audits),
            inputs={name: role for audit in shown for name, role in audit.inputs.items()},
            spreads=tuple(spread for audit in audits for spread in audit.spreads),
        )
