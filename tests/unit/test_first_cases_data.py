"""Case files are pure data, their figures follow from their references, their shaders compile."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.shipped import load_cases
from shaderlab.compiler import Shaders
from shaderlab.compiler.glslang import GLSLANG_WHEEL, find
from shaderlab.engine.expectations.exact import Exact
from shaderlab.engine.expectations.figures import Computed, Value
from shaderlab.engine.expectations.rejections import CompileFails
from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import Frame

ROOT = Path(__file__).resolve().parents[2]
SHADERS = ROOT / "shaders"
LIBRARIES = find(GLSLANG_WHEEL, "libglslang.so").parent
GLSLANG = LIBRARIES.parent / "bin" / "glslangValidator"

FIRST = {
    "ch01_setup": ["orange_triangle"],
    "ch02_basics": ["indexed_quad", "texture_mix", "uniform_over_time"],
    "ch03_transforms": ["mvp"],
    "ch05_lighting": ["attenuation", "blinn_phong", "gamma", "spotlight"],
    "ch06_tests": ["blend_equation", "depth_functions", "stencil_functions"],
}
FILES = [
    ROOT / "cases" / folder / f"{stem}.py" for folder, stems in FIRST.items() for stem in stems
]
CASES = load_cases(FILES)
STAGES = sorted(
    {
        shader
        for case in CASES.values()
        for scene in case.scenes()
        for rendering in scene.passes
        for draw in rendering.draws
        for shader in draw.shaders
    }
)

each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


def scenes() -> Iterator[Scene]:
    for case in CASES.values():
        yield from case.scenes()


def compiled(path: Path) -> tuple[int, list[tuple[int, str]]]:
    """glslangValidator's exit status and its error messages by line, as the lab words them:
    without an empty token in front, and without the closing "compilation terminated"."""
    env = {**os.environ, "LD_LIBRARY_PATH": str(LIBRARIES)}
    done = subprocess.run([GLSLANG, path], env=env, capture_output=True, text=True, check=False)
    found = re.findall(r"^ERROR: \d+:(\d+): (?:'' : +)?(.*?) *$", done.stdout, re.M)
    told = [(int(line), message) for line, message in found if "terminated" not in message]
    return done.returncode, told


def test_importing_all_cases_touches_no_device() -> None:
    program = (
        "import sys; from pathlib import Path; from benchmarks.shipped import load_cases;"
        f"load_cases([Path(p) for p in {[str(f) for f in FILES]!r}]);"
        "print(sorted({'moderngl', 'OpenGL', 'colour', 'OpenImageIO'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.stdout.strip() == "[]"


@each_case
def test_a_case_tells_its_lesson(case: Case) -> None:
    assert case.lesson.count("\n") >= 4
    assert "Look at:" in case.lesson
    assert re.fullmatch(r"\d+(\.\d+)+", case.section)
    assert case.math


@each_case
def test_a_case_has_the_shaders_it_names(case: Case) -> None:
    for scene in case.scenes():
        for draw in (draw for p in scene.passes for draw in p.draws):
            for name in draw.shaders:
                assert (SHADERS / name).is_file(), name


@each_case
def test_errata_name_their_proof(case: Case) -> None:
    names = {e.name for scene in case.scenes() for e in scene.expect}
    assert {erratum.proof for erratum in case.errata} <= names


@pytest.mark.parametrize("name", STAGES)
def test_shaders_compile(name: str, tmp_path: Path) -> None:
    source = Shaders([SHADERS]).load(name)
    file = tmp_path / Path(name).name
    file.write_text(source.text)
    assert compiled(file) == (0, [])
    assert source.text.startswith("#version 330 core\n")


def refusals() -> list[CompileFails]:
    return [e for case in CASES.values() for e in case.expect if isinstance(e, CompileFails)]


@pytest.mark.parametrize("expectation", refusals(), ids=lambda e: e.shaders[0])
def test_what_must_not_compile_does_not(expectation: CompileFails) -> None:
    status, messages = compiled(SHADERS / expectation.shaders[0])
    assert status != 0
    assert messages == [(line, text) for _, line, text in expectation.messages]


def test_every_broken_shader_is_shown() -> None:
    broken = {p.relative_to(SHADERS).as_posix() for p in SHADERS.glob("ch0[1-6]*/errata/*")}
    assert broken >= {e.shaders[0] for e in refusals()}
    assert len(refusals()) == 3


FIGURES = [
    pytest.param(e, id=f"{scene.case.id} {scene.variant} {e.name}")
    for scene in scenes()
    for e in scene.expect
    if isinstance(e, Computed)
]


@pytest.mark.parametrize("figure", FIGURES)
def test_figures_that_no_shader_draws(figure: Computed) -> None:
    scene = next(CASES["attenuation"].scenes())  # any: it needs nothing of a scene
    nothing = Frame(images={}, order=(), bindings={})
    assert figure.judge(scene, nothing).outcome.status == "pass"


def test_attenuation_has_all_its_figures() -> None:
    """Twelve rows with three figures each, digits as in the table."""
    values = [
        [e for e in scene.expect if isinstance(e, Value)] for scene in CASES["attenuation"].scenes()
    ]
    assert len(values) == 12
    assert all([e.digits for e in row] == [9, 6, 6] for row in values)


def table(case: Case) -> Any:
    """The expected table of a case, which is its first exact expectation."""
    expectation = next(e for e in case.expect if isinstance(e, Exact))
    return expectation.equals


def test_truth_tables_are_complete() -> None:
    depth, stencil = (table(CASES[f"{name}-functions"]) for name in ("depth", "stencil"))
    assert depth.shape == (3, 8, 1)
    # Nearer, equal and farther pass in four of the eight functions each.
    assert depth.sum(axis=1).ravel().tolist() == [4.0, 4.0, 4.0]

    assert stencil.shape == (16, 32, 1)
    # Function by function, at mask 0, all sixteen fields of a block are alike.
    blocks = stencil[:4, :, 0].reshape(4, 8, 4)
    assert np.array_equal(blocks.min(axis=(0, 2)), blocks.max(axis=(0, 2)))
    assert blocks[0, :, 0].tolist() == [0, 0, 1, 1, 0, 0, 1, 1]
    # With the full mask LESS holds below the diagonal: 6 of 16.
    assert stencil[12:, 4:8].sum() == 6.0


def test_uniform_over_time_shows_the_notes_moments() -> None:
    times = [scene.changes["time"] for scene in CASES["uniform-over-time"].scenes()]
    *notes, near = times  # the last one is for the bead, from near by
    assert notes == [0.0, 1.0, 2.0, 3.0, np.pi / 2, 3 * np.pi / 2] and near == 2.5
