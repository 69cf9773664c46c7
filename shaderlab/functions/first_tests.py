"""The first tests of a shader's functions: text for people to go on from, which passes as it is."""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from shaderlab.errors import CallError, ShaderlabError
from shaderlab.functions import properties
from shaderlab.functions.library import Function, Library
from shaderlab.functions.properties import Directions, Domain, Floats, Ints, OneOf, hints_of
from shaderlab.functions.signatures import Input, Signature, Type
from shaderlab.model.frame import Array

_SAMPLES, _SEEDS = 10_000, 3
_MOST_WORDS = 16  # an argument of more numbers gets one value
# Names of arguments, or their last words, and where they usually lie.
_RANGES = (
    (r"normal|n|direction|dir|axis|view\w*|light_?dir|halfway|ray|rd", "glsl.directions()", 3),
    (r"time|seconds", "glsl.floats(0, 10)", 0),
    (r"d|dist|distance|radius|depth|height|width|size|range", "glsl.floats(0, 10)", 0),
    (r"p|pos|position|point|origin|ro|world\w*", "glsl.floats(-10, 10)", 0),
    (r"angle|theta|phi|yaw|pitch|roll|rotation", "glsl.floats(-3.14159, 3.14159)", 0),
    (r"x|y|z|w|v|offset|center", "glsl.floats(-1, 1)", 0),
)
# Laws from the strongest to the weakest, in the order in which they are tried.
_LAWS = (
    "(y >= 0) & (y <= 1)",
    "(y >= -1) & (y <= 1)",
    "np.abs(np.linalg.norm(y, axis=-1) - 1) < 1e-4",
    "y >= 0",
    "np.isfinite(y)",
)


def first_tests(library: Library, path: str) -> str:
    """A test file's text for all functions of a library.

    Each function gets one property over a range of each argument, the strongest of a few that holds
    there, and one figure: what it returns today, to be replaced by what it should return.
    """
    module = re.sub(r"\W", "_", path.rsplit("/", 1)[-1].partition(".")[0])
    module = (
        module if module.isidentifier() and module not in ("np", "glsl") else f"shader_{module}"
    )
    parts = [
        f'"""First tests of {path}, to go on from."""\n\nimport numpy as np\n'
        f'from shaderlab import glsl\n\n{module} = glsl.load("{path}")\n'
    ]
    for function in library:
        several = len(function.signatures) > 1
        for number, signature in enumerate(function.signatures, start=1):
            name, called = signature.name, f"{module}.{signature.name}"
            if keyword.iskeyword(name) or hasattr(Library, name):
                called = f'{module}["{name}"]'
            if several:
                types = ", ".join(str(p.type) for p in signature.parameters)
                name, called, function = f"{name}_{number}", f'{called}["{types}"]', library[name]
                function = function[types]
            parts.append("\n".join(_tests(function, signature, name, called)) + "\n")
    return "\n\n".join(parts)


def _tests(function: Function, signature: Signature, name: str, called: str) -> Iterator[str]:
    yield f"# {signature}"
    inputs = (*signature.given, *(g for g in signature.globals if not g.optional))
    reason = signature.obstacle or ("" if signature.outputs else "it returns nothing")
    try:
        texts = {i.name: _domain(i) for i in inputs}
        if reason:
            raise CallError(reason)
        law, texts = _law(function, texts, inputs)
        places = {i.name: _place(_evaluate(texts[i.name]), i.type) for i in inputs}
        value = function(**places)
    except ShaderlabError as error:
        yield f"# has no test: {error.message}"
        return
    if law:
        given = ", ".join([called, *(f"{n}={text}" for n, text in texts.items())])
        yield f"@glsl.given({given})"
        yield f"def test_{name}(y):"
        yield f"    return {law}\n\n"
    shown = {n: text if _is_fixed(text) else _format(places[n]) for n, text in texts.items()}
    arguments = ", ".join(f"{n}={text}" for n, text in shown.items())
    yield f"def test_{name}_at_one_place():"
    yield f"    y = {called}({arguments})"
    yield "    # What it returns today: put in what it should return."
    yield from (f"    {line}" for line in _figures(value))


def _evaluate(text: str) -> Any:
    return eval(text, {"glsl": properties, "np": np})


def _is_fixed(text: str) -> bool:
    return "glsl." not in text


def _figures(value: Any, name: str = "y") -> Iterator[str]:
    """Lines that hold a value against what it is today."""
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


