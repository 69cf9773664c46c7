"""Runs with a compile cache: the same records, and never another shader's verdict.

To see that a run reads the cache, the tests alter its entries: every verdict for Vulkan becomes a
refusal in words that no compiler has.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from shaderlab.cli import cli
from shaderlab.compiler import compile_cache, glslang
from shaderlab.compiler.compile_cache import Store, decode, encode
from shaderlab.errors import Diagnostic

Call = Callable[..., Result]
SAID = "only the cache says so"


@pytest.fixture(autouse=True)
def settled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compilers that have just been changed cache nothing; a developer may have done so, also after
    this process started."""
    digest = compile_cache.files_digest
    monkeypatch.setattr(compile_cache, "files_digest", lambda paths: digest(paths, time.time()))
    code = Path(compile_cache.__file__).parent
    files = [*glslang.files(), *code.glob("*.py"), *code.parent.glob("*.py")]
    newest = max(os.stat(file).st_ctime for file in files)
    time.sleep(max(0.0, newest + 3.0 - time.time()))


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "cache" / "compiled")


@pytest.fixture
def call(case_folder: Path, store: Store, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Runs the command line beside the case; programs are cached in `store`."""
    monkeypatch.chdir(case_folder)

    def call(*words: str, cache: str | None = None) -> Result:
        named = str(store.folder.parent) if cache is None else cache
        return CliRunner().invoke(cli, words, env={"SHADERLAB_CACHE_DIR": named})

    return call


def ran(call: Call, **more: str) -> dict[str, Any]:
    """The first case's result of a run, less what differs from run to run."""
    result = call("run", "lamp.py", "--variant", "near", "-j", "0", "--json", "-", **more)
    assert result.stdout, result.stderr
    (case,) = json.loads(result.stdout)["cases"]
    return {name: value for name, value in case.items() if name not in ("seconds", "timings")}


def elsewhere(store: Store, *words: str) -> subprocess.Popen[str]:
    """A module that is run in a process of its own, with `store` as its cache."""
    return subprocess.Popen(
        [sys.executable, "-m", *words],
        env={**os.environ, "SHADERLAB_CACHE_DIR": str(store.folder.parent)},
        stdout=subprocess.PIPE,
        text=True,
    )


def keys(store: Store) -> list[str]:
    return [file.parent.name + file.name for file in store.folder.glob("?/*")]


def alter(store: Store) -> int:
    """Makes Vulkan refuse each cached program; returns how many there are."""
    said = Diagnostic(file="lamp.frag", line=1, severity="error", message=SAID)
    altered = 0
    for key in keys(store):
        content = store.get(key)
        assert content is not None
        try:
            entry = decode(content)
        except ValueError:  # the digest of the compilers
            continue
        verdicts = tuple(
            dataclasses.replace(v, ok=False, diagnostics=(said,)) if v.target == "vulkan" else v
            for v in entry.verdicts
        )
        store.put(key, encode(dataclasses.replace(entry, verdicts=verdicts)))
        altered += 1
    return altered


def test_a_second_run_gives_the_same_record(call: Call, store: Store) -> None:
    without, first, second = ran(call, cache=""), ran(call), ran(call)
    assert without["status"] == "pass"
    assert first == second == without
    assert alter(store) == 2  # the shader alone, and with the vertex stage that is written for it


def test_a_cached_program_is_used_until_the_shader_changes(
    call: Call, store: Store, case_folder: Path
) -> None:
    assert ran(call)["status"] == "pass"
    alter(store)
    assert ran(call)["compile"]["vulkan"] == "fail"  # so a run uses what it finds
    assert ran(call, cache="")["status"] == "pass"  # and nothing where it is switched off
    shader = case_folder / "lamp.frag"
    text = shader.read_text()
    shader.write_text(text + "// changed\n")
    assert ran(call)["status"] == "pass"
    shader.write_text(text.replace("0.25", "0.26"))
    assert ran(call)["status"] == "fail"
    shader.write_text(text.replace("min(reach", "min(raech"))
    for _ in range(2):
        refused = call("run", "lamp.py", "--variant", "near", "-j", "0")
        assert refused.exit_code == 1
        assert "lamp.frag:8: error: 'raech' : undeclared identifier" in refused.output
    shader.write_text(text)
    assert ran(call)["compile"]["vulkan"] == "fail"  # the altered one again


def test_damaged_files_are_ignored(call: Call, store: Store) -> None:
    first = ran(call)
    alter(store)
    for file in store.folder.glob("?/*"):
        file.write_bytes(file.read_bytes()[:-1])
    assert ran(call) == first


def test_a_file_in_the_folders_place_is_ignored(call: Call, case_folder: Path) -> None:
    assert ran(call, cache=str(case_folder / "lamp.py"))["status"] == "pass"


def test_pytest_uses_the_cache(
    pytester: pytest.Pytester,
    case_folder: Path,
    store: Store,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(store.folder.parent))
    near = (f"{case_folder / 'lamp.py'}::lamp[near]", "-o", "shaderlab_jobs=0")
    pytester.runpytest_inprocess(*near).assert_outcomes(passed=1)
    assert alter(store) == 3  # and once more with its literals kept, to be interpreted
    altered = pytester.runpytest_inprocess(*near)
    altered.assert_outcomes(failed=1)
    assert SAID in altered.stdout.str()


def test_mutants_are_cached_and_get_the_same_fate(call: Call, store: Store) -> None:
    def mutated(**more: str) -> dict[str, Any]:
        words = ("mutate", "lamp.py", "--variant", "near", "-j", "0", "--json", "-", "--limit", "9")
        (case,) = json.loads(call(*words, **more).stdout)["cases"]
        return {name: value for name, value in case.items() if name != "seconds"}

    without, first, second = mutated(cache=""), mutated(), mutated()
    assert without["killed"] > 3
    assert first == second == without
    assert alter(store) > 9


def test_the_compile_command_uses_no_cache(call: Call, store: Store) -> None:
    for _ in range(2):
        assert call("compile", "lamp.frag").exit_code == 0
    assert not keys(store)


@pytest.mark.usefixtures("call")
def test_runs_at_the_same_time_share_a_folder(store: Store) -> None:
    words = ("shaderlab", "run", "lamp.py", "--variant", "near", "-j", "0", "--report")
    running = [elsewhere(store, *words, f"report-{number}") for number in range(2)]
    for process in running:
        said, _ = process.communicate(timeout=120)
        assert process.returncode == 0, said
    assert all(store.get(key) is not None for key in keys(store))
    assert alter(store) == 3
