"""The first tests of a shader's functions: text for people to go on from, which passes as it is."""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from shaderlab.errors import CallError, ShaderlabError
from shaderlab.functions.library import Function, Library
from shaderlab.functions.signatures import Signature, Type

_SAMPLES = 1000
_MOST_WORDS = 16  # what has more is written as one number for all
_DIRECTIONS = """\

def directions(random):
    vectors = random.normal(size=(1000, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
"""
_IMAGE = "np.linspace(0, 1, 64, dtype=np.float32).reshape(4, 4, 4)"
# Names of arguments, and where they usually lie.
_DIRECTION = re.compile(r"normal|n|direction|dir|axis|view\w*|light_?dir|halfway|ray|rd", re.I)
_RANGES = (
    (r"time|seconds|d|dist|distance|radius|depth|height|width|size|range", 0, 10),
    (r"p|pos|position|point|origin|ro|world\w*", -10, 10),
    (r"angle|theta|phi|yaw|pitch|roll|rotation|x|y|z|w|v|offset|center", -1, 1),
)
# From the strongest to the weakest; the first that holds is written.
_LAWS = ("(y >= 0) & (y <= 1)", "(y >= -1) & (y <= 1)", "y >= 0", "np.isfinite(y)")


def first_tests(library: Library, path: str) -> str:
    """Return a test file's text for all functions of a library.

    Each function gets one property that holds at random arguments, which are the same in each run,
    and one figure: what it returns today, to be replaced by what it should return.
    """
    module = re.sub(r"\W", "_", path.rsplit("/", 1)[-1].partition(".")[0])
    if not module.isidentifier() or module in ("np", "glsl"):
        module = f"shader_{module}"
    parts = [
        f'"""First tests of {path}, to go on from."""\n\nimport numpy as np\n'
        f'from shaderlab import glsl\n\n{module} = glsl.load("{path}")\n{_DIRECTIONS}'
    ]
    for function in library:
        several = len(function.signatures) > 1
        for number, signature in enumerate(function.signatures, start=1):
            name, called = signature.name, f"{module}.{signature.name}"
            if keyword.iskeyword(name) or hasattr(Library, name):
                called = f'{module}["{name}"]'
            if several:
                types = ", ".join(str(p.type) for p in signature.parameters)
                name, called = f"{name}_{number}", f'{called}["{types}"]'
                function = library[signature.name][types]
            parts.append("\n".join(_write_tests(function, signature, name, called)) + "\n")
    return "\n\n".join(parts)


def _write_tests(function: Function, signature: Signature, name: str, called: str) -> Iterator[str]:
    yield f"# {signature}"
    inputs = (*signature.given, *(g for g in signature.globals if not g.optional))
    try:
        if signature.obstacle or not signature.outputs:
            raise CallError(signature.obstacle or "it returns nothing")
        random = ", ".join(f"{i.name}={_write_value(i.name, i.type, _samples)}" for i in inputs)
        fixed = ", ".join(f"{i.name}={_write_value(i.name, i.type, _place)}" for i in inputs)
        law = _find_law(function, random) if "random" in random else ""
        value = function(**_evaluate(f"dict({fixed})"))
    except ShaderlabError as error:
        yield f"# has no test: {error.message}"
        return
    if law:
        yield f"def test_{name}():"
        yield "    random = np.random.default_rng(0)"
        yield f"    y = {called}({random})"
        yield f"    assert np.all({law})\n\n"
    yield f"def test_{name}_at_one_place():"
    yield f"    y = {called}({fixed})"
    yield "    # What it returns today: put in what it should return."
    yield from (f"    {line}" for line in _figures(value))


def _evaluate(text: str) -> Any:
    """The value of an expression of the test file."""
    names: dict[str, Any] = {"np": np, "random": np.random.default_rng(0)}
    exec(_DIRECTIONS, names)
    return eval(text, names)


def _find_law(function: Function, arguments: str) -> str:
    """The strongest law that holds of the arguments of the test; "" if none does."""
    y = function(**_evaluate(f"dict({arguments})"))
    if not isinstance(y, np.ndarray) or y.dtype.kind != "f":
        return ""
    with np.errstate(all="ignore"):
        holds = (law for law in _LAWS if np.all(eval(law, {"np": np}, {"y": y})))
        return next(holds, "")


def _write_value(name: str, kind: Type, numbers: Callable[[str, Type], str]) -> str:
    """An argument as Python; `numbers` writes those that are numbers."""
    if kind.dims and (kind.members or kind.opaque):
        return f"[{', '.join([_write_value(name, kind.element, numbers)] * kind.dims[0])}]"
    if kind.members:
        # What is in a struct with samplers has one value for a call.
        inner = _place if kind.opaque else numbers
        members = (f'"{member}": {_write_value(member, t, inner)}' for member, t in kind.members)
        return f"{{{', '.join(members)}}}"
    if kind.opaque:
        if kind.name != "sampler2D":
            raise CallError(f"it reads {kind} {name}")
        return _IMAGE
    return numbers(name, kind)


def _range(name: str) -> tuple[int, int]:
    found = ((low, high) for text, low, high in _RANGES if re.fullmatch(text, name, re.I))
    return next(found, (0, 1))


def _samples(name: str, kind: Type) -> str:
    """Random numbers for each of the test's calls."""
    size = (_SAMPLES, *kind.shape) if kind.shape else _SAMPLES
    if kind.kind == "bool":
        return f"random.integers(0, 2, {size}) == 1"
    if kind.kind != "float":
        return f"random.integers(0, 11, {size})"
    if kind.shape == (3,) and _DIRECTION.fullmatch(name):
        return "directions(random)"
    low, high = _range(name)
    return f"random.uniform({low}, {high}, {size})"


def _place(name: str, kind: Type) -> str:
    """One value without anything special about it."""
    part: Any = (0.3 + 0.17 * np.arange(math.prod(kind.shape)).reshape(kind.shape)) % 1.0
    low, high = _range(name)
    if kind.words > _MOST_WORDS:
        one = {"float": "0.5", "bool": "True"}.get(kind.kind, "1")
        return f"np.full({kind.shape}, {one})"
    if kind.kind == "bool":
        return _format(part < 1.0)
    if kind.kind != "float":
        return _format(np.floor(10 * part).astype(int))
    if kind.shape == (3,) and _DIRECTION.fullmatch(name):
        return "[0.6, 0, 0.8]"
    return _format(np.round(low + (high - low) * part, 3))


def _figures(value: Any, name: str = "y") -> Iterator[str]:
    """Lines that compare a value with what it is today."""
    if isinstance(value, dict):
        for member, inner in value.items():
            yield from _figures(inner, f'{name}["{member}"]')
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            yield from _figures(inner, f"{name}[{number}]")
    elif isinstance(value, tuple):
        for field in value._fields:  # type: ignore[attr-defined]
            yield from _figures(getattr(value, field), f"{name}.{field}")
    elif np.ma.is_masked(value):
        yield f"assert np.ma.is_masked({name})  # discarded"
    elif np.asarray(value).dtype.kind == "f":
        yield f"np.testing.assert_allclose({name}, {_format(value)}, rtol=1e-4, atol=1e-6)"
    else:
        yield f"np.testing.assert_array_equal({name}, {_format(value)})"


def _format(value: Any) -> str:
    array = np.asarray(value)
    if array.ndim:
        return f"[{', '.join(map(_format, array))}]"
    if array.dtype.kind != "f":
        return str(array)
    text = f"{float(array):.6g}"
    return f"np.{text.replace('-', '')}" if text.lstrip("-") in ("nan", "inf") else text