def _law(
    function: Function, texts: dict[str, str], inputs: tuple[Input, ...]
) -> tuple[str, dict[str, str]]:
    """The first law that holds at all samples, "" if none does, and the domains where it holds:
    the given ones, or the same without what lies at 0."""
    away = {n: text.replace("floats(0, ", "floats(0.1, ") for n, text in texts.items()}
    for some in (texts, away):
        if all(map(_is_fixed, some.values())):
            break
        found = list(_LAWS)
        hints = hints_of(function.signatures[0].code)
        for seed in range(_SEEDS):
            rng = np.random.default_rng(seed)
            drawn = {i.name: _draw(_evaluate(some[i.name]), i.type, rng, hints) for i in inputs}
            y = function(**drawn)
            if not isinstance(y, np.ndarray) or y.dtype.kind != "f":
                return "", texts
            found = [law for law in found if _holds(law, y)]
        if found:
            return found[0], some
    return "", texts


def _holds(law: str, y: Any) -> bool:
    if "norm" in law and (y.ndim != 2 or np.ma.isMaskedArray(y)):
        return False
    with np.errstate(all="ignore"):
        return bool(np.all(eval(law, {"np": np}, {"y": y})))


def _draw(domain: Any, kind: Type, rng: np.random.Generator, hints: Array) -> Any:
    if isinstance(domain, dict):
        members = dict(kind.members)
        return {n: _draw(inner, members[n], rng, hints) for n, inner in domain.items()}
    if not isinstance(domain, Domain):
        return domain
    return domain.sample(rng, (_SAMPLES, *kind.shape), hints)


def _place(domain: Any, kind: Type) -> Any:
    """One value inside a domain, without anything special about it."""
    if isinstance(domain, dict):
        members = dict(kind.members)
        return {name: _place(inner, members[name]) for name, inner in domain.items()}
    part = (0.3 + 0.17 * np.arange(math.prod(kind.shape)).reshape(kind.shape)) % 1.0
    match domain:
        case Floats(low=low, high=high):
            return np.round(low + (high - low) * part, 3)
        case Ints(low=low, high=high):
            return low + np.floor((high - low) * part).astype(int)
        case Directions():
            return np.array([0.6, 0.0, 0.8])
        case OneOf():
            return np.bool_(True)
    return domain


def _format(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{name}": {_format(v)}' for name, v in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_format, value))}]"
    array = np.asarray(value)
    if array.ndim:
        return f"[{', '.join(map(_format, list(array)))}]"
    if array.dtype.kind != "f":
        return str(array)
    text = f"{float(array):.6g}"
    return f"np.{text.replace('-', '')}" if text.lstrip("-") in ("nan", "inf") else text


def _domain(given: Input) -> str:
    """Where an argument is searched, as Python."""
    kind = given.type
    if kind.opaque or (kind.members and kind.dims):
        return _fixed_value(given)
    if kind.members:
        members = (f'"{name}": {_domain(Input(name, inner))}' for name, inner in kind.members)
        return f"{{{', '.join(members)}}}"
    if kind.words > _MOST_WORDS:
        return _fixed_value(given)
    if given.name == "iResolution":
        return "np.array([64.0, 48.0, 1.0])"
    if kind.kind == "bool":
        return "glsl.bools()" if not kind.shape else f"np.ones({kind.shape}, bool)"
    if kind.kind in ("int", "uint"):
        return "glsl.ints(0, 10)"
    if len(kind.base_shape) == 2:
        return (
            f"np.eye({kind.base_shape[0]}, {kind.base_shape[1]})"
            if not kind.dims
            else ("glsl.floats(-1, 1)")
        )
    for pattern, text, size in _RANGES:
        if re.fullmatch(pattern, given.name, re.IGNORECASE) and size in (0, *kind.shape[-1:]):
            return text
    return "glsl.floats(0, 1)"


def _fixed_value(given: Input) -> str:
    """A value, for what is not searched: structs in arrays, and what has samplers."""
    kind = given.type
    if kind.dims and (kind.members or kind.opaque):
        return f"[{', '.join([_fixed_value(Input(given.name, kind.element))] * kind.dims[0])}]"
    if kind.members:
        members = (f'"{name}": {_fixed_value(Input(name, inner))}' for name, inner in kind.members)
        return f"{{{', '.join(members)}}}"
    if kind.opaque:
        if kind.name != "sampler2D":
            raise CallError(f"it reads {kind} {given.name}")
        return "np.linspace(0, 1, 64, dtype=np.float32).reshape(4, 4, 4)"
    one = {"bool": "True", "int": "1", "uint": "1"}.get(kind.kind, "0.5")
    return one if not kind.shape else f"np.full({kind.shape}, {one})"
