"""What tests share: the checkout's folder, records to show, and a lab that draws nothing."""

from __future__ import annotations

import atexit
import compileall
import dataclasses
import gc
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from shaderlab.errors import Diagnostic, Verdict
from shaderlab.model.options import CALL_LIMITS, Limits
from shaderlab.model.records import Outcome, ProgramRecord, Record, SourceText, Worst

# A session's tests, and the processes that they start, share a compile cache that is empty when
# they begin: what was compiled at another time is not tested, and nothing is compiled twice.
# Processes of pytest-xdist have the folder from the one that began them, which removes it.
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["SHADERLAB_CACHE_DIR"] = tempfile.mkdtemp(prefix="shaderlab-tests-")
    atexit.register(shutil.rmtree, os.environ["SHADERLAB_CACHE_DIR"], ignore_errors=True)
    # Where PYTHONDONTWRITEBYTECODE is set, each process that tests start would compile what has
    # changed since `make setup`.
    for folder in ("shaderlab", "cases"):
        compileall.compile_dir(Path(__file__).parents[1] / folder, quiet=2)
# What a person's shell says of colours, widths and screens is not what tests expect.
for name in (
    "FORCE_COLOR", "NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "TTY_COMPATIBLE", "COLUMNS", "LINES",
    "PYTHONWARNINGS", "DISPLAY", "WAYLAND_DISPLAY",
):  # fmt: skip
    os.environ.pop(name, None)
# As workers have it. Small matrices are computed 30 times slower by threads that share a processor.
# NumPy reads this when it is first imported, which nothing does before this file.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# One of several processes has one core: a command's second worker only takes its time to start.
# So does a driver's second thread.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("SHADERLAB_JOBS", "1")
    os.environ.setdefault("LP_NUM_THREADS", "0")


class AsCompiled:
    """Finds the lab's modules as `make setup` compiled them. pytest takes the package of a plugin
    for tests, and compiles each of its modules anew, for the sake of its assertions."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, _: object = None) -> Any:
        return PathFinder.find_spec(name, path) if name.startswith("shaderlab.") else None


sys.meta_path.insert(0, AsCompiled())

from shaderlab.analysis import self_check  # noqa: E402

self_check.register()  # as each worker does

# A busy machine makes no example wrong.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """What collecting makes, modules and items, lives until the end. Nothing looks for garbage in
    it: not while it grows, and not whenever a test makes some. Modules of tests are compiled once,
    not in each process of each session."""
    gc.disable()
    kept, sys.dont_write_bytecode = sys.dont_write_bytecode, False
    try:
        return (yield)
    finally:
        sys.dont_write_bytecode = kept
        gc.freeze()
        gc.enable()


# A library that counts what it made says so if an ending process keeps some.
atexit.register(gc.unfreeze)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """One process of pytest-xdist opens all pages, in one browser."""
    if config.getvalue("dist") != "loadscope":
        return None
    from xdist.scheduler import LoadScopeScheduling

    class PagesTogether(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            pages = nodeid.startswith("tests/browser/")
            return "tests/browser" if pages else super()._split_scope(nodeid)

    return PagesTogether(config, log)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """End with how many tests were skipped for want of a system's package, and how to get it."""
    skipped = len(terminalreporter.stats.get("skipped", ()))
    system = Path(__file__).resolve().parent.parent / ".ci" / "system"
    if skipped and "PYTEST_XDIST_WORKER" not in os.environ and system.exists():
        done = subprocess.run(
            [system, "explain-tests"], capture_output=True, text=True, stdin=subprocess.DEVNULL
        )
        if command := done.stdout.strip():
            terminalreporter.write_line(f"{skipped} tests were skipped. To run them: {command}")


@pytest.fixture(scope="session")
def repository() -> Path:
    """The checkout that these tests are part of."""
    return Path(__file__).resolve().parent.parent


@pytest.fixture
def passing() -> Record:
    """A record of a case that passes."""
    return Record(
        id="lamp",
        variant="default",
        title="A lamp",
        section="5.1",
        lesson="",
        formula="",
        file="cases/lamp.py",
        status="pass",
        seconds=0.25,
        compile={"glsl": "ok", "opengl": "ok", "vulkan": "ok"},
        expectations=(Outcome(name="factor", kind="formula", status="pass", judged=4096),),
    )


@pytest.fixture
def failing(passing: Record) -> Record:
    """A record of the same case, one pixel of which is far off."""
    worst = Worst(
        pixel=(3, 17),
        component=1,
        measured=(0.5, 0.25),
        reference=(0.5, 0.125),
        low=(0.4999, 0.1249),
        high=(0.5001, 0.1251),
        ulp=8388608.0,
        widths=1250.0,
        inputs={"distance": (2.5,), "light_constant": (1.0,)},
    )
    sources = (
        SourceText(file="reference/lamp.py", line=12, language="python", text="return 1"),
        SourceText(file="shaders/lamp.frag", line=7, language="glsl", text="factor = 2.0;"),
    )
    outcome = Outcome(
        name="factor",
        kind="formula",
        status="fail",
        judged=4096,
        outside=47,
        worst=worst,
        sources=sources,
    )
    return dataclasses.replace(passing, variant="50", status="fail", expectations=(outcome,))


