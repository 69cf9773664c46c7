"""Many files at once: found, sorted, compiled here and in workers, as data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from shaderlab.compiler import shader_files
from shaderlab.compiler.harness import WORK, FileResult
from shaderlab.compiler.shader_files import Roots, find_shaders
from shaderlab.errors import ShaderError, UsageError
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

GOOD = "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n"
BAD = GOOD.replace("1.0", "nothing")
VERTEX = (
    "#version 330 core\nin vec3 a;\nout vec3 n;\nvoid main() { n = a; gl_Position = a.xyzz; }\n"
)
FRAGMENT = "#version 330 core\nin vec3 n;\nout vec4 c;\nvoid main() { c = n.xyzz; }\n"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    root = tmp_path / "tree"
    files = {
        "b.frag": GOOD,
        "a/z.frag": BAD,
        "a/lib.glsl": "float half_of(float x) { return 0.5 * x; }\n",
        "a/m.vert.glsl": VERTEX,
        "c.glsl": "#pragma shader_stage(compute)\n#version 430\nvoid main() {}\n",
        "a/uses.fs": GOOD.replace("void", '#include "lib.glsl"\nvoid').replace("1.0", "half_of(1)"),
        ".git/x.frag": BAD,
        "notes.txt": "not a shader",
        "empty.geom": "",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


def compile_(*paths: Path, **options: Any) -> dict[str, FileResult]:
    found = {Path(result.path).name: result for result in compile_glsl(paths, **options)}
    assert found
    return found


def test_a_folder_is_searched_and_the_results_are_sorted(tree: Path) -> None:
    results = list(compile_glsl([tree]))
    names = [str(Path(result.path).relative_to(tree)) for result in results]
    assert names == ["a/m.vert.glsl", "a/uses.fs", "a/z.frag", "b.frag", "c.glsl", "empty.geom"]
    assert [result.stage for result in results] == [
        "vertex", "fragment", "fragment", "fragment", "compute", "geometry",
    ]  # fmt: skip
    assert [result.ok for result in results] == [True, True, False, True, False, False]
    by_name = {Path(result.path).name: result for result in results}
    assert "the shader is empty" in by_name["empty.geom"].verdicts[1].diagnostics[0].message
    assert "must occur first" in by_name["c.glsl"].verdicts[0].diagnostics[0].message


def test_a_pool_gives_the_same_results_as_this_process(tree: Path) -> None:
    here = list(compile_glsl([tree]))
    with WorkerPool(WORK, jobs=2) as pool:
        there = list(compile_glsl([tree], workers=pool))
    assert here == there


def test_counts_and_the_validators_verdict_are_in_the_result(tree: Path) -> None:
    verdicts = compile_(tree / "b.frag")["b.frag"].verdicts
    assert [v.target for v in verdicts] == ["glsl", "opengl", "vulkan"]
    assert [v.valid for v in verdicts] == [None, True, True]
    assert [v.instructions > 10 for v in verdicts] == [False, True, True]
    # An instruction has at least one word of four bytes, the header five.
    assert all(v.spirv_bytes >= 20 + 4 * v.instructions for v in verdicts[1:])


def test_files_can_be_the_stages_of_one_program(tree: Path) -> None:
    (tree / "p.vert").write_text(VERTEX)
    (tree / "p.frag").write_text(FRAGMENT)
    (both,) = compile_glsl([tree / "p.vert", tree / "p.frag"], link=True)
    assert both.ok and both.stage == "vertex + fragment"
    (tree / "p.frag").write_text(FRAGMENT.replace("vec3 n", "vec4 n"))
    (wrong,) = compile_glsl([tree / "p.vert", tree / "p.frag"], link=True)
    assert "Types must match" in wrong.verdicts[0].diagnostics[0].message


def test_stage_defines_includes_and_targets_take_effect(tree: Path, tmp_path: Path) -> None:
    (tree / "lamp.txt").write_text('#version 330 core\n#include "k.glsl"\nvoid main() { f(N); }\n')
    (tmp_path / "common").mkdir()
    (tmp_path / "common" / "k.glsl").write_text("void f(float x) {}\n")
    options: dict[str, Any] = {"stage": "vertex", "targets": ["opengl"]}
    assert not compile_(tree / "lamp.txt", **options)["lamp.txt"].ok
    options |= {"include": [tmp_path / "common"], "defines": {"N": "2.0"}}
    (verdict,) = compile_(tree / "lamp.txt", **options)["lamp.txt"].verdicts
    assert verdict.ok and verdict.target == "opengl"


def test_a_file_in_a_root_includes_from_there(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "k.glsl").write_text("const float k = 2.0;\n")
    (tmp_path / "deep" / "er").mkdir(parents=True)
    (tmp_path / "deep" / "er" / "a.frag").write_text("")
    (shader,) = find_shaders([tmp_path / "deep"], [tmp_path])
    assert (shader.root, shader.name) == (str(tmp_path), "deep/er/a.frag")
    (shader,) = find_shaders([tmp_path / "deep"])
    assert (shader.root, shader.name) == (str(tmp_path / "deep"), "er/a.frag")


def test_a_file_named_twice_is_compiled_once(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tree)
    found = find_shaders(["b.frag", tree / "b.frag", "./b.frag"])
    assert [shader.path for shader in found] == ["b.frag"]


def test_glsl_for_vulkan_reaches_the_vulkan_compiler(tmp_path: Path) -> None:
    text = GOOD.replace("out vec4 c;", "layout (constant_id = 0) const int n = 4;\nout vec4 c;")
    (tmp_path / "a.frag").write_text(text)
    (tmp_path / "b.vert").write_text(
        "#version 450\nvoid main() { gl_Position = vec4(gl_VertexIndex); }\n"
    )
    results = compile_(tmp_path, targets=["glsl", "vulkan-strict"])
    for result in results.values():
        assert [verdict.ok for verdict in result.verdicts] == [False, True], result


def test_a_missing_path_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such file or folder"):
        compile_glsl([tmp_path / "gone"])
    with pytest.raises(UsageError, match="no shader in this folder"):
        compile_glsl([tmp_path])


def test_a_misspelt_name_is_looked_for_near_the_top_of_a_large_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deep = tmp_path / "a" / "photographs"
    deep.mkdir(parents=True)
    for number in range(30):
        (deep / f"lamp_{number}.frag").write_text(GOOD)
    (tmp_path / "z").mkdir()
    (tmp_path / "z" / "lamp.frag").write_text(GOOD)
    looked_at = []

    def is_file(path: Path) -> bool:
        looked_at.append(path)
        return True

    monkeypatch.setattr(shader_files, "MOST_FILES", 10)
    monkeypatch.setattr(Path, "is_file", is_file)
    with pytest.raises(ShaderError, match=r"no shader 'lmp\.frag'") as caught:
        Roots([tmp_path], {}).shader("lmp.frag")
    assert caught.value.remedy == "did you mean z/lamp.frag?"
    assert len(looked_at) == 10
