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

_SPECIFICATION = re.compile(r'"The OpenGL Graphics System: A Specification"')
_ITS_AUTHORS = re.compile(r" \(M\. Segal, K\. Akeley, \d+\)")
_MADE = "<!-- Made by `python -m tests.meta.indexes`; do not edit. -->"
_REFERENCE = """\
# Reference formulas

The formulas in `shaderlab.reference` by topic: `from shaderlab.reference.attenuation import reach`.
Each takes numbers, float64 arrays or bands; `help(reach)` gives symbols, units, domain and a worked
value. [Add a reference](../../CONTRIBUTING.md#add-a-reference) says how to write more.

A formula that transcribes its shader can share its mistake. So each is also checked against an
independent source: another library, another derivation, a printed table. The tests are in
`tests/independent`.
"""
_GLSLMATH = """\
# GLSL's functions in references

`shaderlab.glslmath` has GLSL's built-in functions, by their names and in their argument order, over
numbers, float64 arrays and bands. The precision given is that of [bands](bands.md). The last axis
of an array holds a vector's components. References also use `+ - * /`, comparisons, and `&`, `|`
and `~` of their results.
"""
_BUILTINS = """\
What of the specification's chapter 8 is above, and what is missing, with the reason. All others are
in `shaderlab.glslmath.sampling`, and take the level that GLSL derives by itself. Derivatives take
`frag_coord` as well. `out` arguments are returned in a tuple.
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
    parts = [_MADE, _REFERENCE.strip()]
    held = _held_against()
    for module in modules:
        own = [f for _, f in _functions(module) if f.__module__ == module.__name__]
        source = re.search(r"^Sources?: .*?(?=\n\n|\Z)", module.__doc__ or "", re.M | re.S)
        parts += [f"## {_topic(module)}", f"{_title(module)}.", _list(own), _checks(own, held)]
        parts += [_source(source.group())] if source else []
    return "\n\n".join(parts) + "\n"


def _glslmath() -> str:
    parts = [_MADE, _GLSLMATH.strip()]
    by_module: dict[str, list[FunctionType]] = {}
    for _, function in _functions(shaderlab.glslmath):
        by_module.setdefault(function.__module__, []).append(function)
    for name, functions in by_module.items():
        module = importlib.import_module(name)
        parts += [f"## {_topic(module)}", f"{_title(module)}.", _list(functions)]
    parts += ["## All of GLSL 4.50", _BUILTINS.strip(), _builtins()]
    return "\n\n".join(parts) + "\n"


def _builtins() -> str:
    """A line for each chapter: what is above, what is elsewhere, and what is missing, and why."""
    lines = []
    for chapter, names in CHAPTER_8.items():
        places: dict[str, list[str]] = {}
        for name in names.split():
            places.setdefault(_where(name), []).append(f"`{name}`")
        found = (p if p == "above" else f"{', '.join(n)}{p}" for p, n in places.items())
        lines.append(f"- {chapter}: {'; '.join(found)}")
    return "\n".join(lines)


def _where(builtin: str) -> str:
    """Where references find the function of this name, or why they do not."""
    if builtin in WHY_NOT:
        return f" (missing: {WHY_NOT[builtin]})"
    if builtin in SPELT:
        return f" (above, as `{SPELT[builtin]}`)"
    return "above" if hasattr(shaderlab.glslmath, builtin) else ""


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


def _list(functions: list[FunctionType]) -> str:
    """A line for each function: its call, and how its docstring begins."""
    return "\n".join(f"- `{_call(f)}`: {_says(f)}" for f in functions)


def _says(function: FunctionType) -> str:
    return _line((inspect.getdoc(function) or "").partition("\n\n")[0])


def _checks(functions: list[FunctionType], held: Mapping[tuple[str, str], list[str]]) -> str:
    """What the functions are checked against, each source once."""
    found: dict[str, list[str]] = {}
    for function in functions:
        for source in dict.fromkeys(held.get((function.__module__, function.__name__), ())):
            found.setdefault(source, []).append(f"`{function.__name__}`")
    if [len(names) for names in found.values()] == [len(functions)]:
        return f"Checked against: {next(iter(found))}."
    return "Checked against: " + "; ".join(f"{s} ({', '.join(n)})" for s, n in found.items()) + "."


def _call(function: FunctionType) -> str:
    """The function with its parameters' names: no types, no defaults."""
    names = [
        f"*{p.name}" if p.kind is p.VAR_POSITIONAL else p.name
        for p in inspect.signature(function).parameters.values()
    ]
    return f"{function.__name__}({', '.join(names)})"


def _source(text: str) -> str:
    """A list of sources; the one that most topics have by its short name."""
    return _ITS_AUTHORS.sub("", _SPECIFICATION.sub("the OpenGL specification", _line(text)))


def _topic(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


def _title(module: ModuleType) -> str:
    """The first sentence of a module's docstring, without a title that its name repeats."""
    says = _line((module.__doc__ or "").partition("\n\n")[0]).rstrip(".")
    title, _, rest = says.partition(": ")
    repeated = rest and re.sub(r"\W", "_", title.lower()) == _topic(module)
    return rest[0].upper() + rest[1:] if repeated else says


def _line(text: str) -> str:
    return " ".join(text.split())


if __name__ == "__main__":
    main()
