"""Which files are cases: told from their text, without running any of it."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine.catalogue import (
    case_files,
    chapter_title,
    data_folder,
    files_below,
    inspect_file,
    is_case_file,
    load_case,
    place_of,
    shipped_cases,
    tree_of,
)
from shaderlab.errors import CaseError, UsageError

IMPORT = "from shaderlab import Case\n"


@pytest.mark.parametrize(
    "text",
    [
        IMPORT + "case = Case(title='x')\n",
        IMPORT + "case: Case = Case(title='x')\n",
        "import shaderlab\ncase = shaderlab.Case(title='x')\n",
        "import shaderlab as sl\n\ncase = sl.Case(\n    title='x')\n",
        "from shaderlab import *\ncase = Case()\n",
        IMPORT + "case = make(Case)\n",
        IMPORT + "case, other = two()\n",
        IMPORT + "if True:\n    case = [Case()][0]\n",
        IMPORT + "try:\n    pass\nfinally:\n    from .lib import lamp as case\n",
        "from shaderlab.glslmath import exp\ncase = make(exp)\n",
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
        "import numpy\ncase = numpy.Case()\n",
        "import shaderlab\ncase = 'upper'\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    " + IMPORT,
        "raise SystemExit('imported')\n",
    ],
)
def test_other_files(tmp_path: Path, text: str) -> None:
    file = tmp_path / "lamp.py"
    file.write_text(text)
    assert not is_case_file(file) and not inspect_file(file)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (IMPORT + "other = Case(title='x')\n", "assigns no `case`"),
        (IMPORT + "cases = [Case()]\n", "assigns no `case`"),
        (IMPORT + "def f():\n    case = Case()\n", "assigns no `case`"),
        (IMPORT + "case: Case\n", "assigns no `case`"),
        (IMPORT + "'''\ncase = Case()\n'''\n", "assigns no `case`"),
        ("import shaderlab\nlamp = shaderlab.Case()\n", "assigns no `case`"),
    ],
)
def test_a_file_that_takes_case_and_is_none_has_a_reason(
    tmp_path: Path, text: str, reason: str
) -> None:
    file = tmp_path / "lamp.py"
    file.write_text(text)
    assert not is_case_file(file) and reason in (inspect_file(file) or "")
    named: list[tuple[Path, str]] = []
    assert not list(case_files(tmp_path, lambda path, why: named.append((path, why))))
    assert named == [(file, inspect_file(file))]


def test_a_case_made_by_a_module_of_the_same_project_is_one(tmp_path: Path) -> None:
    files = {
        "lamps/bulb.py": "from ..common import make\ncase = make(3)\n",
        "lamps/tube.py": "from shared import make\ncase = make(4)\n",
        "lamps/shared.py": "from ..common import make\n",
        "common/__init__.py": "from .made import make\n",
        "common/made.py": IMPORT + "def make(n): return Case()\n",
        "lamps/word.py": "from .letters import make\ncase = make()\n",
        "lamps/letters.py": "from .word import case\ndef make(): return 'upper'\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert [f.name for f in case_files(tmp_path)] == ["bulb.py", "tube.py"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [("test_lamp.py", ""), ("lamp_test.py", ""), ("_lamp.py", "begins with _")],
)
def test_only_names_that_begin_with_an_underscore_are_left_out(
    tmp_path: Path, name: str, reason: str
) -> None:
    file = tmp_path / name
    file.write_text(IMPORT + "case = Case()\n")
    assert is_case_file(file) == (not reason) and reason in (inspect_file(file) or "")
    file.rename(tmp_path / "lamp.txt")
    assert not is_case_file(tmp_path / "lamp.txt") and not inspect_file(tmp_path / "lamp.txt")


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


def test_a_tree_begins_at_the_nearest_file_that_says_so(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    case = tmp_path / "a" / "b" / "lamp.py"
    assert tree_of(case) == tmp_path / "a" / "b"
    (tmp_path / "cases.toml").touch()
    assert tree_of(case) == tmp_path
    (tmp_path / "a" / "cases.toml").touch()
    assert tree_of(case) == tmp_path / "a"
    assert tree_of(tmp_path / "c" / ".." / "sun.py") == tmp_path


def test_chapters_have_the_titles_that_their_tree_gives_them(tmp_path: Path) -> None:
    case = tmp_path / "lamp.py"
    assert chapter_title(case, "5.1") == ""
    tree = tmp_path / "tree"
    tree.mkdir()
    (tree / "cases.toml").write_text('[chapters]\n5 = "Lamps"\n')
    found = [chapter_title(tree / "lamp.py", s) for s in ("5", "5.10", "5.1, 6.2", "6", "", "x")]
    assert found == ["Lamps", "Lamps", "Lamps", "", "", ""]
    assert chapter_title(next(shipped_cases()), "5.5.2") == "Lighting"


def test_a_tree_says_where_its_lessons_stand(tmp_path: Path) -> None:
    (tmp_path / "cases.toml").write_text(
        'text = "a book"\n[sections]\n"5.1" = ["Lamps", "灯"]\n[[path]]\ntitle = "Light"\n'
        '[path.lessons]\nlamp = {title_zh = "灯"}\nfog = {assumes = ["lamp"], because = "of x"}\n'
    )
    fog = place_of(tmp_path / "fog.py", "fog", "6")
    assert (fog.order, fog.stage, fog.stage_title, fog.assumes) == (2, 1, "Light", ("lamp",))
    lamp = place_of(tmp_path / "lamp.py", "lamp", "5.1")
    assert (lamp.title_zh, lamp.section_title_zh, lamp.text) == ("灯", "灯", "a book")
    assert place_of(tmp_path / "else.py", "else", "7").order == 0


def test_a_misspelt_word_of_a_path_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "cases.toml").write_text('[[path]]\n[path.lessons]\nlamp = {becuase = "x"}\n')
    with pytest.raises(CaseError, match="becuase"):
        place_of(tmp_path / "lamp.py", "lamp", "5.1")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[chapters", "no TOML file"),
        ("[chapter]\n5 = 'Lamps'", "write [chapters] with"),
        ("chapters = 5", "write [chapters] with"),
        ("[chapters]\nfive = 'Lamps'", "write [chapters] with"),
        ("[chapters]\n5 = 6", "write [chapters] with"),
    ],
)
def test_a_wrong_file_of_a_tree_is_an_error_with_its_name(
    tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "cases.toml").write_text(text)
    with pytest.raises(CaseError, match=re.escape(says)) as caught:
        chapter_title(tmp_path / "lamp.py", "5.1")
    assert caught.value.file == str(tmp_path / "cases.toml")


LIAR = """class Liar:
    @property
    def __class__(self): return Case
    def __getattr__(self, name): return []
    def __eq__(self, other): return True
