"""NumPy's masked values are no numbers: wherever a case gives one, it is refused by its name."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Draw,
    Mesh,
    Texture,
    TextureArray,
    UniformBuffer,
    across,
    bounded,
    compute,
    computed,
    even,
    exact,
    formula,
    fullscreen,
    glsl,
    measure,
    up,
    value,
)
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import CallError, CaseError, FormulaError
from shaderlab.model.options import RunOptions

ONE: Any = np.ma.masked
SOME: Any = np.ma.array(np.ones((4, 4, 4)), mask=np.eye(4)[:, :, None] * np.ones(4))
SHADER = """#version 330 core
uniform sampler2D map;
out vec4 color;
void main() { color = 0.25 * texelFetch(map, ivec2(gl_FragCoord.xy) & 3, 0); }
"""

GIVEN: dict[str, Callable[[], object]] = {
    "uniforms['x']": lambda: Draw(fragment="f", domain={}, uniforms={"x": ONE}),
    "uniforms['light']['color'][1]": lambda: fullscreen(
        "f", uniforms={"light": {"color": [1.0, ONE]}}
    ),
    "uniforms['lights'][70]['at']": lambda: fullscreen(
        "f", uniforms={"lights": [*[{"at": 0.0}] * 70, {"at": SOME}]}
    ),
    "values['x']": lambda: UniformBuffer(values={"x": SOME}),
    "buffers['x']": lambda: compute("c", groups=(1, 1, 1), buffers={"x": SOME}),
    "images['x']": lambda: compute("c", groups=(1, 1, 1), images={"x": SOME}),
    "across['stop']": lambda: across(0.0, ONE),
    "up['start']": lambda: up(ONE, 1.0),
    "attributes['p']": lambda: Mesh(attributes={"p": SOME[0]}),
    "indices": lambda: Mesh(
        attributes={"p": np.zeros((3, 2))}, indices=np.ma.array([0, 1, 2], mask=[0, 0, 1])
    ),
    "image": lambda: Texture(image=SOME),
    "layers[1]": lambda: TextureArray(layers=[np.ones((4, 4, 4)), SOME]),
    "equals": lambda: exact("color", SOME),
    "equals[1]": lambda: exact("color", [1.0, ONE]),
    "at['x']": lambda: value("color", at={"x": ONE}, equals=1.0, digits=2),
    "value: equals": lambda: value("color", at={"x": 1.0}, equals=ONE, digits=2),
    "computed: equals": lambda: computed("n", lambda: 1.0, equals=ONE, digits=2),
    "values": lambda: even("color", over="x", values=SOME[0, 0]),
    "high": lambda: bounded("color", 0, ONE, over="x", values=[1.0, 2.0]),
    "at_most": lambda: measure("m", lambda color: color.max(), at_most=ONE),
}


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=8)) as made:
        yield made


@pytest.mark.parametrize("place", GIVEN)
def test_what_a_case_gives(place: str) -> None:
    with pytest.raises(CaseError) as caught:
        GIVEN[place]()
    assert f"{place} holds a masked value" in str(caught.value) or (
        f"{place} is masked; expected float" in str(caught.value)
    )


def test_an_array_that_masks_nothing_is_numbers() -> None:
    assert Mesh(attributes={"p": np.ma.array(np.zeros((3, 2)))}).vertices == 3
    fullscreen("f", uniforms={"x": np.ma.array([1.0, 2.0])})


@pytest.mark.parametrize(
    ("expectation", "image", "said"),
    [
        (exact("color", 0.25), lambda: SOME, "Texture holds a masked value"),
        (formula("color", lambda: SOME[0, 0]), None, "gives masked values"),
        (formula("color", lambda: 0.25 + 0.0 * ONE), None, "gives masked values"),
        (measure("mean", lambda color: np.ma.masked_less(color, 9.0).mean(), at_most=1.0), None,
         "not one number"),
        (computed("mean", lambda: ONE, equals=0.0, digits=2), None, "holds a masked value"),
    ],
)  # fmt: skip
def test_what_functions_of_a_case_return(
    lab: SceneRunner, tmp_path: Path, expectation: Any, image: Any, said: str
) -> None:
    (tmp_path / "s.frag").write_text(SHADER)
    passes = fullscreen(
        "s.frag", textures={"map": Texture(image=np.ones((4, 4, 4)) if image is None else image)}
    )
    case = Case(
        id="masked", title="Masked", file=str(tmp_path / "masked.py"), passes=passes,
        expect=[expectation],
    )  # fmt: skip
    record = lab.run(case.scene("default"))
    messages = [record.message, *(outcome.message for outcome in record.expectations)]
    assert record.status != "pass" and any(said in message for message in messages), messages


def test_arguments_and_references_of_a_function() -> None:
    twice = glsl.load("float twice(float x) { return 2.0 * x; }").twice
    some = np.ma.array([1.0, 2.0], mask=[0, 1])
    for given in (ONE, some):
        with pytest.raises(CallError, match="x holds a masked value"):
            twice(given)
    with pytest.raises(FormulaError, match=r"gives masked values|a masked value is no number"):
        twice.check(lambda x: x + some, np.array([1.0, 2.0]))
