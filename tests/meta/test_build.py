"""The compiled passes over bands are optional: a machine without a compiler installs as well."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from hatch_build import build


@pytest.fixture
def checkout(tmp_path: Path, repository: Path) -> Path:
    """A folder with the passes' sources alone."""
    kernels = Path("shaderlab", "bands", "kernels")
    shutil.copytree(repository / kernels, tmp_path / kernels)
    return tmp_path


@pytest.mark.skipif(os.name != "posix", reason="passes are built on POSIX systems")
def test_without_a_compiler_nothing_is_built_and_nothing_old_stays(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "false")
    assert build(checkout) is None
    # What an earlier compiler made of other sources would give other numbers.
    monkeypatch.setattr("sysconfig.get_config_var", lambda name: ".old.so")
    old = checkout / "shaderlab" / "bands" / "_kernels.old.so"
    old.write_bytes(b"")
    os.utime(old, (0, 0))
    assert build(checkout) is None and not old.exists()


def test_what_is_newer_than_its_sources_is_kept(
    checkout: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "false")
    monkeypatch.setattr("sysconfig.get_config_var", lambda name: ".new.so")
    new = checkout / "shaderlab" / "bands" / "_kernels.new.so"
    new.write_bytes(b"")
    assert build(checkout) == new
