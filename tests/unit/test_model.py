"""The case model: what is checked when a case is written down."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

from shaderlab import (
    Blend,
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Ramp,
    State,
    Stencil,
    Target,
    Texture,
    Variant,
    across,
    exact,
    formula,
    fullscreen,
    gl_error,
    up,
    value,
)
from shaderlab.errors import CaseError


def one(x: float) -> float:
    return x


PASSES = fullscreen("a.frag", domain={"x": across(0.0, 1.0)}, uniforms={"light.linear": 0.5})


def case(**changes: object) -> Case:
    return Case(**({"title": "t", "passes": PASSES, "expect": [formula("y", one)]} | changes))


@pytest.mark.parametrize(
    ("make", "wrong", "right"),
    [
        (lambda: Depth(func="lesss"), "'lesss'", "less"),
        (lambda: Stencil(depth_pass="increase"), "'increase'", "incr"),
        (lambda: Blend(source="src_alfa"), "'src_alfa'", "src_alpha"),
        (lambda: Blend(equation="subtact"), "'subtact'", "subtract"),
        (lambda: State(cull="backs"), "'backs'", "back"),
        (lambda: State(front_face="cww"), "'cww'", "cw"),
        (lambda: Target(colors={"c": "rgba8f"}), "'rgba8f'", "rgba8"),
        (lambda: Target(depth="depth23"), "'depth23'", "depth24"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), wrap=("repeat", "mirror")), "'mirror'", "mirr"),
        (lambda: Mesh(attributes={"a": np.zeros((3, 2))}, primitive="triangle"), "'triangle'", "s"),
        (lambda: gl_error("invalid_enums"), "'invalid_enums'", "invalid_enum"),
    ],
)
def test_misspelt_words_are_named_with_the_right_ones(make, wrong, right) -> None:
    with pytest.raises(CaseError, match=wrong) as caught:
        make()
    assert right in (caught.value.remedy or "")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Cell(column=3, row=0, columns=3, rows=1), "outside"),
        (lambda: Stencil(reference=256), "0…255"),
        (lambda: Target(size=(0, 4)), "size"),
        (lambda: Mesh(attributes={"a": np.zeros((3, 2)), "b": np.zeros((4, 2))}), "common number"),
        (lambda: Mesh(attributes={"a": np.zeros((3, 5))}), "1…4"),
        (lambda: Mesh(attributes={"a": np.array([["x"]])}), "numbers"),
        (lambda: Mesh(attributes={"a": np.array([[np.nan]])}), "NaN"),
        (lambda: Mesh(attributes={"a": np.zeros((3, 2))}, indices=np.array([0, 3])), "0 to 3"),
        (lambda: Draw(fragment="a.frag"), "either a mesh"),
        (lambda: Draw(fragment="a.frag", mesh=Mesh(attributes={"a": np.zeros(3)})), "vertex"),
        (lambda: Draw(fragment="a.frag", vertex="a.vert", domain={}), "over a domain"),
        (lambda: Variant(""), "no name"),
        (lambda: value("y", at={}, equals=1.0, digits=-1), "digits"),
        (lambda: formula("y", 3.0), "function"),  # type: ignore[arg-type]
        (lambda: case(expect=[]), "nothing could fail"),
        (lambda: case(passes=()), "no passes"),
        (lambda: case(passes=(*PASSES, *PASSES)), "two passes"),
        (lambda: case(variants=[Variant("a"), Variant("a")]), "two variants"),
    ],
)
def test_wrong_data_is_refused_where_it_is_written(make, says) -> None:
    with pytest.raises(CaseError, match=says):
        make()


def test_ramps_start_and_stop_where_they_say() -> None:
    assert across(2.0, 5.0) == Ramp(2.0, dx=3.0)
    assert up((0.0, 1.0), (1.0, 3.0)) == Ramp((0.0, 1.0), dy=[1.0, 2.0])


def test_only_keeps_the_named_attributes_and_names_a_wrong_one() -> None:
    mesh = Mesh(attributes={"aPos": np.zeros((3, 3)), "aNormal": np.zeros((3, 3))})
    assert list(mesh.only("aPos").attributes) == ["aPos"]
    with pytest.raises(CaseError, match="aNormals") as caught:
        mesh.only("aNormals")
    assert "aNormal" in (caught.value.remedy or "")


def test_a_variant_changes_uniforms_and_ramps_by_name() -> None:
    changes = {"light.linear": 0.7, "x": across(0.0, 9.0)}
    scene = case(variants=[Variant("v", changes, expect=[exact("y", 1.0)])]).scene("v")
    draw = scene.passes[0].draws[0]
    assert draw.uniforms == {"light.linear": 0.7}
    assert draw.domain == {"x": Ramp(0.0, dx=9.0)}
    assert len(scene.expect) == 2
    assert PASSES[0].draws[0].uniforms == {"light.linear": 0.5}


def test_a_variant_that_changes_nothing_known_is_an_error() -> None:
    with pytest.raises(CaseError, match=r"light\.liner") as caught:
        list(case(variants=[Variant("v", {"light.liner": 0.7})]).scenes())
    assert "light.linear" in (caught.value.remedy or "")


def test_an_unknown_variant_or_pass_is_named_with_the_nearest() -> None:
    scene = case(variants=[Variant("fifty")]).scene("fifty")
    with pytest.raises(CaseError, match="fifth") as caught:
        case(variants=[Variant("fifty")]).scene("fifth")
    assert "fifty" in (caught.value.remedy or "")
    with pytest.raises(CaseError, match="mian"):
        scene.find_pass("mian")


def test_without_variants_there_is_one_called_default() -> None:
    assert [scene.variant for scene in case().scenes()] == ["default"]


def test_cases_are_frozen_and_travel_between_processes() -> None:
    made = case()
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.title = "other"  # type: ignore[misc]
    copy = pickle.loads(pickle.dumps(made))
    assert copy.passes[0].draws[0].uniforms == {"light.linear": 0.5}


def test_a_mesh_may_be_made_later() -> None:
    made: list[int] = []

    def make() -> Mesh:
        made.append(1)
        return Mesh(attributes={"aPos": np.zeros((3, 2)), "aNormal": np.ones((3, 3))})

    mesh = Mesh.later(make).only("aPos")
    assert made == []
    assert (mesh.vertices, list(mesh.attributes), mesh.indices, mesh.primitive) == (
        3, ["aPos"], None, "triangles",
    )  # fmt: skip
    assert made == [1]
    with pytest.raises(CaseError, match="did you mean aPos"):
        _ = Mesh.later(make).only("aPoss").attributes


def test_a_default_is_not_looked_at_and_what_is_given_is() -> None:
    """Fields that were left out cost nothing; a wrong value is found beside any number of them."""
    assert State() == State(blend=None)
    with pytest.raises(CaseError, match="State: cull is 3"):
        State(cull=3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "kept"), [("u1", "uint8"), ("u2", "uint16"), ("i8", "uint32"), ("u4", "uint32")]
)
def test_small_unsigned_indices_keep_their_type(given: str, kept: str) -> None:
    mesh = Mesh(attributes={"aPos": np.zeros((3, 3))}, indices=np.arange(3).astype(given))
    assert mesh.indices is not None and mesh.indices.dtype == kept


@pytest.mark.parametrize("indices", [[], [0.5, 1, 2], [True, False, True]])
def test_indices_are_whole_numbers(indices: list[float]) -> None:
    with pytest.raises(CaseError, match="indices are one or more whole numbers, not"):
        Mesh(attributes={"aPos": np.zeros((3, 3))}, indices=np.array(indices))
