"""Loading case files: what is found, and what is said of files that are wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from shaderlab.catalogue import Catalogue, load_case
from shaderlab.discovery import data_folder
from shaderlab.errors import CaseError, UsageError

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


@pytest.mark.parametrize(
    ("change", "says", "line", "remedy"),
    [
        (("title=", "titel="), "titel", 5, "title"),
        (("domain=", "domian="), "domian", 5, "domain"),
        (("exact, full", "exactly, full"), "exactly", 4, "exact"),
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


def test_two_cases_can_not_share_an_id(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    files = [saved(tmp_path, GOOD), saved(tmp_path / "other", GOOD)]
    with pytest.raises(CaseError, match="'my-case' is taken by") as caught:
        Catalogue.of(files)
    assert caught.value.file == str(files[1])


def test_an_unknown_id_suggests_the_nearest() -> None:
    with pytest.raises(UsageError, match="spotligth") as caught:
        Catalogue.shipped().find("spotligth")
    assert "spotlight" in (caught.value.remedy or "")


def test_cases_come_in_the_order_of_the_notes() -> None:
    chapters = [case.chapter for case in Catalogue.shipped()]
    assert chapters == sorted(chapters)
    assert chapters[0] == 1


def test_data_that_is_not_shipped_is_an_error_with_a_remedy() -> None:
    with pytest.raises(UsageError, match="no meshes folder") as caught:
        data_folder("meshes")
    assert caught.value.remedy