case = Liar()
"""


@pytest.mark.parametrize(
    "content",
    [
        IMPORT + "case = 1\n",
        IMPORT + "case = [Case()]\n",
        IMPORT + "class case: pass\n",
        IMPORT + "case = Case\n",
        IMPORT + LIAR,
        IMPORT + "from unittest.mock import MagicMock\ncase = MagicMock(spec=Case)\n",
        IMPORT + "class E(Exception):\n    def __str__(self): raise E\nraise E\ncase = 1\n",
        IMPORT + "raise SystemExit(0)\ncase = 1\n",
        IMPORT + "Case(\n",
        IMPORT + "case = " + "-" * 100_000 + "1",
        "# coding: utf-16\n" + IMPORT + "case = 1\n",
        (IMPORT + "case = 1\n").encode("utf-16"),
        b"\0" * 100,
        None,
    ],
)
def test_a_file_that_can_be_no_case_fails_by_its_name(
    tmp_path: Path, content: str | bytes | None
) -> None:
    """Beside good cases it would be left out otherwise, and the run would pass."""
    file = tmp_path / "lamp.py"
    if content is None:
        file.symlink_to("nowhere")
    else:
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert list(case_files(tmp_path)) == [file]
    with pytest.raises(CaseError) as raised:
        load_case(file)
    assert raised.value.file == str(file) and raised.value.remedy


def test_links_to_folders_lead_to_each_once(tmp_path: Path) -> None:
    """Not on each of the ways that links from one to the other allow: more than any run can take.
    What is below is found where it is."""
    for number in range(12):
        folder = tmp_path / f"z{number}"
        folder.mkdir()
        (folder / "file").touch()
        for other in range(12):
            (folder / f"to {other}").symlink_to(f"../z{other}")
        (tmp_path / f"a{number}").symlink_to(folder)
    (tmp_path / "z0" / "up").symlink_to(tmp_path)
    expected = sorted(tmp_path / f"z{number}" / "file" for number in range(12))
    assert files_below(tmp_path) == expected


def test_links_lead_neither_to_what_lies_above_nor_into_what_may_not_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A link to /proc/self has both: `root`, below which all of the machine is, and `cwd`."""
    cases = tmp_path / "cases"
    cases.mkdir()
    (tmp_path / "elsewhere").touch()
    (cases / "up").symlink_to("..")
    (cases / "root").symlink_to("/")
    (cases / "closed").symlink_to("nobody/home")
    see = os.stat

    def refuse(path: str | Path, *args: object, **options: Any) -> os.stat_result:
        if Path(path).name == "closed" and options.get("follow_symlinks", True):
            raise PermissionError(13, "Permission denied", str(path))
        return see(path, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("os.stat", refuse)
    assert files_below(cases) == [cases / "closed"]
