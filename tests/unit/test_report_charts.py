"""Curves in the report, and how long a large one takes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.unit.test_report_samples import (
    INF,
    NAN,
    Page,
    curve,
    record,
    run,
    write,
)


def test_curves_are_drawn_with_a_table(tmp_path: Path) -> None:
    page = Page(write(run(record(curves=(curve(),))), tmp_path))
    words = page.words()
    assert "2 outside" in words  # 0.9 is not in [0.2, 0.3]; NaN lies in no band
    assert "1 point outside this chart" in words
    assert "NaN" in words and "−∞" in words
    dots = [a["d"] for t, a in page.tags if t == "path" and a.get("class") == "dots is-outside"]
    assert str(dots[0]).count("h0") == 1


def test_over_two_inputs_a_map_is_drawn(tmp_path: Path) -> None:
    area = curve(y=(1.0, 2.0, 3.0, 4.0), y_label="height")
    page = Page(write(run(record(curves=(area,))), tmp_path))
    dots = {
        str(a["class"]): str(a["d"]).count("h0")
        for t, a in page.tags
        if t == "path" and "dots" in str(a.get("class"))
    }
    # 0.5 is the least, 1 the most; 0.9 is outside of its band, NaN has no colour.
    shades = {f"dots shade-{n}": 0 for n in range(8)}
    assert dots == shades | {
        "dots shade-0": 1, "dots shade-6": 1, "dots shade-7": 1, "dots is-outside": 2,
    }  # fmt: skip
    words = page.words()
    assert "measured 0.5 to 1" in words and "height" in words and "2 outside" in words


def test_one_wild_value_does_not_flatten_the_curve(tmp_path: Path) -> None:
    wild = curve(measured=(1.0, 0.5, 1e30, 0.1))
    page = Page(write(run(record(curves=(wild,))), tmp_path))
    line = next(str(a["d"]) for t, a in page.tags if t == "path" and a.get("class") == "reference")
    heights = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", line)]
    assert max(heights) - min(heights) > 100
    assert "1 outside" in page.words() and "1 point outside this chart" in page.words()


@pytest.mark.parametrize(
    "values",
    [
        {"x": (), "measured": (), "reference": (), "low": (), "high": ()},
        {"measured": (NAN,) * 4, "reference": (INF,) * 4},
        {"x": (-1.0, 0.0, 0.0, -2.0), "log_x": True},
        {"x": (1.0,) * 4, "measured": (2.0,) * 4, "reference": (2.0,) * 4},
        {"measured": (-1.7e308, 0.0, 1.7e308, 1.0)},
        {"x": (1e-300, 1.0, 1e300, 2.0), "log_x": True},
        {"measured": (5e-324, 0.0, 0.0, 0.0), "reference": (0.0,) * 4},
        {"x": (1e15, 1e15 + 1, 1e15 + 2, 1e15 + 3)},
        {"y": (1.0,) * 4, "measured": (NAN,) * 4},
        {"y": (-INF, 1e308, NAN, 5e-324), "measured": (INF, -1e308, 1e308, 0.0)},
    ],
)
def test_odd_curves_do_no_harm(tmp_path: Path, values: dict[str, object]) -> None:
    page = Page(write(run(record(curves=(curve(**values),))), tmp_path))
    drawn = [str(a["d"]) for tag, a in page.tags if tag == "path" and "d" in a]
    assert not [d for d in drawn if re.search(r"nan|inf|e\+", d)]
