"""What a case file does to its process is not there for the next file."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from shaderlab.engine.jobs import DEFECT, Job, ProcessExecutor, RunJob, make_failed_record
from shaderlab.engine.worker import Worker
from shaderlab.model.options import RunOptions
from shaderlab.workers.process_state import ProcessState

SPOILERS = {
    "folder": "os.mkdir('gone'); os.chdir('gone'); os.rmdir('../gone')",
    "open": "builtins.open = None",
    "a name less": "del builtins.sorted",
    "search path": "sys.path.clear()",
    "search path's object": "sys.path = []",
    "hooks": "sys.meta_path.insert(0, sys.meta_path[0])",
    "environment": "os.environ['LANG'] = 'xx'",
    "environment emptied": "os.environ.clear()",
    "locale": "locale.setlocale(locale.LC_ALL, 'C.UTF-8' if 'C' == locale.setlocale(0) else 'C')",
    "signal": "signal.signal(signal.SIGALRM, signal.SIG_IGN)",
    "blocked signal": "signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM])",
    "warnings": "warnings.simplefilter('error')",
    "errstate": "np.seterr(all='raise')",
    "print options": "np.set_printoptions(precision=2)",
    "random": "random.random()",
    "NumPy's random": "np.random.seed(1)",
    "rounding": "ctypes.CDLL(None).fesetround(0x800)",
    "umask": "os.umask(0o777)",
    "open files": "files = [os.dup(1) for _ in range(250 - os.dup(1))]",
    "limit": "resource.setrlimit(resource.RLIMIT_NOFILE, (20, 20))",
    "thread": "threading.Thread(target=time.sleep, args=[600], daemon=True).start()",
    "child": "subprocess.Popen(['sleep', '600'])",
    "math": "math.sin = math.cos",
    "inspect": "inspect.signature = None",
    "re": "re.compile = lambda *_: None",
    "struct": "struct.pack = struct.calcsize",
    "functools": "functools.partial = None",
    "NumPy": "np.sqrt = np.cbrt",
    "NumPy deep inside": "np.linalg._linalg.norm = None",
    "a method": "pathlib.Path.exists = lambda self: False",
    "a record's constructor": "shaderlab.model.records.Record.__init__ = print",
    "a property": "shaderlab.engine.run.SceneRunner.backend = None",
    "another NumPy": "sys.modules['numpy'] = math",
    "recursion": "sys.setrecursionlimit(5000)",
    "standard error": "sys.stderr = None",
    "trace": "sys.settrace(lambda *_: None)",
    "what is imported lazily": "shaderlab.Case = int",
    "an audit hook": "sys.addaudithook(lambda event, _: 1 / 0 if event == 'open' else None)",
    "a hook of imports": "sys.addaudithook(lambda event, _: 1 / 0 if event == 'import' else None)",
}
IMPORTS = """
import builtins, ctypes, functools, inspect, locale, math, os, pathlib, random, re, resource
import signal, struct, subprocess, sys, threading, time, warnings
import numpy as np
import shaderlab.engine.run
"""


def changed_by(code: str, folder: Path) -> bool:
    """Whether the state of a copy of this process has changed after this code."""
    process = os.fork()
    if process == 0:
        status = 2
        try:
            os.setpgid(0, 0)
            os.chdir(folder)
            names: dict[str, object] = {}
            exec(IMPORTS, names)
            resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256))
            state = ProcessState()
            exec(code, names)
            status = int(state.has_changed())
        finally:
            os._exit(status)
    _, status = os.waitpid(process, 0)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process, 9)  # its children
    assert os.waitstatus_to_exitcode(status) < 2
    return bool(status)


def ask(codes: Sequence[str], folder: Path) -> list[bool]:
    """`changed_by` for each, in a process that is smaller and so quicker to copy than a test's."""
    program = f"""{IMPORTS}
import json
from tests.unit.test_process_state import Path, changed_by
print(json.dumps([changed_by(code, Path(sys.argv[1])) for code in json.load(sys.stdin)]))
"""
    done = subprocess.run(
        [sys.executable, "-c", program, folder],
        input=json.dumps(codes),
        capture_output=True,
        check=True,
        cwd=Path(__file__).parents[2],
        text=True,
    )
    found: list[bool] = json.loads(done.stdout)
    return found


def test_each_spoiler_is_noticed(tmp_path: Path) -> None:
    noticed = ask(list(SPOILERS.values()), tmp_path)
    assert [name for name, seen in zip(SPOILERS, noticed, strict=True) if not seen] == []


def test_what_cases_do_is_no_change(tmp_path: Path) -> None:
    codes = [
        "import colorsys",
        "x = np.float32(0.1) * np.arange(9)",
        "np.random.default_rng(1).random()",
        "with np.errstate(all='ignore'): np.log(0.0)",
        "sum(map(math.sqrt, range(9)))",
        "from shaderlab import Case, formula, glsl",
        "sys.addaudithook(lambda event, _: None)",
    ]
    assert ask(codes, tmp_path) == [False] * len(codes)


WORST = ["folder", "open", "search path", "environment emptied", "NumPy", "math", "errstate"]


@pytest.mark.parametrize("names", ["asz", "zsa"])
def test_the_next_file_is_loaded_in_a_fresh_process(
    names: str, case_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(case_folder)
    good = Path("lamp.py").read_text()
    unspoilt = "import math, sys, numpy, os\nassert math.cos(0) == numpy.sqrt(1) and os.environ\n"
    for name in names:
        Path(f"{name}.py").write_text(f"{good}\n{unspoilt}")
    Path("s.py").write_text(good + IMPORTS + "\n".join(SPOILERS[name] for name in WORST))
    files = [Path(f"{name}.py") for name in names]
    with contextlib.closing(ProcessExecutor(early=False)) as executor:
        found = executor.load(files)
    good_ones = [info for info in found if info.id != "s"]
    assert [(info.status, info.error) for info in good_ones] == [("pass", None)] * 2


@pytest.mark.parametrize("changed", [True, False])
def test_no_defect_of_the_lab_is_what_the_case_has_changed(changed: bool) -> None:
    job = Job(file="a.py", id="a", variant="default")
    record = make_failed_record(job, "error", f"unforeseen TypeError\n→ {DEFECT}")
    scene = SimpleNamespace(case=SimpleNamespace(id="a"))
    worker = SimpleNamespace(
        lab=lambda options: SimpleNamespace(run=lambda scene: record),
        note=print,
        scenes=lambda file: {"default": scene},
        has_changed=lambda: changed,
    )
    said = RunJob(job, RunOptions()).perform(cast(Worker, worker)).message
    assert ("defect" in said, "the case changes" in said) == (not changed, changed)
