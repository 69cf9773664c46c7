"""What the lessons say about the notes they follow: each claim has a row, each row a claim.

The notes are not part of this project, so no test can look into them. A row says where in them a
claim was found (or that it is not there), by whoever read them; a claim without a row fails.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from shaderlab.engine.catalogue import data_folder
from tests.catalogue import shipped

ROOT = Path(__file__).parents[2]
QUOTED, DERIVED, OURS = "quoted", "derived", "ours"
"""It stands in the notes; it follows from what stands there; it does not, and the claim says so."""

ERRATA = """
orange-triangle    1.2.2  quoted   #version 330_core
orange-triangle    1.2.2  quoted   ends in }0
orange-triangle    1.1    derived  C4005
glsl-types         2.3.2  quoted   has dvecn
mipmap-chain       2.4.4  quoted   glGenerateMipmaps
texture-filter     2.4.3  quoted   default filter
texture-mix        2.4.6  quoted   at most 16 textures
texture-origin     2.4.1  quoted   lower left corner
mvp                3.4    quoted   aspect ratio
rotate             3.2    quoted   equation 3.4
transform-order    3.4    quoted   scale → rotate → translate
transform-order    4.2    quoted   glm::mat4 model;
translate          3.1    quoted   a vector has w = 0
coordinate-spaces  4.1    quoted   −1 … 1
look-at            4.3    quoted   glm::vec(…)
attenuation        5.5.2  quoted   maximum distance
blinn-phong        5.9.1  quoted   max(N·H, 0)
diffuse            5.2.2  quoted   Normal = aNormal
multiple-lights    5.6    quoted   vec3 output;
normal-map         5.10   quoted   bump mapping
shadow-map         5.9.1  quoted   0.15 · color
shadow-map         5.9.1  quoted   GL_REPEAT
shadow-map         5.9.1  quoted   up = (1, 1, 1)
specular           5.2.3  quoted   max(R·V, 0)ˢ
specular           5.2.3  quoted   the light's colour
specular           5.2.3  quoted   from everywhere
spotlight          5.5.3  quoted   cos φ = 0.9978
spotlight          5.5.3  quoted   = 0.0448
depth-precision    6.2.2  quoted   from 1 to 2
depth-precision    6.2.2  quoted   from 50 to 100
depth-precision    6.2    quoted   a float of 16 or 24 bits
stencil-functions  6.1.1  quoted   mask of 0
face-culling       8.1    quoted   glFrontFace(GL_CCW)
buffer-map         10     quoted   before glMapBuffer
buffer-subdata     10     quoted   only two targets
buffer-usage       10     quoted   GL_STATIC_DRAW
buffer-usage       10     quoted   for PBOs and FBOs only
buffer-usage       10     quoted   main memory
mesh-class         10     quoted   class Mesh
points-and-elements 10    quoted   glIndexPointer
skybox             7.4.2  quoted   view matrix as it is
"""
"""Each erratum: case, section of the notes, kind of the claim, words of what the notes say."""

MENTIONS = """
cases/cases.toml                         1      derived  a set of Chinese study notes on OpenGL
cases/cases.toml                         15     ours     "Beyond the notes"
cases/cases.toml                         15     ours     begin where the notes end
cases/ch01_setup/orange_triangle.py      1.2.2  quoted   as it stands in the notes
cases/ch01_setup/orange_triangle.py      1.2.2  derived  Most likely lost when the notes were
cases/ch01_setup/orange_triangle.py      1.2.2  derived  Most likely added when the notes were
cases/ch02_basics/glsl_types.py          2.3.2  quoted   which the notes' shaders
cases/ch03_transforms/mvp.py             3.4    quoted   matrices are those of the notes
cases/ch04_spaces/coordinate_spaces.py   4.1    quoted   The notes name five
cases/ch05_lighting/directional_light.py 5.5.1  quoted   (−0.2, −1, −0.3) in the notes
cases/ch05_lighting/spotlight.py         5.5.3  quoted   and what the notes print
cases/ch05_lighting/spotlight.py         5.5.3  quoted   the notes print {printed}
cases/ch05_lighting/spotlight.py         5.5.3  quoted   the notes' figure
cases/ch05_lighting/spotlight.py         5.5.3  derived  the notes took of radians
cases/ch05_lighting/spotlight.py         5.5.3  quoted   the notes' 0.9978
cases/ch08_techniques/post_grayscale.py  8.2.3  ours     The notes have the mean alone
cases/ch08_techniques/post_kernels.py    8.2.3  ours     The notes name no kernel
cases/scenes/waves.py                    2.3.4  quoted   section 2.3.4 of the notes
shaders/lib/lights.glsl                  5.6    ours     The notes only have a call of it
"""
"""Each place where a case or a shader speaks of the notes: file, section, kind, words around it."""

DOCS = """
README.md             a set of OpenGL study notes
README.md             Where the notes are wrong
docs/README.md        of each section of the notes
docs/guide/course.md  a set of study notes on OpenGL
docs/guide/report.md  where the notes are wrong
"""
"""Each place where the docs or the page speak of the notes as a whole: file, words around it."""

NAMES = """
shaders/ch05_lighting/multiple_lights.frag   5.6    CalcDirLight CalcPointLight CalcSpotLight
shaders/ch05_lighting/directional_light.frag 5.6    CalcDirLight
shaders/ch05_lighting/point_light.frag       5.6    CalcPointLight
shaders/ch05_lighting/shadow_map.frag        5.9.1  ShadowCalculation
shaders/ch05_lighting/material.frag          5.3    Material material Light light
shaders/ch05_lighting/lighting_maps.frag     5.4    Material material
shaders/ch05_lighting/spotlight_hard.frag    5.5.3  cutOff theta
shaders/lib/spotlight.glsl                   5.5.3  cutOff outerCutOff theta
shaders/ch02_basics/sampler_units.frag       2.3.4  BaseMap ReflectMap RefractMap
shaders/ch02_basics/uniform_over_time.frag   2.3.4  ourColor
shaders/ch02_basics/swizzle.frag             2.3.2  someVec differentVec anotherVec otherVec
shaders/ch08_techniques/uniform_buffer.vert  8.4    Matrices projection view
"""
"""Names that the notes give, in the shader of the lesson that shows them."""

_TEXTS = (".py", ".toml", ".frag", ".vert", ".geom", ".glsl")
_NOTES = re.compile(r"\b[Nn]otes\b(?!:)")
_SECTION = re.compile(r"\d+(\.\d+)*")


def rows(table: str) -> list[list[str]]:
    return [line.split(maxsplit=3) for line in table.strip().splitlines()]


def mentions() -> Iterator[tuple[str, str]]:
    """Each place where a case or a shader speaks of the notes: its file, the text around it."""
    for kind in ("cases", "shaders"):
        root = data_folder(kind)
        for path in sorted(root.rglob("*")):
            if path.is_dir() or path.suffix not in _TEXTS:
                continue
            text = path.read_bytes().decode("utf-8", "replace")
            text = re.sub(r'"\s*\n\s*f?"|\s*\n\s*(//|#)?\s*', " ", text).replace("  ", " ")
            for found in _NOTES.finditer(text.replace("release notes", "")):
                around = text.replace("release notes", "")[found.start() - 60 : found.end() + 60]
                yield f"{kind}/{path.relative_to(root).as_posix()}", around


def test_each_erratum_is_a_row_and_each_row_an_erratum() -> None:
    errata = [
        (case.id, erratum.section or case.section, erratum.says)
        for case in shipped().values()
        for erratum in case.errata
    ]
    table = rows(ERRATA)
    without = [
        (id, section, says)
        for id, section, says in errata
        if sum(row[:2] == [id, section] and row[3] in says for row in table) != 1
    ]
    assert without == [] and len(table) == len(errata)


def test_where_a_lesson_speaks_of_the_notes_there_is_a_row() -> None:
    table, used = rows(MENTIONS), Counter[str]()
    without = []
    for file, around in mentions():
        fitting = [row for row in table if row[0] == file and row[3] in around]
        used.update(" ".join(row) for row in fitting)
        without += [] if fitting else [(file, around)]
    assert without == []
    assert {" ".join(row) for row in table} == set(used), "a row without its claim"


def test_the_docs_and_the_page_say_no_more_of_the_notes_than_that_the_course_follows_them() -> None:
    table = [row.split(maxsplit=1) for row in DOCS.strip().splitlines()]
    files = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    files += (ROOT / "shaderlab" / "report").rglob("*.j2")
    found = []
    for path in files:
        written, _, _ = path.read_text(encoding="utf-8").partition("<!-- Made by")  # of the cases
        text, file = " ".join(written.split()), path.relative_to(ROOT).as_posix()
        for told in re.finditer(r"\b([Tt]he notes|study notes)\b(?!:)", text):
            around = text[max(told.start() - 60, 0) : told.end() + 60]
            found.append(
                next((r for r in table if r[0] == file and r[1] in around), [file, around])
            )
    assert sorted(found) == sorted(table)


def test_rows_name_a_section_and_a_kind() -> None:
    for _, section, kind, _ in rows(ERRATA) + rows(MENTIONS):
        assert _SECTION.fullmatch(section) and kind in (QUOTED, DERIVED, OURS)


def test_shaders_have_the_names_that_the_notes_give() -> None:
    for file, _, names in (line.split(maxsplit=2) for line in NAMES.strip().splitlines()):
        kind, _, below = file.partition("/")
        text = (data_folder(kind) / below).read_text(encoding="utf-8")
        missing = [name for name in names.split() if not re.search(rf"\b{name}\b", text)]
        assert missing == [], file
