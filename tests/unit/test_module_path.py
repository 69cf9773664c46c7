"""Python's own modules come before a user's of the same name."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from shaderlab.files import search_folder, sort_search_path


def test_pythons_own_come_first_and_the_rest_keeps_its_order(tmp_path: Path) -> None:
    own = os.path.dirname(os.__file__)
    site = os.path.join(own, "site-packages")
    given = ["/b", site, "", own, "/a", os.path.join(own, "lib-dynload"), "/b/lib-dynload"]
    expected = [own, given[5], "/b", site, os.getcwd(), "/a", "/b/lib-dynload"]
    assert sort_search_path(given) == expected


def test_a_folder_is_search_folder_for_a_while() -> None:
    before = list(sys.path)
    sys.path.insert(0, "/x")
    with search_folder("/x"):
        assert sys.path[0] == "/x" and sys.path != ["/x", *before]
        assert sys.path.index("/x/") > sys.path.index(os.path.dirname(os.__file__))
        sys.path.append("/added by a case")
    assert sys.path == ["/x", *before, "/added by a case"]
    sys.path[:] = before


def test_python_m_does_not_look_into_the_working_folder(tmp_path: Path, repository: Path) -> None:
    (tmp_path / "tempfile.py").write_text("raise RuntimeError('the wrong module')\n")
    done = subprocess.run(
        [sys.executable, "-m", "shaderlab", "run", "--help"], cwd=tmp_path, capture_output=True,
        env={**os.environ, "PYTHONPATH": str(repository)}, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
