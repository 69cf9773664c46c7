"""Files of tests of GLSL functions: run by pytest inside warm workers, for `watch` and `mutate`;
and mistakes in the functions that they load.

pytest is called in the worker's process, which keeps its device.
"""

from __future__ import annotations

import importlib
import importlib.util
import io
import linecache
import os
import sys
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.engine.catalogue import is_project_file
from shaderlab.errors import CaseError, ShaderError, ShaderlabError, require_extra
from shaderlab.files import display_path
from shaderlab.functions.checks import split_result
from shaderlab.functions.evaluation import keeping, use_worker
from shaderlab.functions.library import LOADS, Function, Library, Loads, record_of_test
from shaderlab.functions.properties import Domain, bools, floats, hints_of, ints
from shaderlab.functions.signatures import Type
from shaderlab.model.frame import Array
from shaderlab.mutation.campaign import OPENING_SECONDS, MutationTarget
from shaderlab.mutation.mutants import Mutant, MutantResult
from shaderlab.mutation.shader_mutants import ShaderMutant, mutate_stage
from shaderlab.report.text import has_failed

if TYPE_CHECKING:
    import pytest

    from shaderlab.engine.worker import Worker
    from shaderlab.model.records import Record

_PROFILE = "shaderlab-in-worker"
_SAMPLES = 4096
"""Inputs of each round in which two texts of a function are compared."""
_RANGES = (1.0, 8.0, 1000.0)
"""How far from 0 the numbers of a round go."""


@dataclass(frozen=True)
class TestFileResult:
    """What running a file of tests gave; `refused` says that some GLSL did not compile."""

    __test__ = False  # pytest takes it for no test

    records: tuple[Record, ...]
    loads: Loads
    refused: bool


@dataclass(frozen=True)
class RunTestFile:
    """Requests the result of a file's tests.

    Attributes:
        texts: what to take in place of GLSL that is loaded, by its text with includes expanded.
        only: the names of the only tests to run; all of them if empty.
        alike: whether properties try the same samples each time, without Hypothesis' database.
    """

    __test__ = False

    file: Path
    texts: Mapping[str, str] = field(default_factory=dict)
    only: frozenset[str] = frozenset()
    alike: bool = False

    def perform(self, worker: Worker) -> TestFileResult:
        """See `shaderlab.engine.jobs.Request`. Raises UsageError: pytest is not installed."""
        with require_extra("pytest", "running tests of functions"):
            import pytest

            from shaderlab.pytest_plugin import Recorder

        linecache.checkcache()
        importlib.invalidate_caches()
        with ExitStack() as stack:
            stack.enter_context(_forgetting_own_modules())
            stack.enter_context(use_worker(worker))
            loads = stack.enter_context(keeping(LOADS, Loads(self.texts)))
            session = _Session(worker, self.file, self.only)
            stack.enter_context(redirect_stdout(io.StringIO()))
            recorder = Recorder(lambda _, record: session.records.append(record), every=True)
            pytest.main(self._arguments(), plugins=[session, recorder])
        return TestFileResult(tuple(session.records), loads, session.refused)

    def _arguments(self) -> list[str]:
        words = [str(self.file), "-q", "--color=no", "-p", "no:cacheprovider"]
        words += ["--shaderlab-report=", "-p", "no:unraisableexception"]  # which collects garbage
        if importlib.util.find_spec("xdist") is not None:
            words += ["-n", "0"]
        if self.alike and importlib.util.find_spec("hypothesis") is not None:
            import hypothesis

            hypothesis.settings.register_profile(_PROFILE, database=None, derandomize=True)
            words.append(f"--hypothesis-profile={_PROFILE}")
        return words


class _Session:
    def __init__(self, worker: Worker, file: Path, only: Collection[str]) -> None:
        self._worker = worker
        self._file = file
        self._only = only
        self.records: list[Record] = []
        self.refused = False

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep Python's tests: variants of cases have records of their own."""
        own = [item for item in items if hasattr(item, "function")]
        items[:] = [item for item in own if not self._only or item.name in self._only]

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._worker.note(nodeid)
        self._worker.restart_limit()

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            message, file = report.longreprtext, str(self._file)
            record = record_of_test(file, "collection", 1, status="error", message=message)
            self.records.append(record)

    def pytest_exception_interact(self, call: pytest.CallInfo[Any]) -> None:
        if call.excinfo is not None and isinstance(call.excinfo.value, ShaderError):
            self.refused = True


@contextmanager
def _forgetting_own_modules() -> Iterator[None]:
    """Modules of a project that the block imports are imported anew by the next one: they may have
    loaded GLSL that has changed."""
    before = set(sys.modules)
    try:
        yield
    finally:
        for name in set(sys.modules) - before:
            file = getattr(sys.modules[name], "__file__", None)
            if file and is_project_file(Path(os.path.abspath(file))):
                del sys.modules[name]


@dataclass(frozen=True, kw_only=True)
class FunctionMutant(ShaderMutant):
    """A mistake in a file that tests load: `source` is the file as it is, `used` are the functions
    of it that they ask for, `tests` the names of those that call one and pass as they are, `red`
    those that fail as they are, and so notice nothing."""

    source: Source
    used: frozenset[str]
    tests: frozenset[str]
    red: frozenset[str]


