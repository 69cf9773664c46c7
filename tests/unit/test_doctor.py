"""`shaderlab doctor` on a machine that lacks something (what it has is tested with a driver)."""

from __future__ import annotations

import importlib.metadata
import json
from collections.abc import Mapping

import pytest
from click.testing import CliRunner

from shaderlab.cli import cli
from shaderlab.cli.doctor import examine
from shaderlab.errors import DriverError


@pytest.fixture
def no_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    def probe(driver: str | None = None) -> Mapping[str, str]:
        raise DriverError("no context", remedy="Debian: this · Fedora: that")

    monkeypatch.setattr("shaderlab.drivers.probe", probe)


@pytest.fixture
def driver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "shaderlab.drivers.probe", lambda driver=None: {"renderer": "paint", "glsl": "3.30"}
    )


def doctor(*args: str) -> tuple[int, str]:
    result = CliRunner().invoke(cli, ["doctor", *args], catch_exceptions=False)
    return result.exit_code, result.output


@pytest.mark.usefixtures("no_driver")
def test_a_missing_driver_is_named_with_its_cure() -> None:
    code, output = doctor()
    assert code == 1
    lines = output.splitlines()
    at = next(i for i, line in enumerate(lines) if "no context" in line)
    assert lines[at].startswith("✗ OpenGL on EGL")
    assert [line.strip() for line in lines[at + 1 : at + 3]] == ["→ Debian: this", "→ Fedora: that"]


@pytest.mark.usefixtures("driver")
def test_all_there() -> None:
    code, output = doctor()
    assert code == 0, output
    for name in ("Python", "numpy", "glslang", "SPIRV-Tools", "driver", "GLSL"):
        assert f"✓ {name} " in output
    assert "✗" not in output


@pytest.mark.usefixtures("driver")
def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.metadata.version

    def version(name: str) -> str:
        if name == "moderngl":
            raise importlib.metadata.PackageNotFoundError(name)
        return "0.1" if name == "rich" else real(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    found = {finding.name: finding for finding in examine()}
    assert not found["moderngl"].ok and "pip install 'moderngl" in found["moderngl"].remedy
    assert not found["rich"].ok and found["rich"].found.startswith("0.1 (wanted: >=")
    assert doctor()[0] == 1


@pytest.mark.usefixtures("driver")
def test_what_is_different_without_an_extra_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "✓ images " in doctor()[1]
    real = importlib.metadata.version

    def version(name: str) -> str:
        if name == "OpenImageIO":
            raise importlib.metadata.PackageNotFoundError(name)
        return real(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    code, output = doctor()
    assert code == 0, output
    assert "– images " in output and "image files can't be loaded" in output
    assert "→ pip install 'shaderlab[images]'" in output


@pytest.mark.usefixtures("driver")
def test_a_vulkan_driver_that_is_not_there_is_named_with_its_cure(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def probe(driver: str | None = None) -> Mapping[str, str]:
        if driver == "swiftshader":
            raise DriverError("no manifest", remedy="Debian: this · Fedora: that")
        return {"renderer": "paint", "version": "9"}

    monkeypatch.setattr("shaderlab.drivers.probe", probe)
    code, output = doctor()
    assert code == 0, output  # no case needs it
    assert "✓ lavapipe " in output and "– swiftshader " in output and "→ Fedora: that" in output


@pytest.mark.usefixtures("driver")
def test_json() -> None:
    code, output = doctor("--json", "-")
    entries = json.loads(output)
    assert code == 0 and {entry["name"] for entry in entries} >= {"Python", "glslang"}
    assert set(entries[0]) == {"name", "found", "ok", "necessary", "remedy"}
