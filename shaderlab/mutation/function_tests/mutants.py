"""Mistakes in the functions that a file of tests loads, and which tests notice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.errors import CaseError
from shaderlab.files import display_path
from shaderlab.report.plain_text import failed

from .. import Fate, Mutant, MutationPlan, ShaderMutant, chosen, mutants_of
from .comparing import difference
from .running import RunTestFile, TestFileResult

if TYPE_CHECKING:
    from shaderlab.compiler.sources import Source
    from shaderlab.workers.lab_worker import LabWorker

_OPENING_SECONDS = 120.0


@dataclass(frozen=True, kw_only=True)
class FunctionMutant(ShaderMutant):
    """A mistake in a file that tests load: `source` is the file as it is, `used` are the functions
    of it that they ask for, `tests` the names of those that call one; all of them if empty."""

    source: Source
    used: frozenset[str]
    tests: frozenset[str]


@dataclass(frozen=True)
class TestSubject:
    """A file of tests as the subject of a campaign; see `shaderlab.mutation.campaign.Subject`."""

    __test__ = False  # pytest takes it for no test

    file: Path
    id: str
    plan: MutationPlan

    def make(self) -> MakeFunctionMutants:
        """The request for its mutants."""
        return MakeFunctionMutants(self.file, self.plan)

    def judge(self, mutant: Mutant) -> JudgeFunctionMutant:
        """The request for a mutant's fate."""
        assert isinstance(mutant, FunctionMutant)
        return JudgeFunctionMutant(self.file, mutant)


@dataclass(frozen=True)
class MakeFunctionMutants:
    """Asks for the mutants of the functions that tests load.

    Raises CaseError: a test fails as it is, or none loads any function.
    """

    file: Path
    plan: MutationPlan

    def perform(self, worker: LabWorker) -> Sequence[Mutant]:
        worker.restart_limit(_OPENING_SECONDS)
        result = RunTestFile(self.file, alike=True).perform(worker)
        names = ", ".join(r.variant for r in result.records if failed(r))
        if names:
            raise CaseError(f"fails as it is: {names}", file=self.file, remedy="run it with pytest")
        found: list[Mutant] = []
        for text, source in result.loads.sources.items():
            used = frozenset(result.loads.used.get(text, ()))
            tests = _callers(source, result)
            for mutant in mutants_of(source, (source.name,), functions=used):
                given = {**vars(mutant), "source": source, "used": used, "tests": tests}
                found.append(FunctionMutant(**given))
        if not found:
            raise CaseError(
                "no test of this file asks for a function of GLSL",
                file=self.file,
                remedy='load one: glsl.load("lighting.glsl").attenuation',
            )
        return chosen(found, self.plan)


@dataclass(frozen=True)
class JudgeFunctionMutant:
    """Asks for a mutant's `Fate`: killed where a test fails that passes without it."""

    file: Path
    mutant: FunctionMutant

    def perform(self, worker: LabWorker) -> Fate:
        mutant = self.mutant
        texts = {mutant.source.text: mutant.text}
        result = RunTestFile(self.file, texts, mutant.tests, alike=True).perform(worker)
        if result.refused:
            return Fate(status="invalid", by=f"{display_path(mutant.file)} does not compile")
        noticed = {record.variant: failed(record) for record in result.records}
        names = [name for name, fails in noticed.items() if fails]
        if names:
            return Fate(status="killed", by=", ".join(names), noticed=noticed)
        worker.restart_limit()
        found = difference(worker, mutant.source, mutant.text, mutant.used)
        if found.differs is False:
            return Fate(status="no difference", by=found.said, noticed=noticed)
        return Fate(status="survived", by=found.said, noticed=noticed)


def _callers(source: Source, result: TestFileResult) -> frozenset[str]:
    """The tests that call a function of a source; none, for all, where others may depend on it."""
    if source.path in result.loads.called_outside:
        return frozenset()
    path = display_path(source.path)
    return frozenset(
        record.variant
        for record in result.records
        if any(path in program.files[:1] for program in record.programs)
    )
