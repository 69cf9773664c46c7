"""Evaluates reference formulas: their inputs, found by their parameters' names, and their source.

`light.constant` is the parameter light_constant, `lights[0].position` is lights_0_position, and
all of `lights[i].position` together are the list lights_position. An array uniform is a list.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Rules
from shaderlab.bands.band import WHOLE
from shaderlab.bands.bounds import Vector
from shaderlab.bands.exact import TriBool
from shaderlab.errors import FormulaError, MissingPackageError, ShaderlabError, suggest
from shaderlab.glslmath.sampling import Sampler
from shaderlab.glslmath.vector import Elements
from shaderlab.model.checked import TOO_LARGE, UNMASK, is_masked
from shaderlab.model.frame import Array, Bindings, Texels
from shaderlab.model.phases import phase
from shaderlab.model.records import SourceText

from .literals import with_literals

Reference = Callable[..., Any]
# NumPy's words of a product by component that was meant as a matrix's: shapes such as (2,2) (50,2).
_MATRIX = re.compile(r"broadcast together.*\(([234]),\1\)")
_INDEXED = re.compile(r"\[(\d+)\]")


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """Everything that a reference may take as a parameter, by GLSL name.

    Attributes:
        shared: what is the same for all judged values, as the shader got it: uniforms and
            constants, shaped (components,) or (rows, columns).
        each: what differs from one judged value to the next, shaped (count, components).
        decimal: some of both in float64, as the case wrote them.
        arrays: names in `shared` whose first axis is a GLSL array's.
    """

    shared: Mapping[str, Array]
    each: Mapping[str, Array] = field(default_factory=dict)
    decimal: Mapping[str, Array] = field(default_factory=dict)
    textures: Mapping[str, Texels] = field(default_factory=dict)
    arrays: frozenset[str] = frozenset()

    @classmethod
    def of(
        cls,
        bindings: Bindings,
        *,
        each: Mapping[str, Array],
        given: Mapping[str, Any],
        decimal: Mapping[str, Array] | None = None,
    ) -> Inputs:
        """A draw's bindings, with what differs from value to value, and a check's own constants
        (which override uniforms of the same parameter name)."""

        def without_given(names: Mapping[str, Array]) -> dict[str, Array]:
            return {n: v for n, v in names.items() if parameter_name(n) not in given}

        constants = {name: np.atleast_1d(np.asarray(v, np.float64)) for name, v in given.items()}
        rounded = {name: value.astype(np.float32) for name, value in constants.items()}
        whole = {n: v for n, v in bindings.buffers.items() if n not in each}
        by_element = bindings.buffers.keys() & each.keys()
        written = {n: v for n, v in bindings.decimal.items() if n not in by_element}
        return cls(
            shared={**without_given(bindings.uniforms), **without_given(whole), **rounded},
            each=without_given(each),
            decimal={**without_given(written), **constants, **(decimal or {})},
            textures={**bindings.textures, **bindings.images},
            arrays=bindings.arrays - constants.keys() - by_element,
        )

    def part(self, rows: slice | Array) -> Inputs:
        """The inputs of some judged values, a slice or their numbers; `decimal` is left out."""
        each = {name: values[rows] for name, values in self.each.items()}
        return Inputs(shared=self.shared, each=each, textures=self.textures, arrays=self.arrays)

    @property
    def exact(self) -> dict[str, Array]:
        """Both kinds of input together."""
        return {**self.shared, **self.each}

    def parameters(self) -> dict[str, list[str]]:
        """The GLSL names behind each parameter name; several for a list of struct members."""
        return parameter_names(*{**self.shared, **self.each, **self.textures})

    def at(self, index: int, names: Sequence[str]) -> dict[str, tuple[float, ...]]:
        """The values of some inputs for judged value `index`, for showing."""
        shown = {name: self.each[name][index] for name in names if name in self.each}
        shown |= {n: self.shared[n] for n in names if n in self.shared and n not in shown}
        return {n: tuple(float(x) for x in v) for n, v in shown.items() if v.ndim == 1}


@lru_cache(maxsize=256)
def parameter_names(*names: str) -> dict[str, list[str]]:
    """The parameters that may stand for GLSL names, with those that each stands for."""
    found: dict[str, list[str]] = {}
    for name in names:
        found.setdefault(parameter_name(name), []).append(name)
        if _INDEXED.search(name):
            found.setdefault(parameter_name(_INDEXED.sub("", name)), []).append(name)
    return found


@lru_cache(maxsize=4096)
def parameter_name(glsl_name: str) -> str:
    """The Python parameter that stands for a GLSL name.

    >>> parameter_name("pointLights[2].position")
    'pointLights_2_position'
    """
    return re.sub(r"\W+", "_", glsl_name).strip("_")


def match_parameters(reference: Reference, inputs: Inputs) -> dict[str, list[str]]:
    """The GLSL names that each of the reference's parameters stands for. Raises FormulaError: a
    parameter without a default matches nothing; lists what there is."""
    known = inputs.parameters()
    found = {}
    for name, parameter in parameters_of(reference).items():
        if name in known:
            found[name] = known[name]
        elif parameter.default is parameter.empty:
            message = f"{name_of(reference)}() asks for {name!r}, which the shader lacks"
            raise make_error(reference, message, suggest(name, known))
    return found


def evaluate(
    reference: Reference,
    inputs: Inputs,
    *,
    rules: Rules | None,
    decimal: bool,
    parameters: Mapping[str, list[str]] | None = None,
) -> Any:
    """The reference's value: a Band under `rules`, or a float64 array without them.

    With `decimal`, inputs are taken as the case wrote them, before they became float32.
    `parameters` is the result of `match_parameters`, for callers that evaluate part after part.
    Raises FormulaError: a parameter matches nothing, or the reference fails, in which line."""

    exact = inputs.exact

    def convert(name: str) -> Any:
        if name in inputs.textures:
            return Sampler(inputs.textures[name], rules)
        values = (inputs.decimal if decimal and name in inputs.decimal else exact)[name]
        whole = exact[name].dtype.kind in "iu"
        if whole:
            values = exact[name]
        if name not in inputs.arrays:
            return _to_number(values, rules, whole=whole)
        # What differs from value to value has the array's own axis behind theirs.
        pieces = np.moveaxis(values, 1, 0) if name in inputs.each else values
        return Elements(_to_number(piece, rules, whole=whole) for piece in pieces)

    arguments = {}
    for parameter, names in (parameters or match_parameters(reference, inputs)).items():
        several = len(names) > 1 or parameter != parameter_name(names[0])
        arguments[parameter] = Elements(map(convert, names)) if several else convert(names[0])
    try:
        with phase("reference"), np.errstate(all="ignore"):
            formula = reference if rules is None else with_literals(reference, rules)
            return _require_number(formula(**arguments))
    except MissingPackageError:
        raise
    except ShaderlabError as error:
        place = source_of(reference)
        raise FormulaError(
            f"{name_of(reference)}(): {error.message}",
            file=error.file or place.file,
            line=error.line or place.line,
            remedy=error.remedy,
        ) from error
    except Exception as error:
        remedy = "references use + − * / and the functions of shaderlab.glslmath only"
        remedy = next((hint for said, hint in _HINTS.items() if said in str(error)), remedy)
        if "matmul" in str(error) or _MATRIX.search(str(error)):
            remedy = "a matrix times a vector is glslmath.mul(m, v), times a matrix matmul(a, b)"
        if "bitwise_" in str(error) or "_shift" in str(error):
            remedy = WHOLE
        raise locate_error(reference, error, remedy) from error


# What NumPy says of the functions of Python and `math`, and what to write instead.
_HINTS = {
    "truth value": "glslmath has max, min, any and all, which take arrays; choose with "
    "glslmath.where(condition, a, b)",
    "__round__": "write glslmath.round, or glslmath.roundEven",
    "0-dimensional": "write the function of glslmath in place of math's, float() or int()",
    "length-1 array": "write the function of glslmath in place of math's, float() or int()",
}


def _require_number(result: Any) -> Any:
    if isinstance(result, Band):
        return result
    numbers = isinstance(result, np.ndarray | np.generic) and result.dtype.kind in "fiub"
    if is_masked(result):
        raise FormulaError("gives masked values, which are no numbers", remedy=UNMASK)
    if numbers or isinstance(result, Integer | TriBool | float):
        return result
    if isinstance(result, int) and abs(result) < TOO_LARGE:
        return result
    if isinstance(result, list | tuple):
        several = ", ".join("…" for _ in result)
        remedy = f"build a vector of its parts: vec{len(result)}({several})"
    else:
        remedy = "return a number, or a vector such as vec4(r, g, b, 1.0)"
    raise FormulaError(f"gives {type(result).__name__} {result!r:.60}, no number", remedy=remedy)


def _to_number(values: Array, rules: Rules | None, *, whole: bool) -> Any:
    """A value as formulas take it; `whole` for what is an integer in the shader."""
    if whole:
        return Integer(values, unsigned=values.dtype.kind == "u", rules=rules)
    return values.astype(np.float64).view(Vector) if rules is None else Band.exact(values, rules)


def parameters_of(reference: Reference) -> Mapping[str, inspect.Parameter]:
    """The parameters of a formula by name. Raises FormulaError: it is one of Python's own functions
    that do not tell them."""
    try:
        return inspect.signature(reference).parameters
    except (TypeError, ValueError):
        what = name_of(reference)
        raise FormulaError(
            f"{what}() does not say what it takes", remedy=f"write lambda x: {what}(x)"
        ) from None


def name_of(reference: Callable[..., Any]) -> str:
    """What a formula is called; an object that can be called has its type's name."""
    target = inspect.unwrap(reference)
    target = getattr(target, "func", target)
    return str(getattr(target, "__name__", type(target).__name__))


