"""Rooms import only rooms below them, and foreign libraries stay in the rooms that own them."""

from __future__ import annotations

import ast
import importlib.metadata
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PACKAGE = "shaderlab"

# Bottom to top. A room may import those it lists, each of which must stand above it here.
ROOMS: dict[str, set[str]] = {
    "errors": set(),
    "files": {"errors"},
    "activity": set(),
    "packages": set(),
    "options": set(),
    "records": set(),
    "frame": {"errors"},
    "bands": {"errors"},
    "sampling": {"errors", "bands", "frame"},
    "glslmath": {"errors", "bands", "frame", "sampling"},
    "pictures": {"errors", "files"},
    "model": {"errors", "bands"},
    "assets": {"errors", "model", "pictures"},
    "reference": {"errors", "bands", "glslmath", "assets"},
    "glsl": {"errors", "files", "records"},
    "checks": {
        "errors", "activity", "records", "frame", "bands", "sampling", "glslmath", "model",
        "reference",
    },
    "programs": {"errors", "frame", "model", "glsl", "pictures"},
    "backends": {"errors", "activity", "records", "frame", "model", "glsl", "programs"},
    "discovery": {"errors"},
    "catalogue": {"errors", "model", "discovery"},
    "pipeline": {
        "errors", "files", "activity", "packages", "records", "frame", "bands", "sampling",
        "glslmath", "pictures", "model",
        "assets", "reference", "glsl", "checks", "programs", "backends", "discovery",
        "options",
    },
    "workers": {"errors", "records", "model", "catalogue", "pipeline"},
    "mutation": {
        "errors", "frame", "model", "glsl", "checks", "programs", "discovery", "catalogue",
        "pipeline",
    },
    "report": {"errors", "files", "records", "pictures"},
    "running": {
        "errors", "files", "options", "packages", "records", "frame", "model", "backends",
        "discovery", "catalogue", "pipeline", "workers", "report",
    },
    "doctor": {"errors", "glsl", "backends", "discovery"},
    "pytest_plugin": {
        "errors", "records", "discovery", "running", "report",
    },
    "cli": {
        "errors", "files", "records", "model", "glsl", "discovery", "catalogue", "pipeline",
        "workers", "mutation", "report", "running", "doctor",
    },
    "__main__": {"cli"},
    "__init__": {"errors", "bands", "model"},
}  # fmt: skip

# Who may import a foreign module that has an owner.
OWNERS: dict[str, set[str]] = {
    "moderngl": {"backends"},
    "glcontext": {"backends"},
    "OpenGL": {"backends"},
    "ctypes": {"backends", "bands", "glsl", "workers"},
    "OpenImageIO": {"pictures"},
    "trimesh": {"assets"},
    "pypcd4": {"assets"},
    "jinja2": {"report"},
    "tree_sitter": {"mutation"},
    "tree_sitter_glsl": {"mutation"},
    "click": {"cli"},
    "rich": {"cli"},
    "pytest": {"pytest_plugin"},
    "distributed": {"running"},
    "dask": {"running"},
    "pyarrow": {"report"},
}

# What only comes with an extra, by the name of that extra.
OPTIONAL = {
    "distributed": "cluster",
    "dask": "cluster",
    "pypcd4": "models",
    "trimesh": "models",
    "pytest": "pytest",
    "pyarrow": "sweep",
}

CASES_MAY_IMPORT = {
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


def imports(tree: ast.AST, package: tuple[str, ...]) -> Iterator[tuple[int, str, str]]:
    """All imports below `tree`, those inside functions too, as (line, module, name).

    `package` is what relative imports start from; `name` is "" for `import module`.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name, ""
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                yield node.lineno, module, alias.name


def room_of(parts: tuple[str, ...]) -> str:
    return parts[1] if len(parts) > 1 else "__init__"


def sources(repository: Path) -> Iterator[tuple[str, Path, list[tuple[int, str, str]]]]:
    """Each module of the package: its room, its file, its imports."""
    for file in sorted((repository / PACKAGE).rglob("*.py")):
        inside = file.relative_to(repository).with_suffix("").parts
        if "_data" in inside:
            continue
        package = inside[:-1]
        tree = ast.parse(file.read_text(encoding="utf-8"))
        room = room_of(package if inside[-1] == "__init__" else inside)
        yield room, file, list(imports(tree, package))


def imported_room(module: str, name: str) -> str | None:
    """The room that an import leads into, or None for a foreign one."""
    parts = tuple(module.split("."))
    if parts[0] != PACKAGE:
        return None
    if len(parts) == 1 and name in ROOMS:
        return name
    return room_of(parts)


def wrong_edges(found: Iterator[tuple[str, Path, list[tuple[int, str, str]]]]) -> list[str]:
    wrong = []
    for room, file, lines in found:
        for line, module, name in lines:
            other = imported_room(module, name)
            if other is not None and other != room and other not in ROOMS.get(room, set()):
                wrong.append(f"{file}:{line}: {room} imports {other}")
    return wrong


def test_the_map_itself_only_points_down() -> None:
    order = list(ROOMS)
    for room, below in ROOMS.items():
        for other in below:
            assert order.index(other) < order.index(room), f"{room} → {other}"


def test_every_room_is_on_the_map(repository: Path) -> None:
    assert {room for room, _, _ in sources(repository)} <= set(ROOMS)


def test_rooms_import_only_rooms_below(repository: Path) -> None:
    assert wrong_edges(sources(repository)) == []


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
        from_ = {canonicalize_name(name) for name in providers[module]}
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


@pytest.mark.parametrize(
    ("room", "text", "wrong"),
    [
        ("glsl", "from ..backends import opengl", True),
        ("glsl", "def f():\n    from shaderlab.checks.judge import judge", True),
        ("model", "from shaderlab import pipeline", True),
        ("model", "from shaderlab import Case", True),
        ("report", "import shaderlab.backends.opengl.device", True),
        ("backends", "from ..glsl.compile import TARGETS", False),
        ("backends", "from .opengl.state import apply", False),
        ("backends", "import numpy", False),
    ],
)
def test_a_wrong_edge_would_be_noticed(room: str, text: str, wrong: bool) -> None:
    lines = list(imports(ast.parse(text), (PACKAGE, room)))
    assert bool(wrong_edges(iter([(room, Path("x.py"), lines)]))) is wrong
