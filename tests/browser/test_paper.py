"""A case on paper: few sheets, nothing cut off. `python -m benchmarks.pages` prints real ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.pages import SHEETS, cut_off, sheets
from shaderlab.model import pictures
from shaderlab.model.records import Attachment, PassRecord, Row, SourceText
from shaderlab.report.html import write
from tests.unit.test_report_samples import curve, outcome, record, run, worst

Visit = Callable[..., Any]
WIDE = r"a = \frac{1}{K_c + K_l d + K_q d^2} + \frac{1}{2}, \qquad "


@pytest.fixture(scope="module")
def long_case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a case with as much as the course's longest ones, each of another kind."""
    folder = tmp_path_factory.mktemp("long")
    pictures.save_png(folder / "p.png", np.zeros((256, 256, 3), np.uint8))
    held = tuple(Row(label=f"pixel ({n}, 7)", expected="0.5", measured="0.5", ok=True)
                 for n in range(90))  # fmt: skip
    checks = [outcome(name=f"pixel ({n}, 7)", worst=worst()) for n in range(90)]
    passes = tuple(
        PassRecord(name=f"pass-{n}", draws=(("shadow/depth.vert", "shadow/depth.frag"),), reads=(),
                   attachments=(Attachment(name="depth", format="depth32f", image="p.png"),),
                   size=(256, 256))
        for n in range(24)
    )  # fmt: skip
    text = "\n".join(f"float d{n} = max(dot(normal, light_{n}), 0.0);" for n in range(40))
    sources = tuple(
        SourceText(file=f"shadow-{n}.frag", line=1, language="glsl", text=text) for n in range(6)
    )
    checks[0] = outcome(name="figures", rows=held, sources=sources)
    case = record(
        "long", formula=WIDE * 3 + "b", expectations=tuple(checks), passes=passes,
        curves=tuple(curve(title=f"curve {n}") for n in range(6)), images={"picture": "p.png"},
        captions={"picture": "colours as drawn"},
    )  # fmt: skip
    return write(run(case), folder).parent / "cases" / "long.html"


def test_a_long_case_takes_few_sheets_and_nothing_is_cut_off(visit: Visit, long_case: Path) -> None:
    page = visit(long_case)
    assert 3 <= sheets(page) <= SHEETS
    assert cut_off(page) == ()
    # Beside the lesson, as on a desk: a sheet is narrower than what a screen counts as a phone.
    lesson, picture = (page.locator(name).bounding_box() for name in (".lesson", ".pictures"))
    assert picture["x"] > lesson["x"] + lesson["width"]


def test_a_short_case_takes_one_sheet(visit: Visit, tmp_path: Path) -> None:
    page = write(run(record("short")), tmp_path).parent / "cases" / "short.html"
    assert sheets(visit(page)) == 1


def test_what_is_cut_off_is_noticed(visit: Visit, tmp_path: Path) -> None:
    one = r"\frac{1}{K_c + K_l d + K_q d^2} + " * 6 + "b"
    page = write(run(record("wide", formula=one)), tmp_path).parent / "cases" / "wide.html"
    assert [words.split(":")[0] for words in cut_off(visit(page))] == ["formula"]
