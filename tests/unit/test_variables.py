"""What drivers are opened with."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from shaderlab.drivers import mesa_variables, set_variables


@pytest.mark.parametrize("name", ["MESA_SHADER_CACHE_DIR", "XDG_CACHE_HOME", "HOME"])
def test_mesa_keeps_no_shaders_on_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Its cache is a mapped file: a page without room ends the process."""
    for other in ("MESA_SHADER_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(other, raising=False)
    monkeypatch.setenv(name, str(tmp_path / "not" / "there"))
    room = {tmp_path: 0}
    monkeypatch.setattr(
        os, "statvfs", lambda path: SimpleNamespace(f_bavail=room.get(path, 1 << 20), f_frsize=4096)
    )
    assert mesa_variables() == {"MESA_SHADER_CACHE_DISABLE": "true"}
    room[tmp_path] = 1 << 20
    assert mesa_variables() == {}


def test_variables_are_set_for_a_while_and_restored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GALLIUM_DRIVER", "mine")
    monkeypatch.delenv("LIBGL_ALWAYS_SOFTWARE", raising=False)
    before = dict(os.environ)
    with (
        pytest.raises(KeyError),
        set_variables({"GALLIUM_DRIVER": "softpipe", "LIBGL_ALWAYS_SOFTWARE": "1"}),
    ):
        assert os.environ["GALLIUM_DRIVER"] == "softpipe"
        assert os.environ["LIBGL_ALWAYS_SOFTWARE"] == "1"
        raise KeyError
    assert dict(os.environ) == before
