"""The packages of shaderlab from bottom to top, and the imports between them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = "shaderlab"

# Bottom to top: a package may import those before it.
ORDER = (
    "errors", "files", "model", "workers", "bands", "compiler", "glslmath", "assets", "reference",
    "drivers", "report", "engine", "analysis", "functions", "glsl", "pytest_plugin",
    "mutation", "cli", "__main__", "__init__",
)  # fmt: skip

# Packages that may import these alone, wherever they stand.
ONLY = {
    "report": {"errors", "files", "model"},
    "workers": {"errors", "files", "model"},
}

# Edges that lead up and still have to go.
UPWARD: set[tuple[str, str]] = set()

Import = tuple[int, str, str]


def imports(tree: ast.AST, package: tuple[str, ...]) -> Iterator[Import]:
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


@cache
def sources(repository: Path) -> list[tuple[str, Path, list[Import]]]:
    """Each module of the package: its package, its file, its imports."""
    found = []
    for file in sorted((repository / PACKAGE).rglob("*.py*")):
        inside = file.relative_to(repository).with_suffix("").parts
        if "_data" in inside or file.suffix not in (".py", ".pyi"):
            continue
        folder = inside[:-1]
        tree = ast.parse(file.read_text(encoding="utf-8"))
        package = _package_of(folder if inside[-1] == "__init__" else inside)
        found.append((package, file, list(imports(tree, folder))))
    return found


def imported_package(module: str, name: str) -> str | None:
    """The package that an import leads into, or None for a foreign one."""
    parts = tuple(module.split("."))
    if parts[0] != PACKAGE:
        return None
    if len(parts) == 1 and name in ORDER:
        return name
    return _package_of(parts)


def edges(repository: Path) -> dict[str, dict[str, str]]:
    """The packages that each package imports, with a place ("file:line") where it does."""
    found: dict[str, dict[str, str]] = {}
    for package, file, lines in sources(repository):
        others = found.setdefault(package, {})
        for line, module, name in lines:
            other = imported_package(module, name)
            if other is not None and other != package:
                others.setdefault(other, f"{file.relative_to(repository)}:{line}")
    return found


def _package_of(parts: tuple[str, ...]) -> str:
    return parts[1] if len(parts) > 1 else "__init__"
