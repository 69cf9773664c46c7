"""Rooms import only rooms below them, and foreign libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import importlib.metadata
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.meta.rooms import (
    ORDER,
    PACKAGE,
    documented,
    edges,
    imported_room,
    imports,
    sources,
    table,
)

# Who may import a foreign module that has an owner.
OWNERS: dict[str, set[str]] = {
    "moderngl": {"backends"},
    "glcontext": {"backends"},
    "OpenGL": {"backends"},
    "vulkan": {"backends"},
    "playwright": {"backends"},
    "ctypes": {"backends", "bands", "execution", "compiler"},
    "OpenImageIO": {"pictures"},
    "trimesh": {"assets"},
    "pypcd4": {"assets"},
    "jinja2": {"report"},
    "tree_sitter": {"code_coverage", "compiler", "mutation", "programs"},
    "tree_sitter_glsl": {"compiler"},
    "click": {"cli"},
    "rich": {"cli"},
    "hypothesis": {"function_tests", "functions"},
    "pytest": {"function_tests", "pytest_plugin"},
    "distributed": {"execution"},
    "dask": {"execution"},
    "pyarrow": {"report"},
    "watchfiles": {"watching"},
}

# What only comes with an extra, by the name of that extra.
OPTIONAL = {
    "distributed": "cluster",
    "dask": "cluster",
    "OpenImageIO": "images",
    "pypcd4": "models",
    "trimesh": "models",
    "pytest": "pytest",
    "hypothesis": "pytest",
    "pyarrow": "sweep",
    "watchfiles": "watch",
    "vulkan": "vulkan",
    "playwright": "webgl",
}

CASES_MAY_IMPORT = {
    f"{PACKAGE}.expectations",
    PACKAGE,
    f"{PACKAGE}.reference",
    f"{PACKAGE}.glslmath",
    f"{PACKAGE}.sampling",
    f"{PACKAGE}.assets",
    "cases.scenes",
}
# What cases share is a step behind the scenes: types of the model, errors, the extra "course".
SCENES_MAY_IMPORT = {*CASES_MAY_IMPORT, f"{PACKAGE}.errors", f"{PACKAGE}.model"}
COURSE = {"colour", "etcpak", "flip_evaluator", "pyglm", "texture2ddecoder"}


def upward(found: Iterator[tuple[str, str, str]]) -> list[str]:
    """Of (room, imported room, place), those that lead up or to a room that is not on the map."""
    known = {room: place for place, room in enumerate(ORDER)}
    return [
        f"{place}: {room} imports {other}"
        for room, other, place in found
        if known.get(other, len(ORDER)) >= known.get(room, -1)
    ]


def test_every_room_is_on_the_map(repository: Path) -> None:
    assert {room for room, _, _ in sources(repository)} == set(ORDER)


def test_rooms_import_only_rooms_below(repository: Path) -> None:
    found = edges(repository)
    assert upward((r, o, place) for r in found for o, place in found[r].items()) == []


def test_the_document_shows_the_real_imports(repository: Path) -> None:
    """`python -m tests.meta.rooms` writes the map anew."""
    assert documented(repository) == table(repository)


def test_only_a_backend_s_own_folder_is_imported_by_name(repository: Path) -> None:
    """What speaks to a backend speaks to the protocol."""
    wrong = [
        f"{file}:{line}: {room} imports {module}"
        for room, file, lines in sources(repository)
        for line, module, _ in lines
        if module.startswith(f"{PACKAGE}.backends.") and room != "backends"
    ]
    assert wrong == []


def test_foreign_libraries_stay_with_their_owners(repository: Path) -> None:
    wrong = [
        f"{file}:{line}: {room} imports {module}"
        for room, file, lines in sources(repository)
        for line, module, _ in lines
        if room not in OWNERS.get(module.split(".")[0], {room})
    ]
    assert wrong == []


def declared(repository: Path, extra: str = "") -> set[str]:
    """The distributions that pyproject.toml asks for itself, or with an extra."""
    data = tomllib.loads((repository / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = data["optional-dependencies"][extra] if extra else data["dependencies"]
    return {canonicalize_name(Requirement(line).name) for line in lines}


def test_every_foreign_library_is_a_declared_dependency(repository: Path) -> None:
    providers = importlib.metadata.packages_distributions()
    known = declared(repository)
    for _, file, lines in sources(repository):
        for line, module, _ in lines:
            top = module.split(".")[0]
            if top == PACKAGE or top in sys.stdlib_module_names or top in OPTIONAL:
                continue
            from_ = {canonicalize_name(name) for name in providers.get(top, [])}
            assert from_ & known, f"{file}:{line}: {top} is no dependency in pyproject.toml"


def test_every_optional_library_belongs_to_an_extra_and_to_no_other_need(
    repository: Path,
) -> None:
    providers = importlib.metadata.packages_distributions()
    for module, extra in {**OPTIONAL, **dict.fromkeys(COURSE, "course")}.items():
        # What a backend is made with only where its drivers are goes by one name everywhere.
        from_ = {canonicalize_name(name) for name in providers.get(module, [module])}
        assert from_ & declared(repository, extra), module
        assert not from_ & declared(repository), module


def test_cases_use_only_what_any_reader_may(repository: Path) -> None:
    for file in sorted((repository / "cases").rglob("*.py")):
        package = file.parent.relative_to(repository).parts
        scene = package == ("cases", "scenes")
        known_rooms = SCENES_MAY_IMPORT if scene else CASES_MAY_IMPORT
        foreign = {"numpy", *COURSE} if scene else {"numpy"}
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for line, module, name in imports(tree, package):
            top = module.split(".")[0]
            if top in sys.stdlib_module_names or top in foreign:
                continue
            whole = f"{module}.{name}"
            allowed = whole in known_rooms or any(
                module == known or (known != PACKAGE and module.startswith(known + "."))
                for known in known_rooms
            )
            assert allowed, f"{file}:{line}: a case imports {whole}"


def test_the_engine_names_nothing_of_the_course(repository: Path) -> None:
    """Neither its folders of shaders nor its shared scenes nor its chapters."""
    chapters = tomllib.loads((repository / "cases" / "cases.toml").read_text())["chapters"]
    words = [r"\bch\d\d_", r"\bcases[./]scenes\b", *(f'"{title}"' for title in chapters.values())]
    found = [
        f"{file}: {match.group()}"
        for file in sorted((repository / PACKAGE).rglob("*"))
        if file.suffix in (".py", ".j2", ".js", ".css") and "_data" not in file.parts
        for match in re.finditer("|".join(words), file.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("room", "text", "wrong"),
    [
        ("compiler", "from ..backends import opengl", True),
        (
            "compiler",
            "def f():\n    from shaderlab.engine.expectations.formula import formula",
            True,
        ),
        ("model", "from shaderlab import evaluation", True),
        ("model", "from shaderlab import Case", True),
        ("report", "import shaderlab.cli", True),
        ("errors", "import shaderlab.attic", True),
        ("backends", "from ..compiler.compile import TARGETS", False),
        ("evaluation", "from ..expectations.base import Context", False),
    ],
)
def test_a_wrong_edge_would_be_noticed(room: str, text: str, wrong: bool) -> None:
    lines = imports(ast.parse(text), (PACKAGE, room))
    rooms = ((imported_room(module, name), line) for line, module, name in lines)
    found = ((room, other, str(line)) for other, line in rooms if other is not None)
    assert bool(upward(found)) is wrong
