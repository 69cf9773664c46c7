"""Judging made-up frames: what is right passes, and each kind of wrong is caught."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Output,
    Pixel,
    Rules,
    across,
    computed,
    coverage,
    exact,
    formula,
    fullscreen,
    gl_error,
    sweep,
    value,
)
from shaderlab.engine.expectations.base import SessionQuery
from shaderlab.engine.expectations.needs import CapturedFragments, Probe
from shaderlab.errors import CaseError, FormulaError
from shaderlab.glslmath import pow, sin
from shaderlab.glslmath.sampling import texture
from shaderlab.model.expectation import Judgement
from shaderlab.model.frame import Bindings, Fragments, Frame, Image, Samples, Texels

SIZE = 8
X = (np.arange(SIZE, dtype=np.float32) + 0.5) / SIZE
XS = np.broadcast_to(X[None, :, None], (SIZE, SIZE, 1)).astype(np.float32)


def doubled(x: Any, light_gain: Any) -> Any:
    return x * light_gain


def bindings(**uniforms: float) -> Bindings:
    values = {"light.gain": 2.0, **uniforms}
    decimal = {name: np.array([v], np.float64) for name, v in values.items()}
    return Bindings(
        uniforms={name: v.astype(np.float32) for name, v in decimal.items()}, decimal=decimal
    )


def frame(measured: np.ndarray, *, covered: Any = True, format: str = "r32f", **more: Any) -> Frame:
    shape = measured.shape[:2]
    return Frame(
        images={("main", "y"): Image(measured, format)},
        order=("main",),
        bindings={("main", 0): more.pop("bound", bindings())},
        answers={
            CapturedFragments(("main", 0)): Fragments(
                covered=np.broadcast_to(covered, shape),
                frag_coord=np.ones((*shape, 4), np.float32),
                inputs={"x": XS[: shape[0], : shape[1]]},
            )
        },
        **more,
    )


def judged(expectation: Any, made: Frame, *others: Any, probed: Samples | None = None) -> Judgement:
    if probed is not None:
        made = replace(made, answers={**made.answers, Probe(expectation): probed})
    case = Case(
        title="t",
        id="t",
        passes=fullscreen("y.frag", domain={"x": across(0.0, 1.0)}),
        expect=[expectation, *others],
    )
    return expectation.judge(case.scene("default"), made)


def test_a_formula_passes_on_the_right_values() -> None:
    outcome = judged(formula("y", doubled), frame(2.0 * XS)).outcome
    assert (outcome.status, outcome.judged, outcome.outside) == ("pass", 64, 0)
    assert outcome.worst is not None and outcome.worst.widths <= 1.0
    assert outcome.sources[0].text.startswith("def doubled")


def test_a_formula_names_the_one_pixel_that_is_off_by_two_ulp() -> None:
    measured = 2.0 * XS
    measured[5, 3] += 2 * np.spacing(measured[5, 3])
    outcome = judged(formula("y", doubled), frame(measured)).outcome
    assert (outcome.status, outcome.outside) == ("fail", 1)
    assert outcome.worst is not None
    assert outcome.worst.pixel == (3, 5)
    assert outcome.worst.ulp == 2.0
    assert outcome.worst.inputs["x"] == (float(X[3]),)
    assert outcome.worst.inputs["light.gain"] == (2.0,)


def test_pixels_that_nothing_covers_are_not_judged() -> None:
    covered = np.zeros((SIZE, SIZE), bool)
    covered[2, :] = True
    measured = np.where(covered[..., None], 2.0 * XS, 77.0).astype(np.float32)
    outcome = judged(formula("y", doubled), frame(measured, covered=covered)).outcome
    assert (outcome.status, outcome.judged) == ("pass", SIZE)


def test_a_formula_over_no_pixel_at_all_fails() -> None:
    outcome = judged(formula("y", doubled), frame(2.0 * XS, covered=False)).outcome
    assert outcome.status == "fail"
    assert "nothing was judged" in outcome.message


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_not_finite_fails(bad: float) -> None:
    measured = 2.0 * XS
    measured[0, 0] = bad
    assert judged(formula("y", doubled), frame(measured)).outcome.status == "fail"


def test_a_check_that_could_hardly_fail_fails() -> None:
    def undefined(x: Any) -> Any:
        return pow(x - 1.0, 2.0)  # a negative base: anything is legal

    outcome = judged(formula("y", undefined), frame(XS)).outcome
    assert outcome.status == "fail"
    assert outcome.vacuous == 1.0
    assert "could hardly fail" in outcome.message


def test_a_formula_can_bring_its_own_rules() -> None:
    def far(x: Any) -> Any:
        return sin(x + 6.0)

    measured = np.sin(XS + 6.0)
    assert judged(formula("y", far), frame(measured)).outcome.status == "fail"
    scaled = formula("y", far, rules=Rules(trig_outside="scaled"))
    assert judged(scaled, frame(measured)).outcome.status == "pass"


def test_an_independent_implementation_must_lie_in_the_band_too() -> None:
    def other(x: Any) -> Any:
        return x + x

    def wrong(x: Any) -> Any:
        return x * 2.00001

    good = judged(formula("y", doubled, also={"other": other}), frame(2.0 * XS)).outcome
    assert good.status == "pass" and good.rows[0].ok
    bad = judged(formula("y", doubled, also={"wrong": wrong}), frame(2.0 * XS)).outcome
    assert bad.status == "fail" and not bad.rows[0].ok


def test_a_parameter_that_matches_nothing_is_an_error_that_lists_what_there_is() -> None:
    def misspelt(x: Any, light_gein: Any) -> Any:
        return x * light_gein

    with pytest.raises(FormulaError, match="light_gein") as caught:
        judged(formula("y", misspelt), frame(XS))
    assert "light_gain" in (caught.value.remedy or "")
    assert caught.value.line


def test_given_constants_win_over_uniforms() -> None:
    check = formula("y", doubled, given={"light_gain": 3.0})
    assert judged(check, frame((3.0 * XS).astype(np.float32))).outcome.status == "pass"
    assert judged(check, frame(2.0 * XS)).outcome.status == "fail"


def test_struct_arrays_and_arrays_come_as_lists() -> None:
    def summed(x: Any, lights_gain: Any, weights: Any) -> Any:
        return x * lights_gain[0] + x * lights_gain[1] + weights[2]

    bound = Bindings(
        uniforms={
            "lights[0].gain": np.array([1.0], np.float32),
            "lights[1].gain": np.array([2.0], np.float32),
            "weights": np.array([[0.0], [0.0], [4.0]], np.float32),
        },
        arrays=frozenset({"weights"}),
    )
    made = frame((3.0 * XS + 4.0).astype(np.float32), bound=bound)
    assert judged(formula("y", summed), made).outcome.status == "pass"


def test_a_reference_that_fails_is_located() -> None:
    def broken(x: Any) -> Any:
        return x.no_such_thing

    with pytest.raises(FormulaError, match="no_such_thing") as caught:
        judged(formula("y", broken), frame(XS))
    assert caught.value.file and caught.value.file.endswith("test_expectations.py")


def test_eight_bits_allow_both_neighbours_of_a_tie_and_nothing_else() -> None:
    def grey() -> Any:
        return 0.5

    for code, status in ((127, "pass"), (128, "pass"), (126, "fail"), (129, "fail")):
        measured = np.full((SIZE, SIZE, 1), code, np.uint8)
        assert judged(formula("y", grey), frame(measured, format="r8")).outcome.status == status


def test_srgb_encodes_colours_but_not_alpha() -> None:
    def half() -> Any:
        return 0.5

    right = np.full((SIZE, SIZE, 4), (188, 188, 188, 128), np.uint8)
    made = frame(right, format="srgb8_alpha8")
    assert judged(formula("y", half), made).outcome.status == "pass"
    for wrong in ((188, 188, 188, 188), (186, 188, 188, 128), (128, 128, 128, 128)):
        made = frame(np.full((SIZE, SIZE, 4), wrong, np.uint8), format="srgb8_alpha8")
        assert judged(formula("y", half), made).outcome.status == "fail"


def samples(y: float, x: float = 0.3) -> Samples:
    return Samples(
        inputs={"x": np.array([[x]], np.float32)},
        outputs={"y": np.array([[y]], np.float32)},
        decimal={"x": np.array([[x]])},
    )


def test_a_figure_must_hold_for_the_reference_and_for_the_shader() -> None:
    def run(equals: float, y: float, digits: int = 4) -> Any:
        check = value("y", at={"x": 0.3}, equals=equals, digits=digits, reference=doubled)
        return judged(check, frame(XS), probed=samples(y)).outcome

    assert run(0.6, 0.6).status == "pass"
    wrong_figure = run(0.6001, 0.6)
    assert wrong_figure.status == "fail" and "0.6000" in wrong_figure.message
    assert run(0.6, 0.600001).status == "fail"
    assert run(0.6, 0.6).rows[0].expected == "0.6000"


def test_a_figure_finds_the_formula_of_its_output() -> None:
    check = value("y", at={"x": 0.3}, equals=0.6, digits=6)
    found = judged(check, frame(2.0 * XS), formula("y", doubled), probed=samples(0.7))
    assert found.outcome.status == "fail"


def test_a_figure_without_any_formula_is_measured() -> None:
    good = value("y", at=Pixel(1, 0), equals=float(X[1]), digits=6)
    assert judged(good, frame(XS)).outcome.status == "pass"
    bad = value("y", at=Pixel(1, 0), equals=float(X[2]), digits=6)
    assert judged(bad, frame(XS)).outcome.status == "fail"
    with pytest.raises(CaseError, match="outside the 8 × 8"):
        judged(value("y", at=Pixel(8, 0), equals=0.0, digits=1), frame(XS))


def test_a_sweep_gives_a_curve_and_fails_at_one_wrong_point() -> None:
    xs = np.array([[0.25], [0.5], [0.75]], np.float32)

    def run(ys: np.ndarray) -> Judgement:
        runs = Samples(inputs={"x": xs}, outputs={"y": ys}, decimal={"x": xs})
        check = sweep("y", doubled, over="x", values=(0.25, 0.5, 0.75))
        return judged(check, frame(XS), probed=runs)

    good = run(2.0 * xs)
    assert good.outcome.status == "pass"
    assert good.curve is not None and good.curve.reference == (0.5, 1.0, 1.5)
    bad = 2.0 * xs
    bad[1] += np.float32(1e-6)
    assert run(bad).outcome.status == "fail"


def test_exact_compares_bits_and_names_the_first_difference() -> None:
    measured = np.zeros((4, 6, 1), np.float32)
    assert judged(exact("y", 0.0), frame(measured)).outcome.status == "pass"
    measured[2, 5] = -0.0
    outcome = judged(exact("y", 0.0), frame(measured)).outcome
    assert (outcome.status, outcome.outside) == ("fail", 1)
    assert outcome.worst is not None and outcome.worst.pixel == (5, 2)


def test_exact_lays_a_table_over_the_picture_cell_by_cell() -> None:
    table = np.array([[[0], [1], [2]], [[3], [4], [5]]], np.float32)
    picture = np.zeros((7, 8, 1), np.float32)
    for row, (bottom, top) in enumerate(((0, 3), (3, 7))):
        for column, (left, right) in enumerate(((0, 2), (2, 5), (5, 8))):
            picture[bottom:top, left:right] = table[row, column]
    assert judged(exact("y", table), frame(picture)).outcome.status == "pass"
    assert judged(exact("y", table[::-1]), frame(picture)).outcome.status == "fail"


def test_exact_against_another_output() -> None:
    made = frame(XS)
    both = dict(made.images) | {("main", "z"): Image(XS + 1.0, "r32f")}
    made = Frame(images=both, order=made.order, bindings=made.bindings)
    assert judged(exact("y", Output("main.y")), made).outcome.status == "pass"
    assert judged(exact("y", Output("main.z")), made).outcome.status == "fail"


@pytest.mark.parametrize("equals", [0.0, Output("main.z")])
def test_exact_without_pictures_still_shows_what_differs(equals: Any) -> None:
    zero = np.zeros((4, 6, 1), np.float32)
    made = frame(zero.copy())
    made = replace(made, images=dict(made.images) | {("main", "z"): Image(zero, "r32f")})
    assert judged(exact("y", equals), made).pictures is not None
    assert judged(exact("y", equals, pictured=False), made).pictures is None
    made.images["main", "y"].values[1, 2] = 1.0
    found = judged(exact("y", equals, pictured=False), made)
    assert found.outcome.status == "fail"
    assert found.pictures is not None
    assert np.argwhere(found.pictures()["distance"]).tolist() == [[1, 2]]


def test_exact_refuses_what_can_not_be_compared() -> None:
    with pytest.raises(CaseError, match="can't be compared"):
        judged(exact("y", (1.0, 2.0)), frame(XS))
    codes = np.zeros((2, 2, 1), np.uint8)
    with pytest.raises(CaseError, match="uint8"):
        judged(exact("y", 0.5), frame(codes, format="r8"))


def test_coverage_counts() -> None:
    covered = np.zeros((SIZE, SIZE), bool)
    covered[:3] = True
    made = frame(XS, covered=covered)
    assert judged(coverage(24), made).outcome.status == "pass"
    outcome = judged(coverage(25), made).outcome
    assert outcome.status == "fail" and "24 pixels" in outcome.message


def test_a_computed_figure_is_rounded_as_printed() -> None:
    good = judged(computed("third", lambda: 1 / 3, equals=0.333, digits=3), frame(XS)).outcome
    bad = judged(computed("third", lambda: 1 / 3, equals=0.334, digits=3), frame(XS)).outcome
    assert (good.status, bad.status) == ("pass", "fail")
    with pytest.raises(FormulaError, match="ZeroDivisionError"):
        judged(computed("none", lambda: 1 / 0, equals=0.0, digits=1), frame(XS))


def test_a_gl_error_must_be_the_expected_one_and_the_only_one() -> None:
    check = gl_error("invalid_operation")
    wrong = (((0x500,), "fail"), ((0x502, 0x500), "fail"), ((), "fail"))
    for errors, status in (((0x502,), "pass"), *wrong):
        made = replace(frame(XS), answers={SessionQuery("gl_errors", (("main", 0),)): errors})
        assert judged(check, made).outcome.status == status


def test_a_texture_is_sampled_by_the_rules_of_the_specification() -> None:
    texels = np.arange(4, dtype=np.float32).reshape(1, 4, 1) + 1.0

    def run(wrap: str, u: float, expected: float) -> str:
        def sampled(x: Any, image: Any) -> Any:
            return texture(image, x * np.array([1.0, 0.0]) + np.array([u, 0.5]))[..., 0:1]

        bound = Bindings(
            textures={"image": Texels(texels, ("nearest", "nearest"), (wrap, wrap), (9.0,) * 4)}
        )
        measured = np.full((1, 1, 1), expected, np.float32)
        made = frame(measured, bound=bound)
        made.answers[CapturedFragments(("main", 0))].inputs["x"][:] = 0.0
        return judged(formula("y", sampled), made).outcome.status

    for wrap, u, texel in (
        ("repeat", -0.1, 4.0),
        ("mirrored_repeat", -0.1, 1.0),
        ("clamp_to_edge", 1.3, 4.0),
        ("clamp_to_border", 1.3, 9.0),
    ):
        assert run(wrap, u, texel) == "pass"
        assert run(wrap, u, texel + 1.0) == "fail"


def test_an_output_or_draw_that_is_not_there_is_named() -> None:
    with pytest.raises(CaseError, match="z") as caught:
        judged(exact("z", 0.0), frame(XS))
    assert "main.y" in (caught.value.remedy or "")
    with pytest.raises(CaseError, match="no draw 3"):
        judged(coverage(1, draw=3), frame(XS))


def test_an_independent_implementation_of_another_shape_is_named() -> None:
    def other(x: Any) -> Any:
        return np.zeros((3, 7))

    with pytest.raises(FormulaError, match="other gives an array of shape") as caught:
        judged(formula("y", doubled, also={"other": other}), frame(2.0 * XS))
    assert caught.value.line
