"""Compiled templates that are kept from one command to the next."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from jinja2 import Environment, UndefinedError
from jinja2.environment import Template

from shaderlab.report import rendering
from shaderlab.report.page import build_page
from shaderlab.report.pictures import Pictures
from tests.unit.test_report_samples import outcome, record, run

PAGE = "index.html.j2"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The system's folder for temporary files, empty; environments are made anew."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    rendering.environment.cache_clear()
    yield tmp_path
    rendering.environment.cache_clear()


def anew() -> Environment:
    """An environment as the next command makes it."""
    rendering.environment.cache_clear()
    return rendering.environment()


def kept(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of templates that had to be compiled."""
    names: list[str] = []
    before = Environment.compile

    def compile(self: Environment, source: str, name: str, *args: object, **more: object) -> object:
        names.append(name)
        return before(self, source, name, *args, **more)  # type: ignore[call-overload]

    monkeypatch.setattr(Environment, "compile", compile)
    return names


def test_a_template_is_compiled_once_for_all_commands(folder: Path, compiled: list[str]) -> None:
    assert isinstance(anew().get_template(PAGE), Template)
    assert compiled == [PAGE] and len(kept(folder)) == 1
    assert kept(folder)[0].parent.stat().st_mode & 0o077 == 0
    anew().get_template(PAGE)
    assert compiled == [PAGE]


def test_without_a_folder_templates_are_compiled_all_the_same(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(folder / "missing"))
    assert anew().bytecode_cache is None
    assert isinstance(anew().get_template(PAGE), Template)


def test_no_piece_of_a_page_grows_with_the_cases(tmp_path: Path) -> None:
    few, many = (max(map(len, pieces(tmp_path, count))) for count in (3, 30))
    assert 0 < many <= few + 100


def pieces(folder: Path, count: int) -> list[str]:
    """The page of so many cases, each with four variants and a long lesson."""
    made = run(
        *(
            record(f"case-{n}", str(v), lesson=f"{n} {v} " * 300, expectations=(outcome(),) * 3)
            for n in range(count)
            for v in range(4)
        )
    )
    empty = dict.fromkeys(
        ("against", "drivers", "links", "policy", "style", "script", "root", "past"), ""
    )
    page = build_page(made, Pictures(folder))
    template = rendering.environment().get_template(PAGE)
    return list(template.stream(empty, page=page, run=made, single=True, level=3, here=""))


def test_what_a_template_misnames_is_an_error() -> None:
    shown = rendering.environment().from_string("{{ thing.title }}")
    assert shown.render(thing=record(title="<a>")) == "&lt;a&gt;"
    for thing in ({"title": "an item"}, outcome()):
        with pytest.raises(AttributeError, match="title"):
            shown.render(thing=thing)
    with pytest.raises(UndefinedError, match="thing"):
        shown.render()
