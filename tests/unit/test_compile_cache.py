"""Cached programs: the same result as compiling, and only while nothing it is made of changes."""

import dataclasses
import functools
import os
import pickle
import random
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from shaderlab.compiler import Shaders, Source, compile_cache
from shaderlab.compiler.compile import Compiled, compile_program
from shaderlab.compiler.compile_cache import CompileCache, Store, decode, encode, program_key
from shaderlab.compiler.glslang import ALL_TARGETS, TARGETS
from shaderlab.compiler.sources import LineMap
from shaderlab.errors import ShaderError

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
def cache(store: Store) -> CompileCache:
    return CompileCache(store, lambda: FINGERPRINT)


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[Sequence[Source]]:
    """The programs that were compiled and not found in the cache."""
    log: list[Sequence[Source]] = []

    def counted(stages: Sequence[Source], targets: Sequence[str], **more: object) -> Compiled:
        log.append(stages)
        return compile_program(stages, targets, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(compile_cache, "compile_program", counted)
    return log


def whole(result: Compiled) -> str:
    """All of a result, including types and order."""
    return repr((result, result.sources, result.interface))


def test_a_module_with_lines_is_compiled_once(
    tmp_path: Path, cache: CompileCache, compiled: list[Sequence[Source]]
) -> None:
    fragment = shaders(tmp_path).load("a.frag")
    first = cache.compile_with_lines(fragment)
    assert len(compiled) == 1
    again = cache.compile_with_lines(fragment)
    assert len(compiled) == 1 and whole(again) == whole(first)
    assert first.spirv["opengl"] != cache.compile([fragment], ("opengl",)).spirv["opengl"]
    assert not cache.compile_with_lines(text(WRONG)).spirv
    modern = text(
        "#version 450 core\nlayout (set = 1, binding = 0) uniform U { vec4 c; };\n"
        "layout (location = 0) out vec4 o; void main() { o = c; }"
    )
    assert list(cache.compile_with_lines(modern).spirv) == ["vulkan"]


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
def test_a_cached_result_equals_the_compiled_one(
    tmp_path: Path, cache: CompileCache, compiled: list[Sequence[Source]], name: str
) -> None:
    stages, targets = programs(tmp_path)[name]
    true = compile_program(stages, targets)
    first, again = cache.compile(stages, targets), cache.compile(stages, targets)
    assert len(compiled) == 1
    for field in dataclasses.fields(Compiled):
        if field.compare:
            assert getattr(again, field.name) == getattr(true, field.name), field.name
    assert whole(first) == whole(again) == whole(true)
    assert again.ok == KINDS[name]
    assert any(v.diagnostics for v in again.verdicts) or name in (
        "one stage", "plain", "compute", "two stages",
    )  # fmt: skip


def test_another_process_finds_it_without_a_compiler(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    stages, targets = programs(tmp_path)["two stages"]
    true = CompileCache(store, lambda: FINGERPRINT).compile(stages, targets)

    def loaded() -> None:
        raise AssertionError("the compiler's libraries were loaded")

    monkeypatch.setattr("shaderlab.compiler.glslang.load_glslang", loaded)
    monkeypatch.setattr("shaderlab.compiler.glslang.load_spirv_tools", loaded)
    again = CompileCache(Store(store.folder), lambda: FINGERPRINT).compile(stages, targets)
    assert whole(again) == whole(true)


def test_a_cached_plain_verdict_still_has_an_interface(
    tmp_path: Path, cache: CompileCache, compiled: list[Sequence[Source]]
) -> None:
    stages, targets = programs(tmp_path)["plain"]
    cache.compile(stages, targets)
    for _ in range(2):
        interface = cache.compile(stages, targets).interface
        assert interface is not None and set(interface.attributes) == {"place"}
    assert len(compiled) == 2  # once as plain GLSL, once for OpenGL


def changed(of: Callable[[dict[str, str]], None]) -> Callable[[Path], list[Source]]:
    def load(folder: Path) -> list[Source]:
        texts = {"a.vert": VERTEX, "a.frag": FRAGMENT, "light.glsl": LIGHT}
        of(texts)
        files = shaders(folder, **texts)
        return [files.load("a.vert"), files.load("a.frag")]

    return load


def replacing(name: str, old: str, new: str) -> Callable[[Path], list[Source]]:
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
    lines = LineMap.of([(fragment.path, 1, 1), *fragment.lines.spans])
    return [vertex, dataclasses.replace(fragment, lines=lines)]


CHANGES = {
    "a space in a shader": replacing("a.vert", "uv = place.xy;", "uv =  place.xy;"),
    "a comment": replacing("a.frag", "in vec2 uv;", "in vec2 uv; // from 0 to 1"),
    "the version": replacing("a.frag", "330", "410"),
    "an included file": replacing("light.glsl", "0.0", "0.5"),
    "a define": defined,
    "the folder": elsewhere,
    "a name": named_otherwise,
    "the line map": on_other_lines,
    "fewer stages": lambda folder: changed(lambda texts: None)(folder)[1:],
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_is_a_cache_miss(
    tmp_path: Path, cache: CompileCache, compiled: list[Sequence[Source]], change: str
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    cache.compile(stages, TARGETS)
    cache.compile(list(reversed(stages)), TARGETS)  # their order is not part of the key
    assert len(compiled) == 1
    other = CHANGES[change](tmp_path)
    assert whole(cache.compile(other, TARGETS)) == whole(compile_program(other, TARGETS))
    assert len(compiled) == 2


@pytest.mark.parametrize("targets", [TARGETS[:2], TARGETS[::-1], ALL_TARGETS])
def test_other_targets_are_a_cache_miss(
    tmp_path: Path, cache: CompileCache, compiled: list[Sequence[Source]], targets: Sequence[str]
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    cache.compile(stages, TARGETS)
    assert whole(cache.compile(stages, targets)) == whole(compile_program(stages, targets))
    assert len(compiled) == 2


def test_the_stage_is_part_of_the_key() -> None:
    code = "#version 330 core\nvoid main() {}"
    keys = {program_key([text(code, s)], TARGETS, FINGERPRINT) for s in ("vertex", "fragment")}
    assert len(keys) == 2


def test_other_compilers_are_a_cache_miss(
    tmp_path: Path, store: Store, compiled: list[Sequence[Source]]
) -> None:
    stages = changed(lambda texts: None)(tmp_path)
    for name in ("these", "others", "these"):
        CompileCache(store, functools.partial(str, name)).compile(stages, TARGETS)
    assert len(compiled) == 2


def test_an_accepted_shader_is_refused_once_it_is_wrong(
    tmp_path: Path, cache: CompileCache
) -> None:
    wrong = replacing("a.frag", "* weights[1]", "* wieghts[1]")
    wrong_include = replacing("light.glsl", "normal.z", "normals.z")
    for _ in range(2):
        assert cache.compile(changed(lambda texts: None)(tmp_path), TARGETS).ok
        for load, file, line in ((wrong, "a.frag", 10), (wrong_include, "light.glsl", 1)):
            with pytest.raises(ShaderError) as refused:
                cache.compile(load(tmp_path), TARGETS).require()
            assert (refused.value.file, refused.value.line) == (str(tmp_path / file), line)


def test_a_refused_shader_is_accepted_once_it_is_right(tmp_path: Path, cache: CompileCache) -> None:
    wrong = replacing("a.frag", "* weights[1]", "* wieghts[1]")
    for _ in range(2):
        assert not cache.compile(wrong(tmp_path), TARGETS).ok
        assert cache.compile(changed(lambda texts: None)(tmp_path), TARGETS).ok


def every_file(store: Store) -> list[Path]:
    return sorted(store.folder.glob("?/*"))


class Bomb:
    """Runs something when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, ("bombed",)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no entry",
        zlib.compress(b""),
        zlib.compress(b"{}"),
        zlib.compress(b"[]"),
        zlib.compress(b'{"verdicts": [{"target": "glsl"}]}'),
        zlib.compress(b"[" * 10**6),
        zlib.compress(b"\xff" * 100),
        zlib.compress(b"\0" * (65 << 20)),
        pickle.dumps(Bomb()),
        zlib.compress(pickle.dumps(Bomb())),
    ],
)
def test_an_entry_that_is_not_a_program_is_a_cache_miss(
    tmp_path: Path, store: Store, content: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    stages = changed(lambda texts: None)(tmp_path)
    store.put(program_key(stages, TARGETS, FINGERPRINT), content)
    cache = CompileCache(store, lambda: FINGERPRINT)
    assert whole(cache.compile(stages, TARGETS)) == whole(compile_program(stages, TARGETS))
    assert store.get(program_key(stages, TARGETS, FINGERPRINT)) != content
    assert not (tmp_path / "bombed").exists()


def test_an_entry_that_was_tampered_with_is_an_entry_or_a_value_error(tmp_path: Path) -> None:
    stages, targets = programs(tmp_path)["two stages"]
    data = zlib.decompress(encode(compile_program(stages, targets)))
    chance = random.Random(7)
    refused = 0
    for _ in range(1500):
        at, length = chance.randrange(len(data)), chance.choice([0, 1, 1, 2, 40])
        bad = data[:at] + chance.randbytes(chance.choice([0, 1, 3])) + data[at + length :]
        try:
            assert isinstance(decode(zlib.compress(bad, 1)), Compiled)
        except ValueError:
            refused += 1
    assert refused > 300


def test_without_a_usable_folder_programs_are_compiled_each_time(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    cache = CompileCache(Store(tmp_path / "file"), lambda: FINGERPRINT)
    stages = changed(lambda texts: None)(tmp_path)
    for _ in range(2):
        assert whole(cache.compile(stages, TARGETS)) == whole(compile_program(stages, TARGETS))


def test_wrong_calls_raise_as_without_a_cache_and_store_nothing(
    store: Store, cache: CompileCache
) -> None:
    with pytest.raises(ShaderError, match="no such compile target: 'vulcan'"):
        cache.compile([text(WARNED)], ["vulcan"])
    with pytest.raises(ShaderError, match="at least one stage"):
        cache.compile([], TARGETS)
    assert not every_file(store)


def test_without_a_digest_of_the_compilers_nothing_is_cached(
    store: Store, compiled: list[Sequence[Source]]
) -> None:
    cache = CompileCache(store, lambda: None)
    for _ in range(2):
        assert cache.compile([text(WARNED)], TARGETS).ok
    assert len(compiled) == 2
    assert not every_file(store)
