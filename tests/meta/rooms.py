"""The map of the rooms: what each is for and which it imports, read from the code.

`python -m tests.meta.rooms` writes it into docs/internals/architecture.md; a test holds both equal.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = "shaderlab"
DOCUMENT = "docs/internals/architecture.md"
BEGIN, END = "<!-- rooms: generated -->", "<!-- end of rooms -->"

# Bottom to top: a room may import those before it.
ORDER = (
    "errors", "files", "activity", "packages", "module_path", "options",
    "observations", "records", "frame", "bands", "sampling", "glslmath", "pictures", "model",
    "assets", "reference",
    "compiler", "interpreter", "equivalence", "audit", "programs", "backends", "judging",
    "expectations", "discovery", "settings", "catalogue", "evaluation", "report", "execution",
    "mutation", "code_coverage", "functions", "glsl",
    "pytest_plugin", "function_tests", "watching", "doctor", "cli", "__main__", "__init__",
)  # fmt: skip

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
    """Each module of the package: its room, its file, its imports."""
    found = []
    for file in sorted((repository / PACKAGE).rglob("*.py*")):
        inside = file.relative_to(repository).with_suffix("").parts
        if "_data" in inside or file.suffix not in (".py", ".pyi"):
            continue
        package = inside[:-1]
        tree = ast.parse(file.read_text(encoding="utf-8"))
        room = _room_of(package if inside[-1] == "__init__" else inside)
        found.append((room, file, list(imports(tree, package))))
    return found


def imported_room(module: str, name: str) -> str | None:
    """The room that an import leads into, or None for a foreign one."""
    parts = tuple(module.split("."))
    if parts[0] != PACKAGE:
        return None
    if len(parts) == 1 and name in ORDER:
        return name
    return _room_of(parts)


def edges(repository: Path) -> dict[str, dict[str, str]]:
    """The rooms that each room imports, with a place ("file:line") where it does."""
    found: dict[str, dict[str, str]] = {}
    for room, file, lines in sources(repository):
        others = found.setdefault(room, {})
        for line, module, name in lines:
            other = imported_room(module, name)
            if other is not None and other != room:
                others.setdefault(other, f"{file.relative_to(repository)}:{line}")
    return found


def table(repository: Path) -> str:
    """The map as Markdown, bottom to top."""
    found = edges(repository)
    lines = ["| room | what is inside | imports |", "|---|---|---|"]
    for room in ORDER:
        if room.startswith("__"):
            continue
        others = [other for other in ORDER if other in found.get(room, {})]
        lines.append(f"| `{room}` | {_purpose(repository, room)} | {', '.join(others) or '–'} |")
    return "\n".join(lines)


def documented(repository: Path) -> str:
    """The map as it stands in the document."""
    text = (repository / DOCUMENT).read_text(encoding="utf-8")
    return text.partition(BEGIN)[2].partition(END)[0].strip()


def main() -> None:
    """Write the map into the document."""
    repository = Path(__file__).resolve().parents[2]
    path = repository / DOCUMENT
    head, begin, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    tail = rest.partition(END)[2]
    whole = f"{head}{begin}\n\n{table(repository)}\n\n{END}{tail}"
    path.write_text(whole, encoding="utf-8")


def _room_of(parts: tuple[str, ...]) -> str:
    return parts[1] if len(parts) > 1 else "__init__"


def _purpose(repository: Path, room: str) -> str:
    """The first sentence of a room's own docstring, as a table has it."""
    folder = repository / PACKAGE / room
    file = folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    first = " ".join(text.partition("\n\n")[0].split())
    return first.partition(". ")[0].rstrip(".")


if __name__ == "__main__":
    main()
