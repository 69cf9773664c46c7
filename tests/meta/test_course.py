"""The page of the course is what the cases make of it, and no section is without a proof."""

from __future__ import annotations

from pathlib import Path

from tests.catalogue import shipped
from tests.meta.course import LEFT_OUT, PAGE, SECTIONS, WITHIN, names_of, page, rows


def test_the_page_is_what_the_cases_make_of_it(repository: Path) -> None:
    found = (repository / PAGE).read_text(encoding="utf-8")
    assert found == page(), "run `python -m tests.meta.course`"


def test_every_section_has_a_proof_or_says_why_not() -> None:
    proved = {section: [by for _, _, by in rows(section)] for section in SECTIONS}
    without = {section for section, found in proved.items() if not found or not all(found)}
    assert without <= set(LEFT_OUT) <= set(SECTIONS)


def test_every_lesson_is_of_a_section() -> None:
    assert {case.id for case in shipped().values() if case.section not in SECTIONS} == set()


def test_expectations_that_are_named_exist() -> None:
    missing = set()
    for (section, lesson), (_, named) in WITHIN.items():
        missing |= {(section, lesson, n) for n in set(named) - set(names_of(shipped()[lesson]))}
    assert missing == set()
