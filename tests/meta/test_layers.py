"""Packages import only packages below them, and each foreign library has its owners."""

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

from tests.meta.packages import (
    ONLY,
    ORDER,
    PACKAGE,
    UPWARD,
    edges,
    imported_package,
    imports,
    sources,
)

# Who may import a foreign module that has an owner.
OWNERS: dict[str, set[str]] = {
    "moderngl": {"drivers"},
    "glcontext": {"drivers"},
    "OpenGL": {"drivers"},
    "vulkan": {"drivers"},
    "playwright": {"drivers"},
    "ctypes": {"drivers", "bands", "workers", "compiler"},
    "OpenImageIO": {"model"},
    "trimesh": {"assets"},
    "pypcd4": {"assets"},
    "jinja2": {"report"},
    "tree_sitter": {"analysis", "compiler", "drivers", "mutation"},
    "tree_sitter_glsl": {"compiler"},
    "click": {"cli"},
    "rich": {"cli"},
    "hypothesis": {"functions", "mutation"},
    "pytest": {"mutation", "pytest_plugin"},
}

# What only comes with an extra, by the name of that extra.
OPTIONAL = {
    "OpenImageIO": "images",
    "pypcd4": "models",
    "trimesh": "models",
    "pytest": "pytest",
    "hypothesis": "pytest",
    "vulkan": "vulkan",
    "playwright": "webgl",
}

CASES_MAY_IMPORT = {
    f"{PACKAGE}.engine.expectations",
    PACKAGE,
    f"{PACKAGE}.reference",
    f"{PACKAGE}.glslmath",
    f"{PACKAGE}.assets",
    "cases.scenes",
}
# What cases share is a step behind the scenes: types of the model, errors, the extra "course".
SCENES_MAY_IMPORT = {*CASES_MAY_IMPORT, f"{PACKAGE}.errors", f"{PACKAGE}.model"}
COURSE = {"colour", "etcpak", "flip_evaluator", "pyglm", "texture2ddecoder"}


def upward(found: Iterator[tuple[str, str, str]]) -> list[str]:
    """Of (package, imported package, place), those that lead up or to an unknown package."""
    known = {package: place for place, package in enumerate(ORDER)}
    return [
        f"{place}: {package} imports {other}"
        for package, other, place in found
        if known.get(other, len(ORDER)) >= known.get(package, -1) and (package, other) not in UPWARD
    ]


def test_every_package_is_in_the_table(repository: Path) -> None:
    assert {package for package, _, _ in sources(repository)} == set(ORDER)


def test_packages_import_only_packages_below(repository: Path) -> None:
    found = edges(repository)
    assert upward((r, o, place) for r in found for o, place in found[r].items()) == []


@pytest.mark.parametrize(("package", "allowed"), ONLY.items())
def test_a_package_that_needs_little_imports_nothing_else(
    repository: Path, package: str, allowed: set[str]
) -> None:
    assert set(edges(repository)[package]) <= allowed


def test_only_a_driver_s_own_folder_is_imported_by_name(repository: Path) -> None:
    """What speaks to a driver speaks to the protocol."""
    wrong = [
        f"{file}:{line}: {package} imports {module}"
        for package, file, lines in sources(repository)
        for line, module, _ in lines
        if re.match(rf"{PACKAGE}\.drivers\.(opengl|vulkan|webgl)", module) and package != "drivers"
    ]
    assert wrong == []


def test_foreign_libraries_stay_with_their_owners(repository: Path) -> None:
    wrong = [
        f"{file}:{line}: {package} imports {module}"
        for package, file, lines in sources(repository)
        for line, module, _ in lines
        if package not in OWNERS.get(module.split(".")[0], {package})
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
        allowed_modules = SCENES_MAY_IMPORT if scene else CASES_MAY_IMPORT
        foreign = {"numpy", *COURSE} if scene else {"numpy"}
        tree = ast.parse(file.read_text(encoding="utf-8"))
        for line, module, name in imports(tree, package):
            top = module.split(".")[0]
            if top in sys.stdlib_module_names or top in foreign:
                continue
            whole = f"{module}.{name}"
            allowed = whole in allowed_modules or any(
                module == known or (known != PACKAGE and module.startswith(known + "."))
                for known in allowed_modules
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
    ("package", "text", "wrong"),
    [
        ("compiler", "from ..drivers import opengl", True),
        (
            "compiler",
            "def f():\n    from shaderlab.engine.expectations.formula import formula",
            True,
        ),
        ("model", "from shaderlab import engine", True),
        ("model", "from shaderlab import Case", True),
        ("report", "import shaderlab.cli", True),
        ("errors", "import shaderlab.attic", True),
        ("drivers", "from ..compiler.compile import TARGETS", False),
        ("engine", "from ..model.scene import Scene", False),
    ],
)
def test_a_wrong_edge_would_be_noticed(package: str, text: str, wrong: bool) -> None:
    lines = imports(ast.parse(text), (PACKAGE, package))
    packages = ((imported_package(module, name), line) for line, module, name in lines)
    found = ((package, other, str(line)) for other, line in packages if other is not None)
    assert bool(upward(found)) is wrong
