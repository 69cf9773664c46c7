"""What the API itself says: errors and answers by exact code, in a context where nothing is set."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import Case, Draw, Pass, State, Target, Texture, exact, gl_call
from shaderlab.engine.expectations.gl_call import Location, Object, Program, call
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CaseError
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.model.scene import UNIT_SQUARE

TEXTURED = """#version 330 core
in vec2 TexCoords;
uniform sampler2D BaseMap;
uniform float unused;
out vec4 FragColor;
void main() { FragColor = texture(BaseMap, TexCoords); }
"""
WHITE = Texture(image=np.ones((1, 1, 4)))
TEXTURE, FRAMEBUFFER = Object("texture"), Object("framebuffer")
BIND = call("glBindTexture", "GL_TEXTURE_2D", TEXTURE)
IMAGE = call("glTexImage2D", "GL_TEXTURE_2D", 0, "GL_RGBA8", 8, 8, 0, "GL_RGBA",
             "GL_UNSIGNED_BYTE", None)  # fmt: skip
ATTACH = call("glFramebufferTexture2D", "GL_FRAMEBUFFER", "GL_COLOR_ATTACHMENT0",
              "GL_TEXTURE_2D", TEXTURE, 0)  # fmt: skip
FRAME = call("glBindFramebuffer", "GL_FRAMEBUFFER", FRAMEBUFFER)
BUFFER = call("glBindBuffer", "GL_ARRAY_BUFFER", Object("buffer"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    (made / "textured.frag").write_text(TEXTURED)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=4)) as made:
        yield made


def case(folder: Path, *expect: Any) -> Case:
    draw = Draw(
        fragment="textured.frag",
        domain=UNIT_SQUARE,
        uniforms={"unused": 0.0},
        textures={"BaseMap": WHITE},
        state=State(viewport=(1, 1, 2, 2)),
    )
    passes = (Pass(target=Target(size=(4, 4)), draws=(draw,)),)
    return Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)


def run(lab: SceneRunner, folder: Path, *expect: Any) -> Record:
    return lab.run(case(folder, *expect).scene("default"))


RIGHT = [
    gl_call("glTexParameteri", "GL_TEXTURE_2D", "GL_TEXTURE_MAG_FILTER",
            "GL_LINEAR_MIPMAP_LINEAR", raises="invalid_enum", before=(BIND,)),
    gl_call("glGetTexParameteriv", "GL_TEXTURE_2D", "GL_TEXTURE_MIN_FILTER",
            returns="GL_NEAREST_MIPMAP_LINEAR", before=(BIND,)),
    gl_call("glGetTexParameteriv", "GL_TEXTURE_2D", "GL_TEXTURE_MIN_FILTER", returns=0x2702),
    gl_call("glUniform1i", Location("BaseMap"), "GL_TEXTURE0", raises="invalid_value"),
    gl_call("glUniform1ui", Location("BaseMap"), 0, raises="invalid_operation"),
    gl_call("glUniform1i", Location("BaseMap"), 2),
    gl_call("glGetUniformiv", Program(), Location("BaseMap"), returns=2,
            before=(call("glUniform1i", Location("BaseMap"), 2),)),
    gl_call("glGetUniformLocation", Program(), "unused", returns=-1),
    gl_call("glGetUniformIndices", Program(), 1, ("BassMap",),
            returns="GL_INVALID_INDEX"),
    gl_call("glMapBuffer", "GL_ARRAY_BUFFER", "GL_WRITE_ONLY", raises="invalid_operation"),
    gl_call("glGetBufferParameteriv", "GL_ARRAY_BUFFER", "GL_BUFFER_SIZE", returns=8,
            before=(BUFFER, call("glBufferData", "GL_ARRAY_BUFFER", 8, b"12345678",
                                 "GL_STATIC_DRAW"))),
    gl_call("glVertexAttribPointer", 0, 3, "GL_FLOAT", "GL_FALSE", 32, 12,
            before=(call("glBindVertexArray", Object("vertex_array")), BUFFER)),
    gl_call("glCheckFramebufferStatus", "GL_FRAMEBUFFER", returns="GL_FRAMEBUFFER_COMPLETE",
            before=(FRAME, BIND, IMAGE, ATTACH)),
    gl_call("glCheckFramebufferStatus", "GL_FRAMEBUFFER",
            returns="GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT", before=(FRAME, BIND, ATTACH)),
    gl_call("glCheckFramebufferStatus", "GL_FRAMEBUFFER",
            returns="GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT", before=(FRAME,)),
    gl_call("glGetFloatv", "GL_COLOR_CLEAR_VALUE", returns=(0.25, 0.5, 0.75, 1.0),
            before=(call("glClearColor", 0.25, 0.5, 0.75, 1.0),)),
    gl_call("glTexParameterfv", "GL_TEXTURE_2D", "GL_TEXTURE_BORDER_COLOR", (1, 0, 0, 1)),
    gl_call("glGetIntegerv", "GL_MAX_DRAW_BUFFERS", at_least=8),
]  # fmt: skip


def test_calls_raise_and_answer_what_the_specification_says(lab: SceneRunner, folder: Path) -> None:
    record = run(lab, folder, *RIGHT)
    assert record.status == "pass", [o for o in record.expectations if o.status != "pass"]
    rows = record.expectations[0].rows
    assert rows[0].expected == rows[0].measured == "GL_INVALID_ENUM (0x0500)"
    assert record.expectations[1].rows[1].measured == "GL_NEAREST_MIPMAP_LINEAR (0x2702)"


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (gl_call("glEnable", "GL_TEXTURE_2D"), "GL_INVALID_ENUM (0x0500)"),
        (gl_call("glEnable", "GL_BLEND", raises="invalid_enum"), "GL_NO_ERROR (0x0000)"),
        (gl_call("glUniform1i", Location("BaseMap"), "GL_TEXTURE0", raises="invalid_enum"),
         "GL_INVALID_VALUE (0x0501)"),
        (gl_call("glGetTexParameteriv", "GL_TEXTURE_2D", "GL_TEXTURE_MIN_FILTER",
                 returns="GL_NEAREST"), "GL_NEAREST_MIPMAP_LINEAR (0x2702)"),
        (gl_call("glCheckFramebufferStatus", "GL_FRAMEBUFFER", before=(FRAME,),
                 returns="GL_FRAMEBUFFER_COMPLETE"),
         "GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT (0x8CD7)"),
        (gl_call("glIsEnabled", "GL_BLEND", returns=1), "answers 0"),
        (gl_call("glIsEnabled", "GL_BLEND", returns=0,
                 before=(call("glEnable", "GL_TEXTURE_2D"),)), "glEnable(GL_TEXTURE_2D) raises"),
        (gl_call("glEnable", "GL_BLEND", returns=0), "answers nothing"),
        (gl_call("glEnable", "GL_BLEND", at_least=0), "answers nothing"),
        (gl_call("glIsEnabled", "GL_BLEND", at_least=1), "answers 0"),
    ],
)  # fmt: skip
def test_another_error_or_answer_fails(
    lab: SceneRunner, folder: Path, wrong: Any, says: str
) -> None:
    record = run(lab, folder, wrong)
    assert record.status == "fail"
    assert says in record.expectations[0].message


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (gl_call("glTexParametri", 0, 0, 0), "glTexParameteri"),
        (gl_call("glEnable", "GL_DEPTH_TES"), "GL_DEPTH_TEST"),
        (gl_call("glEnable"), "glEnable(cap)"),
        (gl_call("glEnable", (1, 2)), "no array is taken"),
        (gl_call("glUniform1i", Location("BaseMap", Program("man")), 0), "'man'"),
        (gl_call("glIsEnabled", "GL_BLEND", returns="GL_FALS"), "GL_FALSE"),
    ],
)
def test_what_is_no_call_names_the_nearest(
    lab: SceneRunner, folder: Path, wrong: Any, says: str
) -> None:
    record = run(lab, folder, wrong)
    assert record.status == "error"
    assert says in record.message


def test_calls_are_refused_where_they_are_written() -> None:
    for make in (
        lambda: gl_call("texParameteri"),
        lambda: gl_call("glIsEnabled", "GL_BLEND", returns=0, at_least=0),
        lambda: gl_call("glEnable", raises="invalid_enums"),
        lambda: gl_call("glIsEnabled", "GL_BLEND", raises="invalid_enum", returns=0),
        lambda: Object("textur"),
    ):
        with pytest.raises(CaseError):
            make()


def test_a_call_leaves_nothing_behind_and_finds_nothing_set(lab: SceneRunner, folder: Path) -> None:
    """Neither the draws' state reaches a call, nor a call the next draws, nor one call another."""
    picture = [[0, 0, 0, 0], [0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]]
    enable = gl_call("glEnable", "GL_SCISSOR_TEST")
    still = gl_call("glIsEnabled", "GL_SCISSOR_TEST", returns=0)
    unset = gl_call("glGetIntegerv", "GL_CURRENT_PROGRAM", returns=0)
    for _ in range(2):
        record = run(lab, folder, enable, still, unset, exact("FragColor", picture))
        assert record.status == "pass", record


def test_mutation_judges_only_calls_that_name_a_program(folder: Path) -> None:
    of_program = gl_call("glGetUniformLocation", Program(), "unused", returns=-1)
    of_nothing = gl_call("glIsEnabled", "GL_BLEND", returns=1)
    scene = case(folder, of_program, of_nothing).scene("default")
    assert [e.passes(scene) for e in scene.expect] == [{"main"}, set()]
    with SceneRunner(RunOptions(size=4)) as lab:
        for use, status in (("", "pass"), (" + unused", "fail")):
            text = TEXTURED.replace("TexCoords);", f"TexCoords){use};")
            programs = lab.prepare_for_opengl(scene, {"textured.frag": text})
            with lab.evaluation(scene, programs) as evaluation:
                assert evaluation.judge(scene.expect[0]).outcome.status == status
