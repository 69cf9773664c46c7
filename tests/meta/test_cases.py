"""The catalogue as a whole: nothing unused, nothing untaught, nothing that could not fail."""

from __future__ import annotations

import re
from pathlib import Path
from statistics import median

import pytest

from shaderlab.compiler.sources import Shaders
from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.expectations.driver_answers import Coverage
from shaderlab.engine.expectations.figures import Computed
from shaderlab.engine.expectations.rejections import CompileFails, Refused
from shaderlab.model.case import Case
from tests.catalogue import shipped

FIRST = {
    "orange-triangle", "indexed-quad", "texture-mix", "uniform-over-time", "mvp", "attenuation",
    "spotlight", "gamma", "blinn-phong", "blend-equation", "depth-functions", "stencil-functions",
}  # fmt: skip


def cases() -> tuple[Case, ...]:
    return tuple(shipped().values())


def each_case() -> list[pytest.ParameterSet]:  # type: ignore[name-defined]
    return [pytest.param(case, id=case.id) for case in cases()]


def test_the_first_cases_are_there() -> None:
    assert {case.id for case in cases()} >= FIRST


@pytest.mark.parametrize("case", each_case())
def test_a_case_teaches(case: Case) -> None:
    assert len(case.lesson) > 200
    assert "Look at:" in case.lesson
    assert re.fullmatch(r"\d+(\.\d+)*", case.section)
    assert case.math


@pytest.mark.parametrize("case", each_case())
def test_a_case_looks_at_what_it_draws(case: Case) -> None:
    """An expectation that reads no pixel and no vertex can't tell a wrong shader."""
    for scene in case.scenes():
        blind = (CompileFails, Computed, Coverage, Refused)
        assert any(not isinstance(e, blind) for e in scene.expect), scene.variant


@pytest.mark.parametrize("case", each_case())
def test_an_erratum_names_the_expectation_that_proves_it(case: Case) -> None:
    names = {e.name for scene in case.scenes() for e in scene.expect}
    for erratum in case.errata:
        assert erratum.proof in names


def test_half_of_the_cases_have_at_most_110_lines() -> None:
    """Of those in the chapters of the notes."""
    files = [Path(case.file) for case in cases() if "ch15_" not in case.file]
    lines = [len(file.read_text(encoding="utf-8").splitlines()) for file in files]
    assert len(lines) > 100
    assert median(lines) <= 110


# These say in words what their cells are.
WITHOUT_HEADINGS = {
    "compile-and-link": "a lamp for each stage, and eight mistakes of many words",
    "viewport": "six rectangles of four shapes",
}


@pytest.mark.parametrize("case", each_case())
def test_a_picture_of_several_cells_has_headings(case: Case) -> None:
    """The page writes them beside it, so nobody has to look for them in the text."""
    cells = [draw.state.cell for one in case.passes for draw in one.draws if draw.state.cell]
    if any(cell.columns > 1 or cell.rows > 1 for cell in cells):
        assert bool(case.columns or case.rows) == (case.id not in WITHOUT_HEADINGS)


@pytest.mark.parametrize("case", each_case())
def test_expectations_of_a_scene_can_be_told_apart(case: Case) -> None:
    for scene in case.scenes():
        labels = [(type(e), e.name, getattr(e, "at", None)) for e in scene.expect]
        assert all(labels.count(label) == 1 for label in labels), scene.variant


def test_every_shader_is_used() -> None:
    root = data_folder("shaders")
    shaders = Shaders([root])
    used: set[Path] = set()
    for case in cases():
        for scene in case.scenes():
            for draw in (d for p in scene.passes for d in p.draws):
                for name in draw.shaders:
                    used |= {Path(path).resolve() for path, _ in shaders.load(name).parts}
            refused = [n for e in scene.expect if isinstance(e, CompileFails) for n in e.shaders]
            refused += [
                e.what for e in scene.expect if isinstance(e, Refused) and isinstance(e.what, str)
            ]
            used |= {(root / name).resolve() for name in refused}
    there = {path.resolve() for path in root.rglob("*") if path.is_file()}
    assert there - used == set()


@pytest.mark.parametrize(
    ("law", "file"),
    [
        ("light.quadratic * (distance", "attenuation.glsl"),
        ("theta - light.outerCutOff", "spotlight.glsl"),
        ("reflect(-lightDir", "reflection.glsl"),
        ("normalize(lightDir + viewDir)", "reflection.glsl"),
    ],
)
def test_a_law_of_light_stands_in_one_shader(law: str, file: str) -> None:
    files = [path for path in data_folder("shaders").rglob("*") if path.is_file()]
    texts = {path: path.read_bytes().decode("utf-8", "replace") for path in files}
    assert {path.name for path, text in texts.items() if law in text} == {file}


def test_every_shader_says_its_version_and_has_one_main() -> None:
    root = data_folder("shaders")
    for path in root.rglob("*"):
        if not path.is_file() or {"lib", "errata"} & set(path.relative_to(root).parts):
            continue
        text = path.read_text(encoding="utf-8")
        assert text.startswith(("#version 330 core\n", "#version 4")), path
        assert len(re.findall(r"\bvoid main\(", text)) == 1, path


def test_what_a_lesson_suggests_to_try_can_be_done() -> None:
    """The edit is in a shader that the case uses, at one place; `watch` draws it once saved."""
    root = data_folder("shaders")
    shaders, tried = Shaders([root]), 0
    for case in cases():
        found = re.search(r"^Try: in (.*)", case.lesson, re.M | re.S)
        if found is None:
            continue
        tried += 1
        text = " ".join(found[0].split())
        edit = re.match(r"Try: in `([^`]+)` write `([^`]+)` for `([^`]+)`: .+\.$", text)
        assert edit is not None, case.id
        file, new, old = edit.groups()
        names = {n for scene in case.scenes() for p in scene.passes for d in p.draws
                 for n in d.shaders}  # fmt: skip
        used = {Path(path).resolve() for name in names for path, _ in shaders.load(name).parts}
        assert (root / file).resolve() in used, case.id
        assert (root / file).read_text(encoding="utf-8").count(old) == 1 and new != old, case.id
    assert tried >= 106
