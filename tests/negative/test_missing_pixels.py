"""Pixels that a shader leaves out, in shipped cases: each must fail."""

from __future__ import annotations

import re

import pytest

from shaderlab.engine.catalogue import data_folder
from tests.catalogue import shipped
from tests.negative.broken import failures, mistaken

CHESS = "if (((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 1) discard;"
# case, shader, what comes behind its main
LEFT_OUT = [
    ("attenuation", "ch05_lighting/attenuation.frag", CHESS),
    ("attenuation", "ch05_lighting/attenuation.frag", "if (factor > 0.25) discard;"),
    ("alpha-discard", "ch06_tests/alpha_discard.frag", CHESS),
    ("alpha-discard", "ch06_tests/leaf.frag", "if (FragColor.x > 0.25) discard;"),
    ("transparency-order", "ch06_tests/glass.frag", CHESS),
    ("double-buffer", "ch11_window/double_buffer_ball.frag", CHESS),
    ("point-shadow", "ch05_lighting/point_shadow_depth.frag",
     "if (gl_FragDepth > 0.25) gl_FragDepth = 1.0;"),
]  # fmt: skip


@pytest.mark.parametrize(("case_id", "shader", "ending"), LEFT_OUT)
def test_pixels_that_are_left_out_make_a_case_fail(case_id: str, shader: str, ending: str) -> None:
    text = (data_folder("shaders") / shader).read_text(encoding="utf-8")
    text, renamed = re.subn(r"\bvoid main\(", "void whole(", text)
    assert renamed == 1
    text += f"\nvoid main() {{ whole(); {ending} }}\n"
    found = failures(next(shipped()[case_id].scenes()), {shader: text})
    assert any("missing: " in outcome.message for outcome in found)


def test_a_shader_that_discards_nothing_any_more_is_caught() -> None:
    shader = "ch06_tests/alpha_discard.frag"
    found = failures(next(shipped()["alpha-discard"].scenes()), mistaken(shader, "discard;", ""))
    assert any("surplus: " in outcome.message for outcome in found)
