"""Loading case files: what is found, and what is said of files that are wrong."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from shaderlab.engine import catalogue
from shaderlab.engine.catalogue import data_folder, find_imported_files, inspect_file, load_case
from shaderlab.errors import CaseError, UsageError
from tests.catalogue import shipped

GOOD = '''"""A lesson.

Two paragraphs."""
from shaderlab import Case, exact, fullscreen
case = Case(title="t", passes=fullscreen("a.frag", domain={}), expect=[exact("c", 1.0)])
'''


def saved(folder: Path, text: str, name: str = "my_case.py") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_case_gets_its_id_its_file_and_its_lesson(tmp_path: Path) -> None:
    path = saved(tmp_path, GOOD)
    case = load_case(path)
    assert (case.id, case.file) == ("my-case", str(path))
    assert case.lesson == "A lesson.\n\nTwo paragraphs."


def test_case_files_import_their_neighbours(tmp_path: Path) -> None:
    saved(tmp_path, "TITLE = 'from next door'\n", "neighbour.py")
    case = load_case(
        saved(tmp_path, "from neighbour import TITLE\n" + GOOD.replace('"t"', "TITLE"))
    )
    assert case.title == "from next door"


def test_folders_need_not_be_named_in_utf_8(tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    folder.mkdir()
    assert load_case(saved(folder, GOOD)).title == "t"


@pytest.mark.parametrize("what", ["SystemExit", "GeneratorExit", "BaseException"])
def test_whatever_a_case_raises_is_named(tmp_path: Path, what: str) -> None:
    with pytest.raises(CaseError, match=f"{what}: 3") as caught:
        load_case(saved(tmp_path, f"\nraise {what}(3)\n"))
    assert caught.value.line == 2


@pytest.mark.parametrize(
    ("handler", "expected"),
    [(signal.SIG_IGN, CaseError), (signal.default_int_handler, KeyboardInterrupt)],
)
def test_an_interrupt_is_the_files_own_where_none_can_come(
    tmp_path: Path, handler: Any, expected: type[BaseException]
) -> None:
    before = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(expected):
            load_case(saved(tmp_path, "\nraise KeyboardInterrupt\n"))
    finally:
        signal.signal(signal.SIGINT, before)


def tree(folder: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def titled(import_line: str) -> str:
    return import_line + "\n" + GOOD.replace('"t"', "TITLE")


@pytest.mark.parametrize("line", ["from helper import TITLE", "from .helper import TITLE"])
def test_helpers_of_one_name_in_two_folders_are_two_modules(tmp_path: Path, line: str) -> None:
    tree(
        tmp_path,
        {
            "cases.toml": "",
            "a/helper.py": "TITLE = 'a'",
            "b/helper.py": "TITLE = 'b'",
            "a/one.py": titled(line),
            "b/two.py": titled(line),
        },
    )
    for _ in range(2):
        assert load_case(tmp_path / "a" / "one.py").title == "a"
        assert load_case(tmp_path / "b" / "two.py").title == "b"


def test_a_neighbour_that_is_named_like_a_module_of_pythons(tmp_path: Path) -> None:
    """Python's own imports still find theirs; the neighbour is there by its relative name."""
    files = {"colorsys.py": "TITLE = 'mine'", "colours.py": "import colorsys\ncolorsys.rgb_to_hsv"}
    file = tree(tmp_path, files) / "lamp.py"
    before = list(sys.path)
    file.write_text(titled("import colours\nfrom .colorsys import TITLE"))
    assert load_case(file).title == "mine"
    file.write_text(titled("from colorsys import TITLE"))
    with pytest.raises(CaseError, match="cannot import name 'TITLE'") as caught:
        load_case(file)
    assert "the file beside the case is .colorsys" in (caught.value.remedy or "")
    assert sys.path == before


