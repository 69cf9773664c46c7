"""A failing check says which line went wrong, and shows what each line computes."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from shaderlab.model.records import Explanation, Record, Step
from shaderlab.model.store import load, save
from shaderlab.report.text import format_failure
from tests.unit.test_report_samples import run, write

STEP = Step(
    file="shaders/lamp.frag",
    line=7,
    name="light",
    calls=(),
    value=(0.5, 0.75, 0.25),
    by_driver=True,
    exact=(0.5, 0.5, 0.25),
    low=(0.5, 0.49, 0.25),
    high=(0.5, 0.51, 0.25),
    off=4194304.0,
    width=335544.0,
    lost=12.0,
)
RIGHT = dataclasses.replace(
    STEP, line=6, name="away", value=(0.5,), exact=(0.5,), low=(0.4,), high=(0.6,)
)
FOUND = Explanation(
    pixel=(3, 17),
    steps=(RIGHT, STEP),
    verdict="the driver is outside the shader's band; first at shaders/lamp.frag:7",
    file="shaders/lamp.frag",
    line=7,
)


def explained(failing: Record, found: Explanation) -> Record:
    outcome = dataclasses.replace(failing.expectations[0], explanation=found)
    return dataclasses.replace(failing, expectations=(outcome,))


def test_of_a_vector_the_wrong_component_is_shown() -> None:
    assert STEP.label == "light.y" and not STEP.inside
    assert RIGHT.label == "away" and RIGHT.inside


def test_the_page_and_the_terminal_say_where_it_goes_wrong(failing: Record, tmp_path: Path) -> None:
    record = explained(failing, FOUND)
    assert sum(FOUND.verdict in line for line in format_failure(record)) == 1
    whole = run(record)
    html = write(whole, tmp_path).read_text()
    assert html.replace("&#39;", "'").count(FOUND.verdict) == 1
    assert "Line by line at pixel (3, 17)" in html
    rows = html.partition("Line by line")[2].partition("</table>")[0]
    assert rows.count("<tr") == 3 and rows.count('class="is-meant"') == 1
    assert rows.count("outside") == 1 and "lamp.frag:7" in rows
    save(whole, tmp_path)
    assert load(tmp_path).records[0].expectations[0].explanation == FOUND


def test_what_is_not_known_is_said(failing: Record, tmp_path: Path) -> None:
    refused = Explanation(pixel=(3, 17), steps=(), refused="not interpreted: a double at line 3")
    html = write(run(explained(failing, refused)), tmp_path).read_text()
    assert "not interpreted: a double at line 3" in html and "What each line" not in html
