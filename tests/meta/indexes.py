"""Two pages of the docs, made of the code: the reference formulas by topic, and `glslmath`.

`python -m tests.meta.indexes` writes them; a test holds both equal to what it would write.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import FunctionType, ModuleType

import shaderlab.glslmath
import shaderlab.glslmath.sampling
import shaderlab.reference
import tests.independent
from tests.independent import against
from tests.meta.builtins import CHAPTER_8, SPELT, WHY_NOT

_MADE = "<!-- Made by `python -m tests.meta.indexes`; do not edit. -->"
_REFERENCE = """\
# Reference formulas

The formulas in `shaderlab.reference` by topic: `from shaderlab.reference.attenuation import reach`.
Each takes numbers, float64 arrays or bands; its docstring gives symbols, units, domain and a worked
value. You write references of your own the same way, with the [functions of GLSL](glslmath.md)
([writing cases](cases.md)).

A formula that transcribes its shader can share its mistake. So each is also held against something
that is not: another library, a derivation of another kind, a printed table. The last column says
what; the tests are in `tests/independent`.
"""
_GLSLMATH = """\
# GLSL's functions in references

What `shaderlab.glslmath` has: GLSL's built-in functions, by their names and in their argument
order, over numbers, float64 arrays and bands. The precision given is that of bands
([how they are derived](bands.md)). The last axis of an array holds a vector's components.
References also use `+ - * /`, comparisons, and `&`, `|` and `~` of their results.
"""
_BUILTINS = """\
Each function of the specification's chapter 8, and where references find it. What GLSL returns in
`out` arguments is returned in a tuple; derivatives take `frag_coord` as well, and functions of
textures take the level that GLSL derives by itself.
"""


def pages() -> dict[str, str]:
    """The pages' texts, by their paths in the repository."""
    return {"docs/guide/reference.md": _reference(), "docs/guide/glslmath.md": _glslmath()}


def main() -> None:
    """Write the pages."""
    for path, text in pages().items():
        (Path(__file__).resolve().parents[2] / path).write_text(text, encoding="utf-8")


def _reference() -> str:
    modules = [
        importlib.import_module(f"shaderlab.reference.{found.name}")
        for found in pkgutil.iter_modules(shaderlab.reference.__path__)
    ]
    contents = [f"- [{_topic(m)}](#{_topic(m)}): {_title(m)}" for m in modules]
    parts = [_MADE, _REFERENCE.strip(), "\n".join(contents)]
    for module in modules:
        own = [f for _, f in _functions(module) if f.__module__ == module.__name__]
        source = re.search(r"^Sources?: .*?(?=\n\n|\Z)", module.__doc__ or "", re.M | re.S)
        parts += [f"## {_topic(module)}", f"{_title(module)}.", _table(own, _held_against())]
        parts += [_line(source.group())] if source else []
    return "\n\n".join(parts) + "\n"


def _glslmath() -> str:
    parts = [_MADE, _GLSLMATH.strip()]
    by_module: dict[str, list[FunctionType]] = {}
    for _, function in _functions(shaderlab.glslmath):
        by_module.setdefault(function.__module__, []).append(function)
    for name, functions in by_module.items():
        module = importlib.import_module(name)
        parts += [f"## {_topic(module)}", f"{_title(module)}.", _table(functions)]
    parts += ["## All of GLSL 4.50", _BUILTINS.strip(), _builtins()]
    return "\n\n".join(parts) + "\n"


def _builtins() -> str:
    rows = ["| chapter | function | in references |", "|---|---|---|"]
    for chapter, names in CHAPTER_8.items():
        for name in names.split():
            rows.append(f"| {chapter} | `{name}` | {_where(name)} |")
    return "\n".join(rows)


def _where(builtin: str) -> str:
    """The room of the function of this name, or why there is none."""
    name = SPELT.get(builtin, builtin)
    for room in (shaderlab.glslmath, shaderlab.glslmath.sampling):
        if hasattr(room, name):
            return f"`{room.__name__.partition('.')[2]}.{name}`"
    return f"no: {WHY_NOT[builtin]}"


def _functions(module: ModuleType) -> Iterator[tuple[str, FunctionType]]:
    """A module's public functions, in the order in which they stand in their files."""
    found = [
        (name, value)
        for name, value in vars(module).items()
        if isinstance(value, FunctionType) and not name.startswith("_")
    ]
    return iter(sorted(found, key=lambda n: (n[1].__module__, n[1].__code__.co_firstlineno)))


def _held_against() -> Mapping[tuple[str, str], list[str]]:
    """What each reference formula is held against, by its module and name."""
    for file in sorted(Path(tests.independent.__path__[0]).glob("test_*.py")):
        importlib.import_module(f"tests.independent.{file.stem}")
    return against.SOURCES


def _table(
    functions: list[FunctionType], sources: Mapping[tuple[str, str], list[str]] | None = None
) -> str:
    rows = ["| function | gives |", "|---|---|"]
    if sources is not None:
        rows = ["| function | gives | held against |", "|---|---|---|"]
    for function in functions:
        says = (inspect.getdoc(function) or "").partition("\n\n")[0]
        cells = [f"`{_call(function)}`", _line(says)]
        if sources is not None:
            held = sources.get((function.__module__, function.__name__), ())
            cells.append("; ".join(dict.fromkeys(held)))
        rows.append("| " + " | ".join(cell.replace("|", chr(92) + "|") for cell in cells) + " |")
    return "\n".join(rows)


def _call(function: FunctionType) -> str:
    """The function with its parameters' names: no types, no defaults."""
    names = [
        f"*{p.name}" if p.kind is p.VAR_POSITIONAL else p.name
        for p in inspect.signature(function).parameters.values()
    ]
    return f"{function.__name__}({', '.join(names)})"


def _topic(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


def _title(module: ModuleType) -> str:
    return _line((module.__doc__ or "").partition("\n\n")[0]).rstrip(".")


def _line(text: str) -> str:
    return " ".join(text.split())


if __name__ == "__main__":
    main()
