"""The libraries and the commands: two engines, one result."""

from __future__ import annotations

import os
import random
import stat
from pathlib import Path

import pytest

from benchmarks.trees import mutant, own_shaders
from shaderlab.cli.doctor import examine
from shaderlab.compiler import ALL_TARGETS, Shaders, compile_program
from shaderlab.compiler.commands import Commands, Executables, locate
from shaderlab.compiler.engines import GLSLANG_WHEEL, CompilerDiedError, choose, find
from shaderlab.compiler.harness import compile_glsl
from shaderlab.errors import ShaderError

GOOD = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
VERTEX = "#version 330 core\nin vec3 a;\nout vec3 n;\nvoid main() { n = a; }\n"
PROGRAMS = {
    "no main": {"fragment": GOOD.replace("main", "mane")},
    "a warning": {"fragment": GOOD.replace("out", "#extension GL_nobody_has : enable\nout")},
    "a sampler in a struct": {
        "fragment": "#version 330 core\nstruct M { sampler2D s; float f; };\nuniform M m;\n"
        "out vec4 c;\nvec4 look(M m) { return texture(m.s, vec2(m.f)); }\n"
        "void main() { c = look(m); }\n"
    },
    "macros": {"fragment": GOOD.replace("void", "#define A(x) ((x) + (x))\nvoid")},
    "a constant to specialise": {
        "fragment": GOOD.replace("void", "layout (constant_id = 0) const int n = 4;\nvoid")
    },
    "two stages": {
        "vertex": VERTEX,
        "fragment": GOOD.replace("void", "in vec3 n;\nuniform float x;\nvoid").replace(
            "1.0", "n, x"
        ),
    },
    "stages that do not fit": {
        "vertex": VERTEX,
        "fragment": GOOD.replace("void", "in vec2 n;\nvoid").replace("1.0", "n, n"),
    },
    "an input that nobody writes": {
        "vertex": VERTEX,
        "fragment": GOOD.replace("void", "in vec3 m;\nvoid").replace("1.0", "m, 1.0"),
    },
}


@pytest.fixture(autouse=True)
def no_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SHADERLAB_GLSLANG", raising=False)


@pytest.mark.parametrize("kind", PROGRAMS)
def test_programs_have_the_same_verdicts_messages_and_modules(kind: str) -> None:
    program = PROGRAMS[kind]
    stages = [Shaders([]).from_text(text, stage, f"p.{stage}") for stage, text in program.items()]
    library = compile_program(stages, ALL_TARGETS, engine=choose("library"))
    process = compile_program(stages, ALL_TARGETS, engine=choose("process"))
    assert process.verdicts == library.verdicts
    assert process.spirv == library.spirv
    assert process.interface == library.interface


def test_a_tree_has_the_same_results(tmp_path: Path, repository: Path) -> None:
    rng = random.Random(8)
    own = own_shaders(repository)
    for number in range(20):
        source = own[number % len(own)]
        text = source.text if number % 5 == 0 else mutant(source.code, rng)
        suffix = Path(source.name).suffix
        (tmp_path / f"{number:02}{suffix}").write_text(text, newline="")
    library = list(compile_glsl([tmp_path], engine="library", keep=True))
    process = list(compile_glsl([tmp_path], engine="process", keep=True))
    assert process == library
    assert 3 < sum(result.ok for result in library) < 17


def test_the_variable_names_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    assert choose().name == "library"
    command = find(GLSLANG_WHEEL, "glslangValidator", "bin")
    monkeypatch.setenv("SHADERLAB_GLSLANG", str(command))
    engine = choose()
    assert engine.name == "process"
    told = engine.versions()
    assert told["glslang"] == choose("library").versions()["glslang"]
    assert told["glslang command"] == str(command)
    assert told["SPIRV-Tools"].startswith(choose("library").versions()["SPIRV-Tools"])


@pytest.mark.parametrize("engine", ["library", "process"])
def test_doctor_says_which_engine_and_version(monkeypatch: pytest.MonkeyPatch, engine: str) -> None:
    monkeypatch.setattr("shaderlab.drivers.probe", lambda *_: {"renderer": "none"})
    if engine == "process":
        command = find(GLSLANG_WHEEL, "glslangValidator", "bin")
        monkeypatch.setenv("SHADERLAB_GLSLANG", str(command))
    found = {finding.name: finding.found for finding in examine()}
    words = {"library": "its libraries, in this process", "process": "its commands"}
    assert found["glslang through"] == words[engine]
    assert found["glslang"] == choose("library").versions()["glslang"]
    assert ("glslang command" in found) is (engine == "process")


def test_a_missing_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHADERLAB_GLSLANG", "/nowhere/glslangValidator")
    with pytest.raises(ShaderError, match="names no program: /nowhere/glslangValidator"):
        choose()


def test_without_wheels_the_systems_commands_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(*_: str) -> Path:
        raise ShaderError("not installed")

    monkeypatch.setattr("shaderlab.compiler.commands.find", missing)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("VULKAN_SDK", raising=False)
    with pytest.raises(ShaderError, match="there is no glslangValidator command") as raised:
        locate(None)
    assert "Vulkan SDK" in (raised.value.remedy or "")
    sdk = tmp_path / "sdk" / "bin"
    sdk.mkdir(parents=True)
    monkeypatch.setenv("VULKAN_SDK", str(sdk.parent))
    _script(sdk / "glslang", "")
    with pytest.raises(ShaderError, match="there is no spirv-val command"):
        locate(None)
    _script(sdk / "spirv-val", "")
    assert locate(None) == Executables(sdk / "glslang", sdk / "spirv-val")


@pytest.fixture
def scripted(tmp_path: Path) -> Executables:
    """A compiler that dies on one text and hangs on another; then its process is in `hanging`."""
    real = locate(None)
    text = (
        'case "$(cat *.frag)" in *crash*) kill -SEGV $$;;\n'
        f"*hang*) echo $$ >{tmp_path}/hanging; exec sleep 600;; esac\n"
        f'LD_LIBRARY_PATH={real.glslang.parent.parent}/lib exec {real.glslang} "$@"\n'
    )
    _script(tmp_path / "glslangValidator", text)
    return Executables(tmp_path / "glslangValidator", real.validator)


def test_a_command_that_crashes_or_hangs_costs_only_its_file(
    scripted: Executables, tmp_path: Path
) -> None:
    shaders = Shaders([])
    names = {"a": GOOD, "b": GOOD + "// crash\n", "c": GOOD + "// hang\n", "d": GOOD + "//\n"}
    sources = {n: shaders.from_text(text, "fragment", n) for n, text in names.items()}
    patient, hasty = Commands(scripted, seconds=120.0), Commands(scripted, seconds=2.0)
    assert patient.check(sources["a"]).ok and patient.check(sources["d"]).ok
    for engine, name, status in ((patient, "b", "crash"), (hasty, "c", "timeout")):
        with pytest.raises(CompilerDiedError) as raised:
            engine.check(sources[name])
        assert raised.value.status == status
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "hanging").read_text()), 0)


def test_a_command_that_does_not_start_says_why(tmp_path: Path) -> None:
    _script(tmp_path / "glslangValidator", "echo lib.so: cannot open >&2; exit 127\n")
    engine = Commands(Executables(tmp_path / "glslangValidator", tmp_path / "spirv-val"))
    source = Shaders([]).from_text(GOOD, "fragment", "a.frag")
    with pytest.raises(ShaderError, match=r"does not start: lib\.so: cannot open"):
        engine.check(source)


def _script(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/sh\n{text}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    assert os.access(path, os.X_OK)
