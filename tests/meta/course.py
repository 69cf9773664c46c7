"""The page of the course: section of the notes, what is proved, by which expectations.

`python -m tests.meta.course` writes it from the cases; a test holds both equal.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from shaderlab.engine.catalogue import TREE_FILE, data_folder
from tests.catalogue import shipped

if TYPE_CHECKING:
    from shaderlab.model.case import Case

PAGE = "docs/guide/course.md"
_MADE = "<!-- Made by `python -m tests.meta.course`; do not edit. -->"
_TEXT = """\
# The course

The lessons follow a set of study notes on OpenGL, section by section. Each line names a lesson, its
law, and how many [expectations](expectations.md) fail where the law does not hold; "also" is what
it proves besides. An erratum states what is true where that text is wrong.
`shaderlab run ID` judges all of this, and shows which expectation proves an erratum.
"""

SECTIONS: Mapping[str, str] = {
    number: title
    for number, (title, _) in tomllib.loads(
        (data_folder("cases") / TREE_FILE).read_text(encoding="utf-8")
    )["sections"].items()
}
"""Sections of the notes with something to prove, and what each is about."""

WITHIN: Mapping[tuple[str, str], tuple[str, tuple[str, ...]]] = {
    ("2.2.2", "interleaved-attributes"): (
        "Normalised attributes, and those that are not enabled",
        (
            "bytes that are normalised: 0…255 is 0…1",
            "bytes that are not: 64 is 64",
            "an attribute that is not enabled is the same for all vertices",
            "and (0, 0, 0) at first",
        ),
    ),
    ("2.4.2", "texture-wrap"): (
        "Textures in three dimensions",
        ("three dimensions, mirrored_repeat, linear", "no image in two dimensions fits it: 0x0500"),
    ),
    ("10", "buffer-map"): (
        "Textures from buffers of pixels",
        ("texels from a buffer", "written", "then read"),
    ),
    ("10", "buffer-subdata"): (
        "Buffers of pixels",
        ("pixels are read into a buffer", "a texture is filled from byte 4 of a buffer"),
    ),
    ("10", "points-and-elements"): (
        "Indices of one, two and four bytes",
        (
            "seven indices of a byte",
            "indices of GL_BYTE",
            "the fourth byte is the index 2, whose colour is cyan",
        ),
    ),
    ("10", "mesh-class"): (
        "Deleting",
        (
            "deleted: none",
            "what is deleted is not bound any more",
            "a program that is deleted while it is used lives on",
            "until another one is used",
        ),
    ),
    ("2.3.4", "uniform-types"): (
        "Uniforms need a program, and stay with it",
        ("no program: 0x0502", "what was sent stays with the program", "before that it is 0"),
    ),
    ("4.4", "mvp"): (
        "Perspective by six planes",
        (
            "six planes: the window's lower left",
            "six planes: the window's upper right",
            "six planes: behind it on the far plane",
            "six planes: straight ahead is aside",
        ),
    ),
    ("7.4.1", "cubemap"): (
        "A cube of six files, each upright",
        ("six files: texels of another face, column or row",),
    ),
    ("8.2", "framebuffer-renderbuffer"): (
        "How many colours a framebuffer takes",
        ("a framebuffer takes eight colours or more",),
    ),
}
"""What a lesson proves beside its own law: by section and lesson, and by which expectations."""


LEFT_OUT: Mapping[str, str] = {
    "1.1": "Left out: Visual Studio. `shaderlab doctor` checks what the lab itself needs.",
    "1.2.1": "Left out: GLFW and GLAD. The lab opens a context without a window, by EGL, and "
    "moderngl loads OpenGL's functions.",
    "1.2.2": "Left out: the window's loop (keys, sizes, swapping). What it draws is judged.",
    "4.2": "Left out: installing GLM, a C++ library. Its Python twin PyGLM is the second opinion "
    "on the transforms of chapters 3 and 4.",
    "11.1": "Left out: the window and its pixel format. `double-buffer` and `window-origin` have "
    "targets instead.",
    "13.2": "Left out: the C++ project. OpenImageIO loads images in `image-file` and `cubemap`.",
    "14.1": "Left out: the C++ project. The lab reads PCD files itself in `point-cloud`.",
}
"""What of a section no lesson shows, and why."""


def page() -> str:
    """The page's text."""
    parts = [_TEXT, _MADE, ""]
    for section, title in SECTIONS.items():
        parts += [f"## {section} · {title}", ""]
        parts += [LEFT_OUT[section], ""] if section in LEFT_OUT else []
        found = [
            f"- {lesson}: {what}" + (f" ({by})" if by.isdigit() else "")
            for lesson, what, by in rows(section)
        ]
        parts += [*found, ""] if found else []
    return "\n".join(parts).rstrip() + "\n"


def rows(section: str) -> Iterator[tuple[str, str, str]]:
    """The lessons of a section: which, what is proved, by which expectations."""
    for case in sorted(shipped().values(), key=lambda c: c.file):
        if case.section == section:
            yield f"`{case.id}`", _plain(_law(case)), str(len(names_of(case)))
    for case in sorted(shipped().values(), key=lambda c: c.file):
        for erratum in case.errata:
            if (erratum.section or case.section) == section:
                yield f"`{case.id}`, erratum", _plain(erratum.truth), _plain(erratum.proof)
    for (of, lesson), (what, names) in WITHIN.items():
        if of == section:
            yield f"`{lesson}`, also", _plain(what), _plain("; ".join(names))


def names_of(case: Case) -> list[str]:
    """The names of a case's expectations, each once."""
    found = (expectation.name for scene in case.scenes() for expectation in scene.expect)
    return list(dict.fromkeys(found))


def _law(case: Case) -> str:
    """The first sentence of the lesson, without a title that the section or the id repeats."""
    first = " ".join(case.lesson.split("\n\n")[0].split()).rstrip(".")
    title, colon, law = first.partition(": ")
    known = f"{case.id} {SECTIONS.get(case.section, '')}".lower()
    if colon and all(word in known for word in re.findall(r"\w+", title.lower())):
        return law[0].upper() + law[1:]
    return first


def _plain(text: str) -> str:
    """Text without markup."""
    return re.sub(r"([|*_<`\[\]])", r"\\\1", text)


if __name__ == "__main__":
    path = Path(__file__).resolve().parents[2] / PAGE
    path.write_text(page(), encoding="utf-8")
