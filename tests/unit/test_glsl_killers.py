"""Texts that crash glslang or SPIRV-Tools: a pool survives them without the lab's guards, and the
lab refuses them."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.harness import WORK
from shaderlab.model.options import Limits
from shaderlab.workers.pool import WorkerPool
from tests.compiling import compile_glsl

HEAD = "#version 450 core\nuniform float x;\nout vec4 c;\n"
KILLERS = {
    "twice": HEAD + "uniform vec3 a;\nuniform vec4 a;\nvoid main() { c = a; }\n",
    "sum": HEAD + "void main() { c = vec4(" + "+".join(["x"] * 100_000) + "); }\n",
    "ifs": HEAD + "void main() { c = vec4(x);\n" + "if (x > 0.0) {\n" * 1000 + "}" * 1001 + "\n",
}
GOOD = HEAD + "void main() { c = vec4(x); }\n"

# Calls the libraries without the lab's guards.
UNGUARDED = """
from shaderlab.compiler import Shaders
from shaderlab.compiler.glslang import link, validate

class Work:
    def __init__(self, channel):
        self.channel = channel

    def __call__(self, text):
        source = Shaders([]).from_text(text, "fragment", "killer.frag")
        if "if (" in text:  # takes minutes
            self.channel.restart_limit(1.0)
        linked = link([source], "vulkan")
        return [validate(module, "vulkan1.0") for module in linked.modules.values()]
"""

# A driver that dies on some files.
DEADLY = """
import os, signal, time
from shaderlab.errors import Verdict

def verdict(sources):
    if "crash" in sources[0].name:
        os.abort()
    if "hang" in sources[0].name:
        signal.setitimer(signal.ITIMER_REAL, 0.2)  # as the lab's own alarm does later
        time.sleep(600)
    return Verdict(target="driver", ok=True)
"""


def test_a_pool_survives_each_killer_without_guards(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "unguarded.py").write_text(UNGUARDED)
    monkeypatch.syspath_prepend(str(tmp_path))
    texts = [GOOD, KILLERS["twice"], GOOD, KILLERS["sum"], KILLERS["ifs"], GOOD]
    with WorkerPool("unguarded:Work", limits=Limits(seconds=120.0)) as pool:
        results = list(pool.run(texts))
    assert [r.status for r in results] == ["done", "crash", "done", "crash", "timeout", "done"]
    assert [r.value for r in results if r.status == "done"] == [[None]] * 3


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
    with WorkerPool(WORK, limits=Limits(seconds=60.0)) as pool:
        results = list(compile_glsl([tmp_path], driver="deadly:verdict", workers=pool))
    assert [Path(result.path).stem for result in results] == names
    assert [result.ok for result in results] == [True, False, True, False, True]
    for index, status, words in [(1, "crash", "SIGABRT"), (3, "timeout", "longer than 60 s")]:
        result = results[index]
        assert {verdict.status for verdict in result.verdicts} == {status}
        (said,) = result.verdicts[0].diagnostics
        assert said.file == result.path
        assert said.message.startswith(f"{status}: ") and words in said.message
    assert results[0].verdicts[3].target == "driver"


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("vec4 gl_Position;", "reserved"),
        ("void main() { c = gl_FragCoord; c[0] = gl_Layer;", "syntax"),
    ],
)
def test_a_built_in_is_refused_as_a_blocks_member_and_not_in_an_expression(
    member: str, message: str
) -> None:
    wrong = HEAD + "out vec3 {\n" + member + "\n}\n"
    source = Shaders([]).from_text(wrong, "fragment", "wrong.frag")
    said = compile_program([source], ["glsl"]).verdicts[0].diagnostics
    assert said and all(message in each.message for each in said)
