"""Programs that were compiled before: the same result, for as long as nothing of it has changed."""

import dataclasses
import functools
import os
import pickle
import random
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from shaderlab.errors import ShaderError
from shaderlab.glsl import Shaders, Source, compile_program, kept
from shaderlab.glsl.compile import ALL_TARGETS, TARGETS, Compiled
from shaderlab.glsl.kept import Keeper, key_of
from shaderlab.glsl.packing import Package, packed, unpacked
from shaderlab.glsl.programs import CompilerDiedError
from shaderlab.glsl.store import Store

VERTEX = """#version 330 core
in vec3 place;
out vec2 uv;
out vec3 normal;
uniform mat4 model;
layout (std140) uniform Camera { mat4 view; vec4 eyes[2]; };
void main() {
    uv = place.xy; normal = eyes[1].xyz; gl_Position = view * model * vec4(place, 1.0);
}
"""
FRAGMENT = """#version 330 core
#include "light.glsl"
in vec3 normal;
in vec2 uv;
struct Material { sampler2D picture; float shine; };
uniform Material material;
uniform float weights[3];
out vec4 color;
void main() {
    color = texture(material.picture, uv) * light(normal) * weights[1] + material.shine;
}
"""
LIGHT = "float light(vec3 normal) { return max(normal.z, 0.0); }\n"
COMPUTE = """#version 430 core
layout (local_size_x = 8, local_size_y = 4) in;
layout (std430, binding = 1) buffer Sums { int count; float sums[]; };
layout (rgba32f, binding = 0) uniform image2D image;
void main() { sums[gl_GlobalInvocationID.x] = imageLoad(image, ivec2(0)).x; count = 1; }
"""
CONSTANTS = """#version 450 core
layout (constant_id = 3) const int LIGHTS = 4;
layout (constant_id = 4) const float GAIN = 0.1;
layout (constant_id = 5) const bool SIGN = true;
layout (location = 0) out vec4 color;
void main() { color = SIGN ? vec4(LIGHTS) : vec4(GAIN); }
"""
WARNED = (
    "#version 330 core\n#extension GL_ARB_none : enable\nout vec4 c; void main() { c = vec4(1.0); }"
)
WRONG = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(é, missing); }"
UNWRITTEN = "#version 330 core\nin vec2 other; out vec4 c; void main() { c = other.xyxy; }"

FINGERPRINT = "these compilers"


def shaders(tmp_path: Path, **more: str) -> Shaders:
    texts = {"a.vert": VERTEX, "a.frag": FRAGMENT, "light.glsl": LIGHT, "a.comp": COMPUTE}
    for name, text in {**texts, **more}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return Shaders([tmp_path])


def text(code: str, stage: str = "fragment") -> Source:
    return Shaders([]).from_text(code, stage, f"<{stage}>")


def programs(tmp_path: Path) -> dict[str, tuple[list[Source], tuple[str, ...]]]:
    files = shaders(tmp_path)
    vertex, fragment = files.load("a.vert"), files.load("a.frag")
    return {
        "two stages": ([fragment, vertex], TARGETS),
        "all targets": ([vertex, fragment], ALL_TARGETS),
        "one stage": ([fragment], ("glsl", "opengl")),
        "plain": ([vertex], ("glsl",)),
        "compute": ([files.load("a.comp")], TARGETS),
        "constants": ([text(CONSTANTS)], TARGETS),
        "warned": ([text(WARNED)], TARGETS),
        "wrong": ([text(WRONG)], TARGETS),
        "wrongly linked": ([vertex, text(UNWRITTEN)], TARGETS),
        "too deep": ([text("#version 330 core\n" + "{" * 2000)], TARGETS),
    }


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "cache")


