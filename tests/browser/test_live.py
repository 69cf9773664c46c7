"""A case's picture, played in its page: what was judged, until something is moved."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab.engine.pictures import load_frames
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.pictures import to_display
from shaderlab.model.records import Run
from shaderlab.mutation import CaseResult, MutantResult, MutantRun, results_to_json
from shaderlab.mutation.shader_mutants import mutate_case
from shaderlab.report.html import write
from shaderlab.report.page import MUTATION_NAME
from tests.browser.test_accessibility import violations
from tests.browser.test_page import wait_until
from tests.catalogue import shipped

PLAYED = ("spotlight", "diffuse", "texture-mix", "colour-product")
"""Cases over the whole target, of meshes drawn for a later pass, of textures, and one whose draws
write to other places of their target than the lab clears."""
SHOWN = """() => {
    const canvas = document.querySelector(".live-canvas");
    const all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    return [canvas.height, canvas.width, new Uint8Array(all.buffer).toBase64()];
}"""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The pages of some shipped cases, drawn on OpenGL."""
    folder = tmp_path_factory.mktemp("live")
    options = RunOptions(
        size=64, picture_size=64, folder=folder, frames=folder / "frames", modules=False
    )
    with SceneRunner(options) as lab:
        cases = [shipped()[name] for name in (*PLAYED, "geometry-houses")]
        records = [lab.run(next(replace(case, expect=case.expect[:1]).scenes())) for case in cases]
        about = dict(lab.driver)
    mutants = mutate_case(shipped()["diffuse"])  # the last ones are not detected
    tried = [MutantRun(each, MutantResult("killed", "the light")) for each in mutants[:-9]]
    tried += [MutantRun(each, MutantResult("survived")) for each in mutants[-9:]]
    result = CaseResult(id="diffuse", runs=tuple(tried), seconds=1.0)
    (folder / MUTATION_NAME).write_text(json.dumps(results_to_json([result])))
    write(
        Run(driver=about, versions={}, started="2026", seconds=1.0, records=tuple(records)), folder
    )
    return folder


COUNT = """() => {
    for (const name of ["drawArraysInstanced", "drawElementsInstanced"]) {
        const own = WebGL2RenderingContext.prototype[name];
        WebGL2RenderingContext.prototype[name] = function (...given) {
            window.drawn += 1;
            return own.apply(this, given);
        };
    }
}"""
"""Counts draws."""


def opened(
    visit: Callable[..., Any], report: Path, name: str, watch: str = "", **options: Any
) -> Any:
    page = visit(report / "cases" / f"{name}.html", **options)
    if watch:
        page.evaluate(watch)
    assert page.locator(".live-canvas").count() == 0
    # A visitor sees the button at once, however long the lesson and its pictures are.
    header = page.locator(".case > header").bounding_box()
    assert header["y"] + header["height"] < page.viewport_size["height"]
    assert page.locator("header .live-button button").is_visible()
    page.click(".live-button button")
    page.wait_for_selector(".live-canvas")
    return page


@pytest.mark.parametrize("name", PLAYED)
def test_it_is_what_was_judged(visit: Callable[..., Any], report: Path, name: str) -> None:
    case = shipped()[name]
    scene = next(case.scenes())
    frames = load_frames(report / "frames", name, scene.variant)
    output = case.picture or next(key for key in frames if key.startswith(scene.passes[-1].name))
    judged = to_display(frames[output][..., :3]).image[::-1]
    page = opened(visit, report, name)
    assert page.get_by_text("Make a mistake").is_visible() is (name == "diffuse")
    height, width, pixels = page.evaluate(SHOWN)
    live = np.frombuffer(base64.b64decode(pixels), np.uint8).reshape(height, width, 4)[..., :3]
    off = np.abs(live.astype(int) - judged.astype(int)).max(axis=2)
    # Of 255; edges differ, and where a texture is filtered, which llvmpipe does with eight bits.
    assert np.mean(off > 16) < 0.01


