"""`glsl.given`: what it finds, how small it makes it, and what a failure says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis.database import InMemoryExampleDatabase

from benchmarks.planted import planted, search
from shaderlab import glsl
from shaderlab.bands import Band
from shaderlab.errors import CallError, FormulaError
from shaderlab.functions import properties
from shaderlab.functions.evaluation import keeping
from shaderlab.functions.library import NOTES, Notes, record_of_test
from shaderlab.functions.properties import hints_of, weight

SHADER = """
struct Lamp { vec3 color; float power; };
float right(float c) { return c * c; }
float wrong(float c) { return c > 0.35 && c < 0.36 ? 1.5 : c; }
float several(float a, float b, float t) { return mix(a, b, t) + (t > 0.98 ? 0.1 : 0.0); }
vec3 unit(vec3 v) { return normalize(v); }
vec3 lit(Lamp lamp, float k) { return lamp.color * lamp.power * (k > 3.0 ? -1.0 : 1.0); }
float scaled(float x) { return 2.0 * x; }
float needle(float x) { return abs(x - 0.73125) < 1e-6 ? 2.0 : x; }
float parted(float x, out float whole) { whole = floor(x); return x - whole; }
"""
UNIT = glsl.floats(0.0, 1.0)


@pytest.fixture(autouse=True)
def database() -> Iterator[InMemoryExampleDatabase]:
    """What Hypothesis keeps, here for one test only."""
    before = hypothesis.settings.get_current_profile_name()
    kept = InMemoryExampleDatabase()
    hypothesis.settings.register_profile("functions", database=kept)
    hypothesis.settings.load_profile("functions")
    yield kept
    hypothesis.settings.load_profile(before)


@pytest.fixture(scope="module")
def shader() -> glsl.Library:
    return glsl.load(SHADER)


def failure(test: Callable[..., Any]) -> str:
    """What a failing test says."""
    with pytest.raises(AssertionError) as error:
        test()
    return "\n".join([str(error.value), *getattr(error.value, "__notes__", ())])


def on_arrays(c: Any, y: Any) -> None:
    assert ((y >= 0) & (y <= 1)).all()


def on_numbers(c: Any, y: Any) -> None:
    assert 0 <= y <= 1


def as_booleans(c: Any, y: Any) -> Any:
    return y <= 1


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(properties, "SAMPLES", 1000)


@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("test", [on_arrays, on_numbers, as_booleans])
def test_each_way_to_write_a_property(shader: glsl.Library, test: Callable[..., Any]) -> None:
    glsl.given(shader.right, c=UNIT)(test)()
    glsl.given(shader.wrong, c=glsl.one_of(0.0, 1.0))(test)()
    said = failure(glsl.given(shader.wrong, c=UNIT)(test))
    assert "smallest counterexample for wrong of text:4:\n@glsl.example(c=0.35" in said
    assert "\ny = 1.5" in said


def test_a_counterexample_is_simple_in_all_its_inputs(shader: glsl.Library) -> None:
    def no_more_than_the_larger(a: Any, b: Any, y: Any) -> None:
        assert (y <= np.maximum(a, b) + 1e-5).all()

    ten = glsl.floats(-10.0, 10.0)
    said = failure(glsl.given(shader.several, a=ten, b=ten, t=UNIT)(no_more_than_the_larger))
    assert "@glsl.example(a=0.0, b=0.0, t=1.0)" in said


@pytest.mark.usefixtures("few")
def test_vectors_directions_and_structs(shader: glsl.Library) -> None:
    def of_length_one(v: Any, y: Any) -> Any:
        return abs(np.linalg.norm(y, axis=-1) - 1.0) < 1e-5

    directions = glsl.given(shader.unit, v=glsl.directions())(of_length_one)
    directions()
    said = failure(glsl.given(shader.unit, v=glsl.floats(-1.0, 1.0))(of_length_one))
    assert "@glsl.example(v=[0.0, 0.0, 0.0])" in said

    def not_dark(y: Any) -> Any:
        return (y >= 0.0).all(axis=-1)

    lamp = {"color": UNIT, "power": glsl.floats(0.0, 10.0)}
    said = failure(glsl.given(shader.lit, lamp=lamp, k=glsl.ints(0, 10))(not_dark))
    assert "lamp={'color': [" in said and "'power': 1.0}, k=4)" in said
    glsl.given(shader.lit, lamp=lamp, k=2.0)(not_dark)()


@pytest.mark.usefixtures("few")
def test_several_results_have_their_names(shader: glsl.Library) -> None:
    def adds_up(x: Any, result: Any, whole: Any) -> Any:
        return result + whole == x

    def mapped(x: Any, y: Any) -> Any:
        return y["whole"] <= x - 1.0

    glsl.given(shader.parted, x=glsl.floats(0.0, 8.0))(adds_up)()
    assert "whole" in failure(glsl.given(shader.parted, x=glsl.floats(0.0, 8.0))(mapped))


def test_a_property_of_several_elements_fails_as_it_stands(shader: glsl.Library) -> None:
    def all_alike(y: Any) -> None:
        assert np.ptp(y) < 0.5

    with pytest.raises(AssertionError):
        glsl.given(shader.scaled, x=UNIT)(all_alike)()


def test_examples_come_first_and_can_be_pasted(shader: glsl.Library) -> None:
    seen = []

    def below_one(x: Any, y: Any) -> None:
        seen.append(np.copy(x))
        assert (x < 1.0).all()

    test = glsl.given(shader.scaled, x=glsl.one_of(0.25))(glsl.example(x=0.5)(below_one))

    test()
    assert seen[0].tolist() == [0.5] and (seen[1] == 0.25).all()
    said = failure(glsl.given(shader.scaled, x=UNIT)(glsl.example(x=1.0)(below_one)))
    assert "@glsl.example(x=1.0)" in said


def test_hypothesis_keeps_what_failed(
    shader: glsl.Library, database: InMemoryExampleDatabase
) -> None:
    seen: list[Any] = []

    def rare(x: Any) -> None:
        seen.append(np.copy(x))
        assert not ((x > 0.5) & (x < 0.50002)).any()

    test = glsl.given(shader.scaled, x=UNIT)(rare)
    with pytest.raises(AssertionError):
        test()
    assert sum(map(len, database.data.values())) > 0
    failing = next(x for x in seen if ((x > 0.5) & (x < 0.50002)).any())
    seen.clear()
    with pytest.raises(AssertionError):
        test()
    assert (seen[0] == failing).all()


PLANTED = [one for one in planted() if one.bug]
TRIED = PLANTED[3::10]


@pytest.mark.parametrize("one", TRIED, ids=lambda one: f"{one.name}: {one.bug}")
def test_planted_mistakes_are_found_and_made_small(one: Any) -> None:
    """Ten of the hundred that `python -m benchmarks.planted` tries."""
    found = search(one)
    assert found.failed
    assert found.nontrivial(one) <= 2


def test_there_are_a_hundred_and_all_are_different() -> None:
    assert len(PLANTED) == 100 == len({one.text for one in PLANTED})
    assert len(TRIED) == 10


def test_no_alarm_on_what_is_right() -> None:
    right = next(one for one in planted() if one.name == "decode" and not one.bug)
    assert not search(right).failed


def test_wrong_names_and_domains_are_refused(shader: glsl.Library) -> None:

    def surplus(x: Any, y: Any, w: Any) -> None:
        raise AssertionError

    with pytest.raises(CallError, match="scaled takes no 'z'"):
        glsl.given(shader.scaled, z=UNIT)(on_arrays)()
    with pytest.raises(CallError, match="has parameters y, w, of which only one can"):
        glsl.given(shader.scaled, x=UNIT)(surplus)()
    with pytest.raises(CallError, match="the lower first"):
        glsl.floats(1.0, 0.0)
    with pytest.raises(CallError, match="the lower first"):
        glsl.ints(1, 0)


def test_samples_stay_in_their_domain_and_reach_its_edges() -> None:
    rng = np.random.default_rng(0)
    x = glsl.floats(-1.5, 3.0).sample(rng, (10_000,), hints_of("x < 0.04045 ? 1e3 : 2.5"))
    assert x.dtype == np.float32 and x.min() == -1.5 and x.max() == 3.0
    v = glsl.floats(-1.5, 3.0).sample(rng, (10, 2), np.zeros(0))
    assert v[:5].tolist() == [[c, c] for c in (0.0, -1.5, 3.0, 1.0, -1.0)]
    for edge in (0.0, 2.5, np.nextafter(np.float32(0.04045), np.float32(0))):
        assert np.float32(edge) in x
    assert ((x * 100).astype(int) == 217).any()
    n = glsl.ints(-2, 5).sample(rng, (1000,), np.zeros(0))
    assert set(n.tolist()) == set(range(-2, 6))
    length = np.linalg.norm(glsl.directions().sample(rng, (100, 3), np.zeros(0)), axis=-1)
    assert np.allclose(length, 1.0)
    assert not glsl.bools().sample(rng, (100,), np.zeros(0)).all()
    assert weight(0.0) < weight(1.0) < weight(0.5) < weight(0.25) < weight(0.3333)
    positive = glsl.floats(0.0, 1.0).sample(rng, (10_000,), np.zeros(0))
    assert not np.signbit(positive).any() and (positive == 0.0).any()


def outcomes(test: Callable[..., Any]) -> list[tuple[str, int]]:
    """The kinds of what a test that passes notes, and on how many arguments it ran."""
    with keeping(NOTES, Notes()) as notes:
        test()
    return [
        (one.kind, one.judged)
        for one in record_of_test("t.py", "t", 1, status="pass", notes=notes).expectations
    ]


def test_bounds_are_proved_and_run_once(shader: glsl.Library) -> None:
    assert outcomes(glsl.given(shader.right, c=UNIT)(on_numbers)) == [("proof", 10_000)]
    assert outcomes(glsl.given(shader.right, c=UNIT)(on_arrays)) == [("proof", 10_000)]

    def in_order(x: Any, whole: Any, result: Any) -> Any:
        return (whole <= 1.0) & (result <= 1.001) & (x >= 0.0)

    assert outcomes(glsl.given(shader.parted, x=UNIT)(in_order)) == [("proof", 10_000)]


def test_what_is_not_proved_is_sampled(shader: glsl.Library) -> None:
    def largest(y: Any) -> None:
        assert y.max() <= 1.0

    def below(c: Any, y: Any) -> None:
        assert y <= c  # c * c <= c, but the box forgets that both are one

    for test in (largest, below):
        assert outcomes(glsl.given(shader.right, c=UNIT)(test)) == [("given", 100_000)]


def test_a_proof_finds_what_no_sample_does(shader: glsl.Library) -> None:
    def bounded(x: Any, y: Any) -> None:
        assert y <= 1.0

    assert "@glsl.example(x=0.73125" in failure(glsl.given(shader.needle, x=UNIT)(bounded))


def test_a_condition_of_bands_has_an_answer_in_proofs_alone() -> None:
    with pytest.raises(FormulaError, match="no single answer"):
        bool(Band.exact([1.0]) < 2.0)