@pytest.fixture
def keeper(store: Store) -> Keeper:
    return Keeper(store, lambda: FINGERPRINT)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Sequence[Source]]:
    """The programs that the compilers were asked about."""
    log: list[Sequence[Source]] = []

    def counted(stages: Sequence[Source], targets: Sequence[str], **more: object) -> Compiled:
        log.append(stages)
        return compile_program(stages, targets, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(kept, "compile_program", counted)
    return log


def told(compiled: Compiled) -> str:
    """All of a result, types and order too."""
    return repr((compiled, compiled.sources, compiled.interface))


KINDS = {
    "two stages": True,
    "all targets": False,
    "one stage": True,
    "plain": True,
    "compute": True,
    "constants": False,
    "warned": True,
    "wrong": False,
    "wrongly linked": False,
    "too deep": False,
}


@pytest.mark.parametrize("name", KINDS)
def test_what_is_kept_equals_what_was_compiled(
    tmp_path: Path, keeper: Keeper, asked: list[Sequence[Source]], name: str
) -> None:
    stages, targets = programs(tmp_path)[name]
    true = compile_program(stages, targets)
    first, again = keeper.compile(stages, targets), keeper.compile(stages, targets)
    assert len(asked) == 1
    for field in dataclasses.fields(Compiled):
        if field.compare:
            assert getattr(again, field.name) == getattr(true, field.name), field.name
    assert told(first) == told(again) == told(true)
    assert again.ok == KINDS[name]
    assert any(v.diagnostics for v in again.verdicts) or name in (
        "one stage", "plain", "compute", "two stages",
    )  # fmt: skip


def test_another_process_finds_it_without_a_compiler(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    stages, targets = programs(tmp_path)["two stages"]
    true = Keeper(store, lambda: FINGERPRINT).compile(stages, targets)

    def loaded() -> None:
        raise AssertionError("the compiler's libraries were loaded")

    monkeypatch.setattr("shaderlab.glsl.library.glslang", loaded)
    monkeypatch.setattr("shaderlab.glsl.library.spirv_tools", loaded)
    again = Keeper(Store(store.folder), lambda: FINGERPRINT).compile(stages, targets)
    assert told(again) == told(true)


def test_a_kept_plain_verdict_still_knows_what_the_program_declares(
    tmp_path: Path, keeper: Keeper, asked: list[Sequence[Source]]
) -> None:
    stages, targets = programs(tmp_path)["plain"]
    keeper.compile(stages, targets)
    for _ in range(2):
        interface = keeper.compile(stages, targets).interface
        assert interface is not None and set(interface.attributes) == {"place"}
    assert len(asked) == 2  # once as plain GLSL, once for OpenGL


def changed(of: Callable[[dict[str, str]], None]) -> Callable[[Path], list[Source]]:
    def load(folder: Path) -> list[Source]:
        texts = {"a.vert": VERTEX, "a.frag": FRAGMENT, "light.glsl": LIGHT}
        of(texts)
        files = shaders(folder, **texts)
        return [files.load("a.vert"), files.load("a.frag")]

    return load


def in_place_of(name: str, old: str, new: str) -> Callable[[Path], list[Source]]:
    def replaced(texts: dict[str, str]) -> None:
        assert old in texts[name]
        texts[name] = texts[name].replace(old, new)

    return changed(replaced)


def defined(folder: Path) -> list[Source]:
    files = Shaders([shaders(folder).folders[0]], defines={"SPARE": "1"})
    return [files.load("a.vert"), files.load("a.frag")]


def elsewhere(folder: Path) -> list[Source]:
    (folder / "other").mkdir(exist_ok=True)
    files = shaders(folder / "other")
    return [files.load("a.vert"), files.load("a.frag")]


def named_otherwise(folder: Path) -> list[Source]:
    files = shaders(folder, **{"b.frag": FRAGMENT})
    return [files.load("a.vert"), files.load("b.frag")]


def on_other_lines(folder: Path) -> list[Source]:
    vertex, fragment = changed(lambda texts: None)(folder)
    rows = fragment.lines.with_inserted(0, 1, (fragment.path, 1))
    return [vertex, dataclasses.replace(fragment, lines=rows)]


CHANGES = {
    "a space in a shader": in_place_of("a.vert", "uv = place.xy;", "uv =  place.xy;"),
    "a comment": in_place_of("a.frag", "in vec2 uv;", "in vec2 uv; // from 0 to 1"),
    "the version": in_place_of("a.frag", "330", "410"),
    "an included file": in_place_of("light.glsl", "0.0", "0.5"),
    "a define": defined,
    "the folder": elsewhere,
    "a name": named_otherwise,
    "the line map": on_other_lines,
    "fewer stages": lambda folder: changed(lambda texts: None)(folder)[1:],
}


@pytest.mark.parametrize("change", CHANGES)
def test_whatever_changes_is_compiled_anew(
    tmp_path: Path, keeper: Keeper, asked: list[Sequence[Source]], change: str
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    keeper.compile(stages, TARGETS)
    keeper.compile(list(reversed(stages)), TARGETS)  # the order is no part of it
    assert len(asked) == 1
    other = CHANGES[change](tmp_path)
    assert told(keeper.compile(other, TARGETS)) == told(compile_program(other, TARGETS))
    assert len(asked) == 2


@pytest.mark.parametrize("targets", [TARGETS[:2], TARGETS[::-1], ALL_TARGETS])
def test_other_targets_are_compiled_anew(
    tmp_path: Path, keeper: Keeper, asked: list[Sequence[Source]], targets: Sequence[str]
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    keeper.compile(stages, TARGETS)
    assert told(keeper.compile(stages, targets)) == told(compile_program(stages, targets))
    assert len(asked) == 2


def test_the_stage_is_a_part_of_the_key() -> None:
    code = "#version 330 core\nvoid main() {}"
    keys = {key_of([text(code, s)], TARGETS, FINGERPRINT) for s in ("vertex", "fragment")}
    assert len(keys) == 2


def test_other_compilers_are_asked_anew(
    tmp_path: Path, store: Store, asked: list[Sequence[Source]]
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    for name in ("these", "others", "these"):
        Keeper(store, functools.partial(str, name)).compile(stages, TARGETS)
    assert len(asked) == 2


def test_a_verdict_does_not_outlive_its_shader(tmp_path: Path, keeper: Keeper) -> None:
    wrong = in_place_of("a.frag", "* weights[1]", "* wieghts[1]")
    wrong_include = in_place_of("light.glsl", "normal.z", "normals.z")
    for _ in range(2):
        assert keeper.compile(changed(lambda texts: None)(tmp_path), TARGETS).ok
        for load, file, line in ((wrong, "a.frag", 10), (wrong_include, "light.glsl", 1)):
            with pytest.raises(ShaderError) as refused:
                keeper.compile(load(tmp_path), TARGETS).require()
            assert (refused.value.file, refused.value.line) == (str(tmp_path / file), line)


def test_a_refusal_does_not_outlive_its_mistake(tmp_path: Path, keeper: Keeper) -> None:
    wrong = in_place_of("a.frag", "* weights[1]", "* wieghts[1]")
    for _ in range(2):
        assert not keeper.compile(wrong(tmp_path), TARGETS).ok
        assert keeper.compile(changed(lambda texts: None)(tmp_path), TARGETS).ok


def every_file(store: Store) -> list[Path]:
    return sorted(store.folder.glob("?/*"))


class Bomb:
    """What runs something when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, ("bombed",)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no package",
        zlib.compress(b""),
        zlib.compress((2).to_bytes(8, "little") + b"{}"),
        zlib.compress((2).to_bytes(8, "little") + b"[]"),
        zlib.compress((10**9).to_bytes(8, "little") + b"[" * 10**6),
        zlib.compress(b"\xff" * 100),
        zlib.compress(b"\0" * (65 << 20)),
        pickle.dumps(Bomb()),
        zlib.compress(pickle.dumps(Bomb())),
    ],
)
def test_an_entry_that_is_no_program_is_compiled_anew(
    tmp_path: Path, store: Store, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    stages = changed(lambda texts: None)(tmp_path)
    store.put(key_of(stages, TARGETS, FINGERPRINT), content)
    keeper = Keeper(store, lambda: FINGERPRINT)
    assert told(keeper.compile(stages, TARGETS)) == told(compile_program(stages, TARGETS))
    assert store.get(key_of(stages, TARGETS, FINGERPRINT)) != content
    assert not (tmp_path / "bombed").exists()


def package_of(compiled: Compiled) -> Package:
    return Package(compiled.verdicts, compiled.spirv, compiled.logs, compiled.interface)


def test_packages_that_were_tampered_with_are_packages_or_value_errors(tmp_path: Path) -> None:
    stages, targets = programs(tmp_path)["two stages"]
    whole = zlib.decompress(packed(package_of(compile_program(stages, targets))))
    chance = random.Random(7)
    refused = 0
    for _ in range(1500):
        at, length = chance.randrange(len(whole)), chance.choice([0, 1, 1, 2, 40])
        bad = whole[:at] + chance.randbytes(chance.choice([0, 1, 3])) + whole[at + length :]
        try:
            assert isinstance(unpacked(zlib.compress(bad, 1)), Package)
        except ValueError:
            refused += 1
    assert refused > 300


def test_the_cache_is_no_condition(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    keeper = Keeper(Store(tmp_path / "file"), lambda: FINGERPRINT)
    stages = changed(lambda texts: None)(tmp_path)
    for _ in range(2):
        assert told(keeper.compile(stages, TARGETS)) == told(compile_program(stages, TARGETS))


def test_wrong_calls_raise_as_ever_and_keep_nothing(store: Store, keeper: Keeper) -> None:
    with pytest.raises(ShaderError, match="no such compile target: 'vulcan'"):
        keeper.compile([text(WARNED)], ["vulcan"])
    with pytest.raises(ShaderError, match="at least one stage"):
        keeper.compile([], TARGETS)
    assert not every_file(store)


def test_what_took_the_compiler_down_or_too_long_is_not_kept(
    store: Store, keeper: Keeper, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dies(*_: object, **__: object) -> Compiled:
        raise CompilerDiedError("timeout", "glslang took longer than 10 s")

    with monkeypatch.context() as patch:
        patch.setattr(kept, "compile_program", dies)
        with pytest.raises(CompilerDiedError):
            keeper.compile([text(WARNED)], TARGETS)
    assert not every_file(store)
    assert keeper.compile([text(WARNED)], TARGETS).ok


def test_commands_are_asked_each_time(
    store: Store, keeper: Keeper, asked: list[Sequence[Source]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHADERLAB_GLSLANG", "glslangValidator-of-somebody")
    for _ in range(2):
        with pytest.raises(ShaderError, match="SHADERLAB_GLSLANG names no program"):
            keeper.compile([text(WARNED)], TARGETS)
    assert len(asked) == 2
    assert not every_file(store)


def test_commands_in_the_libraries_place_leave_nothing(
    store: Store, keeper: Keeper, monkeypatch: pytest.MonkeyPatch
) -> None:
    engine = type("Engine", (), {"name": "process"})()
    monkeypatch.setattr(kept, "choose", lambda: engine)
    monkeypatch.setattr(
        kept, "compile_program", lambda stages, targets, engine: compile_program(stages, targets)
    )
    assert keeper.compile([text(WARNED)], TARGETS).ok
    assert not every_file(store)


def test_compilers_that_cannot_be_told_apart_keep_nothing(
    store: Store, asked: list[Sequence[Source]]
) -> None:
    keeper = Keeper(store, lambda: None)
    for _ in range(2):
        assert keeper.compile([text(WARNED)], TARGETS).ok
    assert len(asked) == 2
    assert not every_file(store)