def source_of(reference: Callable[..., Any]) -> SourceText:
    """Where a formula stands, and its text."""
    target = inspect.unwrap(reference)
    while hasattr(target, "func"):
        target = target.func
    target = getattr(target, "__func__", target)
    if isinstance(target, FunctionType):
        return _source_of(target)
    return SourceText(file="?", line=0, language="python", text=repr(reference))


@lru_cache(maxsize=1024)  # a formula is asked for it once a variant
def _source_of(function: FunctionType) -> SourceText:
    try:
        lines, line = inspect.getsourcelines(function)
        file = inspect.getsourcefile(function) or "?"
    except OSError:
        return SourceText(file="?", line=0, language="python", text=repr(function))
    return SourceText(file=file, line=max(line, 1), language="python", text="".join(lines))


def make_error(reference: Callable[..., Any], message: str, remedy: str = "") -> FormulaError:
    """An error at the place of a formula."""
    place = source_of(reference)
    return FormulaError(message, file=place.file, line=place.line, remedy=remedy or None)


def locate_error(reference: Callable[..., Any], error: Exception, remedy: str) -> FormulaError:
    """Make a FormulaError of a foreign one, with the line of the formula's own file."""
    message = f"{name_of(reference)}() fails: {type(error).__name__}: {error}"
    made, trace = make_error(reference, message, remedy), error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == made.file:
            made.line = trace.tb_lineno
        trace = trace.tb_next
    return made
