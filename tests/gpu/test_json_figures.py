"""`shaderlab run … --json` holds the figures of the notes, as printed and as measured."""

from __future__ import annotations

import json
from typing import Any

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli

# Light left at d, and where 5 % and 1 % are left.
ATTENUATION = {
    7: (0.010626993, 3.060300, 7.224303),
    13: (0.012514078, 6.185585, 14.607545),
    20: (0.011709602, 9.212300, 21.705393),
    32: (0.012960083, 15.505410, 36.620283),
    50: (0.011695906, 23.001280, 54.233013),
    65: (0.012924071, 31.435740, 74.280997),
    100: (0.012422360, 47.421556, 111.930414),
    160: (0.012987013, 77.694997, 183.275326),
    200: (0.012285012, 94.377976, 222.549706),
    325: (0.012580594, 155.054104, 366.202833),
    600: (0.012953368, 291.217104, 686.279973),
    3250: (0.012580594, 1550.541037, 3662.028328),
}
SPOTLIGHT = (0.537811, 0.913789, 1.734179, 0.113424, -2.023555, 0.540717)
GAMMA = (0.729740,)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("json")
    ids = ["attenuation", "spotlight", "gamma"]
    files = ["--json", str(folder / "out.json"), "--report", str(folder / "out")]
    less = ["--no-pictures", "--no-modules", "--size", "32"]  # figures are of points
    done = CliRunner().invoke(cli, ["run", *ids, *files, *less, "-j", "0"])
    assert done.exit_code == 0, done.output
    read: dict[str, Any] = json.loads((folder / "out.json").read_text())
    return read


def figures(out: dict[str, Any], case_id: str, variant: str | None = None) -> list[float]:
    """All expected figures of a case whose measured value was found to hold."""
    return [
        float(row["expected"])
        for case in out["cases"]
        if case["id"] == case_id and variant in (None, case["variant"])
        for expectation in case["expectations"]
        for row in expectation["values"]
        if row["ok"] and row["expected"][-1].isdigit()
    ]


@pytest.mark.parametrize("d", list(ATTENUATION))
def test_attenuation(out: dict[str, Any], d: int) -> None:
    assert set(ATTENUATION[d]) <= set(figures(out, "attenuation", str(d)))


def test_spotlight_and_gamma(out: dict[str, Any]) -> None:
    assert set(SPOTLIGHT) <= set(figures(out, "spotlight"))
    assert set(GAMMA) <= set(figures(out, "gamma"))


def test_everything_passed_on_a_driver_that_is_named(out: dict[str, Any]) -> None:
    assert out["driver"]["renderer"]
    assert {case["status"] for case in out["cases"]} == {"pass"}
    assert {v for case in out["cases"] for v in case["compile"].values()} == {"pass"}
    for name in ("id", "variant", "seconds", "expectations", "images"):
        assert all(name in case for case in out["cases"])
