"""The first tests of a shader's functions: text for people to go on from, which passes as it is."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from shaderlab.errors import CallError, ShaderlabError
from shaderlab.functions.library import Function, Library
from shaderlab.functions.signatures import Signature, Type

_SAMPLES = 1000
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

    Each function gets the strongest law that holds at random arguments, which are the same in each
    run.
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
            parts.append("\n".join(_write_test(function, signature, name, called)) + "\n")
    return "\n\n".join(parts)


def _write_test(function: Function, signature: Signature, name: str, called: str) -> Iterator[str]:
    yield f"# {signature}"
    inputs = (*signature.given, *(g for g in signature.globals if not g.optional))
    try:
        if signature.obstacle or not signature.outputs:
            raise CallError(signature.obstacle or "it returns nothing")
        random = ", ".join(f"{i.name}={_write_value(i.name, i.type)}" for i in inputs)
        law = _find_law(function, random)
        if "random" not in random or not law:
            raise CallError("none of the usual laws holds at random arguments")
    except ShaderlabError as error:
        yield f"# has no test: {error.message}"
        return
    yield f"def test_{name}():"
    yield "    random = np.random.default_rng(0)"
    yield f"    y = {called}({random})"
    yield f"    assert np.all({law})"


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


def _write_value(name: str, kind: Type) -> str:
    """Random arguments as Python."""
    if kind.dims and (kind.members or kind.opaque):
        return f"[{', '.join([_write_value(name, kind.element)] * kind.dims[0])}]"
    if kind.members:
        members = (f'"{member}": {_write_value(member, t)}' for member, t in kind.members)
        return f"{{{', '.join(members)}}}"
    if kind.opaque:
        if kind.name != "sampler2D":
            raise CallError(f"it reads {kind} {name}")
        return _IMAGE
    return _samples(name, kind)


def _samples(name: str, kind: Type) -> str:
    """Random numbers for each of the test's calls."""
    size = (_SAMPLES, *kind.shape) if kind.shape else _SAMPLES
    if kind.kind == "bool":
        return f"random.integers(0, 2, {size}) == 1"
    if kind.kind != "float":
        return f"random.integers(0, 11, {size})"
    if kind.shape == (3,) and _DIRECTION.fullmatch(name):
        return "directions(random)"
    ranges = ((low, high) for text, low, high in _RANGES if re.fullmatch(text, name, re.I))
    low, high = next(ranges, (0, 1))
    return f"random.uniform({low}, {high}, {size})"