def test_a_slider_moves_it_and_one_click_leads_back(
    visit: Callable[..., Any], report: Path
) -> None:
    page = opened(visit, report, "diffuse", viewport={"width": 1280, "height": 800})
    above = page.locator(".way").bounding_box()["height"]
    assert page.locator(".live-canvas").bounding_box()["y"] >= above
    assert page.locator(".live-controls label").first.bounding_box()["y"] < 760
    before = page.evaluate(SHOWN)
    for name in ("away", "lightColor r"):
        slider = page.locator(f"input[name='{name}'], input[aria-label='{name}']").first
        slider.focus()
        page.keyboard.press("Home")
        page.wait_for_timeout(100)  # two frames
        assert page.evaluate(SHOWN) != before, name
        # The picture stays in sight, and does not cover the slider.
        pair = page.locator(".live-pair").bounding_box()
        assert above <= pair["y"] + 1, name
        assert pair["y"] + pair["height"] <= slider.bounding_box()["y"], name
        page.click("text=Back to what was judged")
        assert page.evaluate(SHOWN) == before
        page.set_viewport_size({"width": 390, "height": 800})  # the next one on a phone
    page.locator(".live-canvas").focus()
    page.keyboard.press("ArrowRight")
    assert page.inner_text(".live-reading").startswith("Pixel (33, 32): live ")
    for width in (390, 1280):
        page.set_viewport_size({"width": width, "height": 800})
        assert violations(page, ".live") == []


def test_a_shader_is_edited_and_its_errors_stand_at_their_lines(
    visit: Callable[..., Any], report: Path
) -> None:
    page = opened(visit, report, "diffuse")
    before, caption = page.evaluate(SHOWN), page.locator(".live-pair figcaption").last
    page.check("text=difference to the judged picture")
    assert caption.inner_text() == "Difference: 0 (dark) to 0 (bright)"
    page.click("text=Edit the shaders")
    text = page.locator(".live textarea")
    source = text.input_value()
    number = next(n for n, line in enumerate(source.split("\n"), start=2) if "ambient =" in line)
    text.fill(source.replace("ambient =", "ambient = nowhere +"))
    errors = page.locator(".live-errors")
    wait_until(page, lambda: errors.inner_text().startswith(f"line {number}: 'nowhere'"))
    assert str(number) in page.inner_text(".live-editor pre").split()
    text.fill(source.replace("ambientStrength * lightColor", "vec3(0.5)"))
    wait_until(page, lambda: " 0 (bright)" not in caption.inner_text())
    assert errors.inner_text() == ""
    page.uncheck("text=difference to the judged picture")
    assert page.evaluate(SHOWN) != before
    assert violations(page, ".live") == []
    page.click("text=Back to what was judged")
    assert page.evaluate(SHOWN) == before
    page.click("text=Make a mistake")
    mistakes = page.locator(".live details button")
    said = mistakes.all_inner_texts()
    detected = ["detected by the light" in text for text in said]
    assert True in detected and detected == sorted(detected)
    assert "which no check detects" in said[0]
    number = next(n for n, text in enumerate(said) if "(operator)" in text)
    mistakes.nth(number).click()  # at once where it shows
    assert " 0 (bright)" not in caption.inner_text()
    assert errors.inner_text() == ""
    mistakes.nth(number).click()
    assert page.evaluate(SHOWN) == before
    assert violations(page, ".live") == []


def test_what_does_not_change_is_not_drawn_again(visit: Callable[..., Any], report: Path) -> None:
    page = opened(visit, report, "diffuse", watch=COUNT)
    page.evaluate("window.drawn = 0")
    page.check("text=difference to the judged picture")  # painted anew
    assert page.inner_text(".live-pair figure:last-child") == "Difference: 0 (dark) to 0 (bright)"
    assert page.evaluate("window.drawn") == 0
    page.locator("input[aria-label='lightColor r']").focus()
    page.keyboard.press("Home")
    wait_until(page, lambda: page.evaluate("window.drawn") > 0)


def test_the_page_says_why_there_is_none(visit: Callable[..., Any], report: Path) -> None:
    page = visit(report / "cases" / "geometry-houses.html")
    assert page.locator("[data-live]").count() == 0
    assert "the geometry stage: WebGL2 has none" in page.inner_text("article")
