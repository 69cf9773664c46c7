"""Texts that crash glslang or SPIRV-Tools: a pool survives them without the lab's guards, and the
lab refuses them."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.glsl import WORK, compile_glsl
from shaderlab.workers import Limits, Pool

HEAD = "#version 450 core\nuniform float x;\nout vec4 c;\n"
KILLERS = {
    "twice": HEAD + "uniform vec3 a;\nuniform vec4 a;\nvoid main() { c = a; }\n",
    "sum": HEAD + "void main() { c = vec4(" + "+".join(["x"] * 100_000) + "); }\n",
    "ifs": HEAD + "void main() { c = vec4(x);\n" + "if (x > 0.0) {\n" * 1000 + "}" * 1001 + "\n",
}
GOOD = HEAD + "void main() { c = vec4(x); }\n"

# Calls the libraries without the lab's guards.
UNGUARDED = """
from shaderlab.glsl import Shaders
from shaderlab.glsl.engines import choose
from shaderlab.glsl.spirv_tools import validate

def work(texts):
    for text in texts:
        source = Shaders([]).from_text(text, "fragment", "killer.frag")
        linked = choose("library").link([source], "vulkan")
        yield [validate(module, "vulkan1.0") for module in linked.modules.values()]
"""

# A driver that dies on some files.
DEADLY = """
import os, time
from shaderlab.records import Verdict

def verdict(sources):
    if "crash" in sources[0].name:
        os.abort()
    if "hang" in sources[0].name:
        time.sleep(600)
    return Verdict(target="driver", ok=True)
"""


def test_a_pool_survives_each_killer_without_guards(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "unguarded.py").write_text(UNGUARDED)
    monkeypatch.syspath_prepend(str(tmp_path))
    texts = [GOOD, KILLERS["twice"], GOOD, KILLERS["sum"], KILLERS["ifs"], GOOD]
    with Pool("unguarded:work", limits=Limits(seconds=3.0)) as pool:
        outcomes = list(pool.each(texts))
    assert [o.status for o in outcomes] == ["done", "crash", "done", "crash", "timeout", "done"]
    assert [o.result for o in outcomes if o.status == "done"] == [[None]] * 3


def test_the_lab_refuses_each_killer_with_a_message(tmp_path: Path) -> None:
    for name, text in KILLERS.items():
        (tmp_path / f"{name}.frag").write_text(text)
    ifs, sum_, twice = compile_glsl([tmp_path])
    assert [result.ok for result in (ifs, sum_, twice)] == [False] * 3
    assert "nests deeper than 200" in ifs.verdicts[0].diagnostics[0].message
    assert "more than 5000 operators" in sum_.verdicts[0].diagnostics[0].message
    assert "redefinition" in twice.verdicts[2].diagnostics[0].message


def test_a_file_that_crashes_or_hangs_is_named_and_costs_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "deadly.py").write_text(DEADLY)
    monkeypatch.syspath_prepend(str(tmp_path))
    names = ["a", "b_crash", "c", "d_hang", "e"]
    for name in names:
        (tmp_path / f"{name}.frag").write_text(GOOD)
    with Pool(WORK, limits=Limits(seconds=2.0)) as pool:
        results = list(compile_glsl([tmp_path], driver="deadly:verdict", workers=pool))
    assert [Path(result.path).stem for result in results] == names
    assert [result.ok for result in results] == [True, False, True, False, True]
    for index, status, words in [(1, "crash", "SIGABRT"), (3, "timeout", "longer than 2 s")]:
        result = results[index]
        assert {verdict.status for verdict in result.verdicts} == {status}
        (said,) = result.verdicts[0].diagnostics
        assert said.file == result.path
        assert said.message.startswith(f"{status}: ") and words in said.message
    assert results[0].verdicts[3].target == "driver"
