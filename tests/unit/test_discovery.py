"""Which files are cases: told from their text, without running any of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.discovery import case_files, data_folder, is_case_file, shipped_cases
from shaderlab.errors import UsageError

IMPORT = "from shaderlab import Case\n"


@pytest.mark.parametrize(
    "text",
    [
        IMPORT + "case = Case(title='x')\n",
        IMPORT + "case: Case = Case(title='x')\n",
        "import shaderlab\ncase = shaderlab.Case(title='x')\n",
        "import shaderlab as sl\n\ncase = sl.Case(\n    title='x')\n",
        "from shaderlab import *\ncase = Case()\n",
        IMPORT + "case = Case(title='never closed'\n",
    ],
)
def test_cases(tmp_path: Path, text: str) -> None:
    file = tmp_path / "lamp.py"
    file.write_text(text)
    assert is_case_file(file)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "case = Case(title='x')\n",
        "from unittest import Case  # not shaderlab\ncase = Case()\n",
        IMPORT + "other = Case(title='x')\n",
        IMPORT + "case = make()\n",
        IMPORT + "def f():\n    case = Case()\n",
        IMPORT + "case = 1\n",
        IMPORT + "'''\ncase = Case()\n'''\n",
        "raise SystemExit('imported')\n",
    ],
)
def test_other_files(tmp_path: Path, text: str) -> None:
    file = tmp_path / "lamp.py"
    file.write_text(text)
    assert not is_case_file(file)


@pytest.mark.parametrize(
    "name", ["test_lamp.py", "lamp_test.py", "_lamp.py", "conftest.py", "l.txt"]
)
def test_names_that_are_never_cases(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(IMPORT + "case = Case()\n")
    assert not is_case_file(file)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert not is_case_file(tmp_path / "gone.py")
    (tmp_path / "folder.py").mkdir()
    assert not is_case_file(tmp_path / "folder.py")
    (tmp_path / "binary.py").write_bytes(b"\xff\x00shaderlab\ncase = \x00\n")
    is_case_file(tmp_path / "binary.py")


def test_a_folder_is_searched_but_not_what_tools_left_in_it(tmp_path: Path) -> None:
    for name in ("b/sun.py", "a/lamp.py", ".venv/x.py", "build/y.py", "__pycache__/z.py"):
        file = tmp_path / name
        file.parent.mkdir()
        file.write_text(IMPORT + "case = Case()\n")
    assert [f.relative_to(tmp_path).as_posix() for f in case_files(tmp_path)] == [
        "a/lamp.py",
        "b/sun.py",
    ]
    with pytest.raises(UsageError):
        list(case_files(tmp_path / "gone"))


def test_shipped_cases_need_no_parsing_to_be_told() -> None:
    shipped = list(shipped_cases())
    assert len(shipped) > 100
    assert shipped == list(case_files(data_folder("cases")))
