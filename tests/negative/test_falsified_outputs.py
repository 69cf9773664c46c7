"""Outputs that a driver gets wrong are noticed: the benchmark of it, on one case."""

import pytest

from benchmarks import falsified


def test_outputs_of_a_case_are_falsified_and_all_of_it_is_noticed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert falsified.main(["attenuation", "--pattern", "single", "--pattern", "nan"]) == 0
    said = capsys.readouterr().out
    assert "single: 3 expectation" in said and "nan: 3 expectation" in said