class TestFileTarget(MutationTarget):
    """A file of tests: its mutants are those of the functions that it loads. Raises CaseError: all
    tests fail as they are, or none loads any function."""

    __test__ = False  # pytest takes it for no test

    def judge(self, mutant: FunctionMutant) -> JudgeFunctionMutant:
        return JudgeFunctionMutant(self.file, mutant)

    def perform(self, worker: Worker) -> list[Mutant]:
        worker.restart_limit(OPENING_SECONDS)
        result = RunTestFile(self.file, alike=True).perform(worker)
        red = frozenset(r.variant for r in result.records if has_failed(r))
        green = frozenset(r.variant for r in result.records) - red
        if red and not green:
            names = ", ".join(sorted(red))
            raise CaseError(f"fails as it is: {names}", file=self.file, remedy="run it with pytest")
        found: list[Mutant] = []
        for text, source in result.loads.sources.items():
            used = frozenset(result.loads.used.get(text, ()))
            tests = (_callers(source, result) & green) or green
            mutants = mutate_stage(source, (source.name,), functions=used)
            own: dict[str, Any] = {"source": source, "used": used, "tests": tests, "red": red}
            found += (FunctionMutant(**vars(mutant), **own) for mutant in mutants)
        if not found:
            raise CaseError(
                "no test of this file asks for a function of GLSL",
                file=self.file,
                remedy='load one: glsl.load("lighting.glsl").attenuation',
            )
        return self.plan.sample(found)


@dataclass(frozen=True)
class JudgeFunctionMutant:
    """Requests a mutant's `MutantResult`: killed where a test fails that passes without it."""

    file: Path
    mutant: FunctionMutant

    def perform(self, worker: Worker) -> MutantResult:
        mutant = self.mutant
        texts = {mutant.source.text: mutant.text}
        result = RunTestFile(self.file, texts, mutant.tests, alike=True).perform(worker)
        if result.refused:
            return MutantResult("invalid", f"{display_path(mutant.file)} does not compile")
        noticed = {record.variant: has_failed(record) for record in result.records}
        names = [name for name, fails in noticed.items() if fails]
        noticed |= {f"{name} (left out: it fails as it is)": False for name in mutant.red}
        if names:
            return MutantResult("killed", ", ".join(names), noticed=noticed)
        worker.restart_limit()
        found = compare_texts(worker, mutant.source, mutant.text, mutant.used)
        return replace(found, noticed=noticed)


def _callers(source: Source, result: TestFileResult) -> frozenset[str]:
    """The tests that call a function of a source; none, for all, where others may depend on it."""
    if source.path in result.loads.called_outside:
        return frozenset()
    path = display_path(source.path)
    users = (r for r in result.records if any(path in p.files[:1] for p in r.programs))
    return frozenset(record.variant for record in users)


def compare_texts(
    worker: Worker, source: Source, text: str, names: Collection[str]
) -> MutantResult:
    """Compare these functions of a source and of another text for it, bit by bit: "survived" unless
    they give the same at all arguments that are tried.

    A function that reads other samplers than a `sampler2D` can't be called at random arguments.
    """
    other = replace(source, text=text, stripped=None)
    count, untested = 0, []
    with use_worker(worker):
        folder = os.path.dirname(source.path)
        before, after = (Library(one, folder, {}) for one in (source, other))
        for name in sorted(names):
            for signature in before[name].signatures:
                inputs = {i.name: i.type for i in (*signature.given, *signature.globals)}
                leaves = [leaf for kind in inputs.values() for _, leaf in kind.leaves("")]
                if not all(leaf.kind or leaf.name == "sampler2D" for leaf in leaves):
                    untested.append(name)
                    continue
                types = ", ".join(str(p.type) for p in signature.parameters)
                pair = before[name][types], after[name][types]
                for arguments in _arguments(inputs, source.text + text):
                    count += _SAMPLES
                    if not _same(*pair, arguments):
                        return MutantResult("survived", f"{name} gives other values elsewhere")
    if untested:
        shown = ", ".join(dict.fromkeys(untested))
        return MutantResult("survived", f"{shown} is not called at other values")
    return MutantResult("no difference", f"in {count} inputs of {', '.join(sorted(names))}")


def _arguments(inputs: Mapping[str, Type], text: str) -> Iterator[dict[str, Any]]:
    rng, hints = np.random.default_rng(0), hints_of(text)

    def sample(kind: Type, bound: float, batch: tuple[int, ...]) -> Any:
        """Random values of a type, for each element of a batch; an image for a sampler."""
        if kind.dims and not kind.kind:
            return [sample(kind.element, bound, batch) for _ in range(kind.dims[0])]
        if kind.members:
            return {name: sample(its, bound, batch) for name, its in kind.members}
        if kind.opaque:
            return rng.random((4, 4, 4), np.float32)
        domain: Domain = ints(0 if kind.kind == "uint" else -int(bound), int(bound))
        if kind.kind in ("bool", "float"):
            domain = bools() if kind.kind == "bool" else floats(-bound, bound)
        found = domain.sample(rng, (*(batch or (8,)), *kind.shape), hints)
        return found if batch else found[-1]

    # What is in a struct with samplers has one value for a call.
    for bound in _RANGES:
        batches = {name: () if kind.opaque else (_SAMPLES,) for name, kind in inputs.items()}
        yield {name: sample(kind, bound, batches[name]) for name, kind in inputs.items()}


def _same(before: Function, after: Function, arguments: dict[str, Array]) -> bool:
    (signature,) = before.signatures
    try:
        pair = [
            [part.values for part in split_result(signature.outputs, function(**arguments))]
            for function in (before, after)
        ]
    except ShaderlabError:
        return False  # only one of them gives a value at all
    return all(
        np.array_equal(np.ma.getmaskarray(a), np.ma.getmaskarray(b))
        and np.array_equal(
            np.ma.filled(a, 0), np.ma.filled(b, 0), equal_nan=np.asarray(a).dtype.kind == "f"
        )
        for a, b in zip(*pair, strict=True)
    )