@pytest.fixture
def refused(passing: Record) -> Record:
    """A record of a case whose shader no compiler takes."""
    said = Diagnostic(
        file="shaders/lamp.frag", line=7, severity="error", message="'x' : undeclared identifier"
    )
    verdicts = tuple(
        Verdict(target=target, ok=False, diagnostics=(said,)) for target in ("glsl", "vulkan")
    )
    program = ProgramRecord(files=("shaders/lamp.frag",), sources=(), verdicts=verdicts)
    return dataclasses.replace(
        passing,
        status="error",
        message="the program does not compile",
        programs=(program,),
        compile={"glsl": "fail", "vulkan": "fail"},
        expectations=(),
    )


class Imports:
    """A plugin that notes what a session has imported, its own cases and tests apart."""

    def __init__(self) -> None:
        self.found: dict[str, ModuleType] = {}
        self.own = Path()

    def pytest_unconfigure(self) -> None:
        for name, module in sys.modules.items():
            file = getattr(module, "__file__", None)
            if file and not Path(file).is_relative_to(self.own):
                self.found[name] = module


@pytest.fixture
def imports() -> Iterator[Imports]:
    """What sessions in this process import stays imported, which pytest's own fixture would undo:
    of a module that is imported again there would be two of each class."""
    made = Imports()
    yield made
    sys.modules.update(made.found)


@pytest.fixture
def pytester(
    imports: Imports, pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> Iterator[pytest.Pytester]:
    """pytest's own, whose sessions leave out Hypothesis: its import takes longer than they do.
    Those in this process leave it its limits."""
    monkeypatch.setenv("PYTEST_ADDOPTS", "-p no:hypothesispytest")
    imports.own, run = pytester.path.parent, pytester.runpytest_inprocess

    def session(*args: Any) -> pytest.RunResult:
        try:
            with np.printoptions(legacy=False):  # which packages change that others import here
                return run(*args, plugins=[imports])
        finally:
            sys.modules.update(imports.found)

    monkeypatch.setattr(pytester, "runpytest_inprocess", session)
    limits = CALL_LIMITS.set(CALL_LIMITS.get(Limits()))
    yield pytester
    CALL_LIMITS.reset(limits)


class FakeLab:
    """Stands in for a `SceneRunner`: every scene passes but those named in `answers`."""

    def __init__(self, answers: Mapping[str, Record], template: Record, log: list[Any]) -> None:
        self._answers = answers
        self._template = template
        self._log = log
        self.options: Any = None
        self.driver = {"renderer": "none", "vendor": "none", "version": "0", "glsl": "0"}
        self.versions = {"numpy": "0"}

    def __enter__(self) -> FakeLab:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._log.append("closed")

    def configure(self, options: Any) -> None:
        self.options = options

    def run(self, scene: Any) -> Record:
        self._log.append(f"{scene.case.id}[{scene.variant}]")
        template = self._answers.get(scene.variant) or self._answers.get(scene.case.id)
        return dataclasses.replace(
            template or self._template,
            id=scene.case.id,
            variant=scene.variant,
            title=scene.case.title,
            file=scene.case.file,
        )


@pytest.fixture
def fake_lab(
    monkeypatch: pytest.MonkeyPatch, passing: Record
) -> Callable[[Mapping[str, Record]], list[Any]]:
    """Call it with answers by variant or case id; returns the log of options and scenes."""

    def install(answers: Mapping[str, Record]) -> list[Any]:
        log: list[Any] = []

        def lab(options: Any = None, notice: Any = None) -> FakeLab:
            log.append(options)
            made = FakeLab(answers, passing, log)
            made.options = options
            return made

        monkeypatch.setattr("shaderlab.engine.worker.SceneRunner", lab)
        monkeypatch.setenv("SHADERLAB_JOBS", "0")  # worker processes would have the real one
        return log

    return install


CASE_FILE = '''\
"""A lamp fades with distance."""

from shaderlab import Case, Variant, exact, fullscreen

case = Case(
    title="A lamp",
    section="5.1",
    passes=fullscreen("lamp.frag", uniforms={"reach": 1.0}),
    variants=[Variant("near", {"reach": 1.0}), Variant("far", {"reach": 50.0})],
    expect=[exact("FragColor", (1.0, 0.5, 0.25, 1.0))],
)
'''

LAMP_SHADER = """\
#version 330 core
out vec4 FragColor;
in vec2 TexCoords;
uniform float reach;

void main()
{
    FragColor = vec4(1.0, 0.5, 0.25, min(reach + TexCoords.x, 1.0));
}
"""


@pytest.fixture
def case_folder(tmp_path: Path) -> Path:
    """A folder with one case, `lamp` (variants near and far), and its shader."""
    folder = tmp_path / "my_cases"
    folder.mkdir()
    (folder / "lamp.py").write_text(CASE_FILE)
    (folder / "lamp.frag").write_text(LAMP_SHADER)
    return folder