@pytest.mark.parametrize("more", ["", "import importlib, colorsys\nimportlib.reload(colorsys)\n"])
def test_bare_imports_of_packages_stay_apart_with_all_their_modules(
    tmp_path: Path, more: str
) -> None:
    """In sys.modules a package comes after its modules, and what is imported anew comes last."""
    for name in ("a", "b"):
        tree(
            tmp_path / name,
            {
                "parts/__init__.py": "from parts.titles import TITLE",
                "parts/titles.py": f"TITLE = {name!r}",
                "lamp.py": titled("from parts import TITLE\n" + more),
            },
        )
    for name in ("a", "b"):
        assert load_case(tmp_path / name / "lamp.py").title == name


def test_bare_imports_of_folders_and_of_what_they_import_stay_apart_too(tmp_path: Path) -> None:
    for name in ("a", "b"):
        tree(
            tmp_path / name,
            {
                "parts/titles.py": "import deeper\nTITLE = deeper.TITLE",
                "deeper.py": f"TITLE = {name!r}",
                "lamp.py": titled("from parts.titles import TITLE"),
            },
        )
    assert load_case(tmp_path / "a" / "lamp.py").title == "a"
    assert load_case(tmp_path / "b" / "lamp.py").title == "b"


def test_cases_import_from_a_folder_that_their_tree_shares(tmp_path: Path) -> None:
    """Also from folders whose names are no words of Python; a package's own file is run."""
    tree(
        tmp_path,
        {
            "my-cases.v2/cases.toml": "",
            "my-cases.v2/scenes/titles.py": "from .words import TITLE",
            "my-cases.v2/scenes/words.py": "from dataclasses import dataclass\nTITLE = 'shared'",
            "my-cases.v2/lights/__init__.py": "COLOUR = 'red'",
            "my-cases.v2/ch-1.5/deep/lamp.py": titled(
                "from __future__ import annotations\n"
                "from dataclasses import dataclass\n"
                "from ...lights import COLOUR\n"
                "from ...scenes.titles import TITLE\n"
                "@dataclass\nclass Light:\n    name: str\n"
                "assert COLOUR == 'red'"
            ).replace('"""A lesson.\n\nTwo paragraphs."""\n', ""),
        },
    )
    assert load_case(tmp_path / "my-cases.v2" / "ch-1.5" / "deep" / "lamp.py").title == "shared"


def test_two_trees_do_not_mix(tmp_path: Path) -> None:
    for name in ("mine", "yours"):
        files = {"cases.toml": "", "scenes/titles.py": f"TITLE = {name!r}"}
        folder = tree(tmp_path / name / "cases", files)
        saved(folder / "scenes", titled("from .titles import TITLE"), "lamp.py")
        assert load_case(folder / "scenes" / "lamp.py").title == name


def test_a_relative_import_from_outside_the_tree_says_how_to_share(tmp_path: Path) -> None:
    files = {
        "scenes/titles.py": "TITLE = 'x'",
        "a/lamp.py": titled("from ..scenes.titles import TITLE"),
    }
    file = tree(tmp_path, files) / "a" / "lamp.py"
    with pytest.raises(CaseError, match="beyond top-level package") as caught:
        load_case(file)
    assert caught.value.line == 1
    assert "cases.toml" in (caught.value.remedy or "")
    (tmp_path / "cases.toml").touch()
    assert load_case(file).title == "x"


def test_a_misspelt_name_of_the_lab_is_an_error_that_says_the_right_one(tmp_path: Path) -> None:
    line = "from shaderlab.engine.expectations import OutputExpectations"
    with pytest.raises(CaseError) as caught:
        load_case(saved(tmp_path, titled(line)))
    assert "OutputExpectation" in (caught.value.remedy or "")
    assert caught.value.line == 1


def test_a_mistake_in_a_shared_module_is_an_error_of_the_case_each_time(tmp_path: Path) -> None:
    tree(tmp_path, {"helper.py": "TITLE = 1 / 0", "lamp.py": titled("from .helper import TITLE")})
    for _ in range(2):
        with pytest.raises(CaseError, match="ZeroDivisionError") as caught:
            load_case(tmp_path / "lamp.py")
        assert caught.value.line == 1


@pytest.mark.parametrize(
    ("change", "says", "line", "remedy"),
    [
        (("title=", "titel="), "titel", 5, ""),
        (("domain=", "domian="), "domian", 5, ""),
        (("exact, full", "exactly, full"), "exactly", 4, "exact"),
        (("exact, full", "exact, vec4, full"), "vec4", 4, "from shaderlab.glslmath import vec4"),
        (
            ("exact, full", "exact, texture, full"),
            "texture",
            4,
            "shaderlab.glslmath.sampling import",
        ),
        (
            ("shaderlab import", "shaderlab.glslmath.sampling import"),
            "Case",
            4,
            "from shaderlab import Case",
        ),
        (
            ("case =", "import shaderlab as lab; lab.Texture([0])\ncase ="),
            "take",
            5,
            "",
        ),
        (("case =", "import shaderlab as lab; lab.Texture(imag=0)\ncase ="), "imag", 5, ""),
        (("exact(", "exakt("), "exakt", 5, ""),
        (("case =", "the_case ="), "defines no case", None, "case = Case"),
        (("case = Case(", "case = (Case("), "SyntaxError", 5, ""),
        (("expect=[", "variants=[Variant('v', {'x': 1})], expect=["), "Variant", 5, ""),
        (("\ncase =", "\nraise SystemExit(3)\ncase ="), "SystemExit", 5, ""),
        (("\ncase =", "\n1 / 0\ncase ="), "ZeroDivisionError", 5, ""),
        (('expect=[exact("c", 1.0)]', "expect=[]"), "nothing could fail", 5, ""),
    ],
)
def test_a_wrong_file_is_named_with_line_and_right_spelling(
    tmp_path: Path, change: tuple[str, str], says: str, line: int | None, remedy: str
) -> None:
    path = saved(tmp_path, GOOD.replace(*change))
    with pytest.raises(CaseError, match=says) as caught:
        load_case(path)
    assert caught.value.file == str(path)
    assert caught.value.line == line
    assert remedy in (caught.value.remedy or "")


def test_a_variant_that_changes_nothing_is_found_on_loading(tmp_path: Path) -> None:
    text = GOOD.replace("import Case", "import Variant, Case").replace(
        "expect=", "variants=[Variant('v', {'x': 1.0})], expect="
    )
    with pytest.raises(CaseError, match="'x', which no draw has"):
        load_case(saved(tmp_path, text))


def test_missing_files_and_folders_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="there is no such case file"):
        load_case(tmp_path / "none.py")
    with pytest.raises(CaseError, match="is a folder"):
        load_case(tmp_path)


def test_a_file_of_gigabytes_is_refused_without_reading_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether it is named, found in a folder, or imported by a case."""
    verbatim = catalogue.read_regular

    def read_a_part(path: Path, size: int = -1) -> bytes:
        assert 0 < size <= catalogue.MAX_BYTES + 1
        return verbatim(path, size)

    monkeypatch.setattr(catalogue, "read_regular", read_a_part)
    texts = {"zeros": "", "text": "from shaderlab import Case\n", "other": "x = 1\n"}
    for name, text in texts.items():
        path = tmp_path / f"{name}.py"
        path.write_text(text + "#" * catalogue.MAX_BYTES)
        if name == "zeros":
            os.truncate(path, 0)
            os.truncate(path, 3 << 30)
        assert inspect_file(path) == (None if name == "other" else "")
        with pytest.raises(CaseError, match="is larger than 4 MiB") as caught:
            load_case(path)
        assert caught.value.remedy
    path = saved(tmp_path, GOOD + "\nimport zeros\n")
    assert inspect_file(path) == "" and find_imported_files(path) == {tmp_path / "zeros.py"}


def test_cases_come_in_the_order_of_the_notes() -> None:
    chapters = [case.chapter for case in shipped().values()]
    assert chapters == sorted(chapters)
    assert chapters[0] == 1


def test_data_that_is_not_shipped_is_an_error_with_a_remedy() -> None:
    with pytest.raises(UsageError, match="no meshes folder") as caught:
        data_folder("meshes")
    assert caught.value.remedy


def test_a_wrong_file_named_by_a_relative_path_is_named_with_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = saved(tmp_path, GOOD.replace("Case(", "Case(titel=1, "))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CaseError) as caught:
        load_case(Path(path.name))
    assert caught.value.line is not None and "titel" in caught.value.message
