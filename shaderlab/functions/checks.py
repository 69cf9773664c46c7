"""Checking a function: against a reference's bands, or against a law."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from shaderlab.engine.judging.banded import judge_band
from shaderlab.engine.judging.laws import Close, Finding, Law
from shaderlab.engine.judging.references import Inputs, parameter_name
from shaderlab.errors import CallError, FormulaError
from shaderlab.functions.call import Call, Opaque, read_textures
from shaderlab.functions.signatures import Type
from shaderlab.glslmath.choice import where
from shaderlab.glslmath.vector import stack
from shaderlab.model.frame import Array
from shaderlab.model.records import Outcome, SourceText
from shaderlab.report.text import format_numbers, format_outcome

if TYPE_CHECKING:
    from shaderlab.functions.library import Function


class CallLaw(ABC):
    @property
    def title(self) -> str:
        return type(self).__name__.lower()

    @abstractmethod
    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        """Judge a function."""


@dataclass(frozen=True)
class Inverse(Close, CallLaw):
    """`other` gives an argument back: other(f(x)) = x, for the first parameter or `argument`."""

    other: Callable[..., Any]
    argument: str = ""

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        x = np.asarray(_argument(function, call, self.argument))
        back = np.asarray(self.other(got))
        x = np.broadcast_to(x, back.shape)
        trivial = "it returns its argument" if back.size and np.array_equal(got, x) else ""
        return self.compare(back, x, trivial)


@dataclass(frozen=True)
class Idempotent(Close, CallLaw):
    """f(f(x)) = f(x), in the first parameter or `argument`."""

    argument: str = ""

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        name = self.argument or call.signature.given[0].name
        again = np.asarray(function.call_again(call, {name: got}))
        x = _argument(function, call, name)
        trivial = "it returns its argument" if np.array_equal(np.asarray(got), x) else ""
        return self.compare(again, got, trivial)


@dataclass(frozen=True)
class SameAs(Close, CallLaw):
    """The value of another function, of GLSL or of Python, for the same arguments."""

    other: Callable[..., Any]

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        from shaderlab.functions.library import Function

        values = {**call.opaque, **{name: a.value for name, a in call.values.items()}}
        arguments = [values.pop(p.name) for p in call.signature.given]
        if isinstance(self.other, Function):
            reads = {g.name for s in self.other.signatures for g in s.globals}
            named = {name: value for name, value in values.items() if name in reads}
            expected = np.asarray(self.other(*arguments, **named))
        else:
            expected = np.asarray(self.other(*arguments))
        return self.compare(got, expected)


@dataclass(frozen=True)
class Table(Close, CallLaw):
    """Known values, one for each element. With `digits`, they are figures printed so: a value
    has to round to its figure."""

    values: Any
    _: KW_ONLY
    digits: int | None = None

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        measured, expected = np.asarray(got), np.asarray(self.values)
        if expected.shape != measured.shape:
            raise CallError(
                f"table: has shape {expected.shape}, the function returns {measured.shape}"
            )
        close: Close = self
        if self.digits is not None:
            close = Close(within=0.5 * 10.0**-self.digits * (1.0 + 1e-6))
        return close.compare(measured, expected)


inverse, idempotent, same_as, table = Inverse, Idempotent, SameAs, Table


def judge_law(law: Law | CallLaw, function: Function, call: Call, got: Any) -> Finding:
    if isinstance(law, CallLaw):
        return law.judge_call(function, call, got)
    inputs = {name: _argument(function, call, name) for name in law.inputs}
    changes = law.second_inputs(inputs)
    second = np.asarray(function.call_again(call, changes)) if changes else None
    return law.judge(inputs, np.asarray(got), second, call.batch)


def _argument(function: Function, call: Call, name: str) -> Any:
    """An argument's own array, as the function got it; the first one's if `name` is empty. Raises
    CallError."""
    argument = call.values.get(name or call.signature.given[0].name)
    if argument is None or argument.type.members:
        known = ", ".join(n for n, a in call.values.items() if not a.type.members)
        message = f"{function.__name__} gets no numbers named {name!r}"
        raise CallError(message, remedy=f"there is: {known}")
    return argument.value


def judge_function(function: Function, law: Law | CallLaw | Reference, call: Call) -> list[Outcome]:
    """The outcomes of a check: one, or with a reference one for each part of the result.

    Raises:
        CallError: the reference's parameters are not the function's.
        FormulaError: the reference fails.
    """
    outputs = call.signature.outputs
    if not outputs:
        raise CallError(f"{function.__name__} returns nothing", remedy="check what it should write")
    got = function.evaluate(call)
    found = split_result(outputs, got)
    kept: Array = np.ones(call.batch, np.bool_)
    if isinstance(found[0].values, np.ma.MaskedArray):
        mask = np.ma.getmaskarray(found[0].values)
        kept = np.asarray(~mask.all(axis=tuple(range(len(call.batch), mask.ndim))))
    if not isinstance(law, Law | CallLaw):
        inputs = match_inputs(law, call, kept.reshape(-1), function.folder)
        return [_judge_reference(function, law, call, part, inputs, kept) for part in found]
    if not isinstance(got, np.ndarray | np.generic):
        names = ", ".join(part.name for part in found)
        raise CallError(
            f"{law.title} is a law of one value; {function.__name__} returns {names}",
            remedy="check a reference that returns them all, or call it and compare its results",
        )
    return [_judge_law(function, law, call, found[0], kept)]


def format_failures(call: Call, outcomes: Sequence[Outcome]) -> str:
    lines = [str(call.signature)]
    for outcome in outcomes:
        if outcome.status != "pass":
            lines += [f"{outcome.name}:"] * (len(outcomes) > 1) + [*format_outcome(outcome)]
    return "\n".join(lines)


def function_source(function: Function, call: Call) -> SourceText:
    file, line = function.place_of(call.signature)
    return SourceText(file=file, line=line, language="glsl", text=call.signature.definition)


def _judge_reference(
    function: Function,
    reference: Reference,
    call: Call,
    part: Part,
    inputs: Inputs,
    kept: Array,
) -> Outcome:
    measured = part.rows(kept)
    banded = judge_band(measured, part.of(reference), inputs, rules=None)
    status, message = banded.verdict()
    return Outcome(
        name=part.named(function.__name__),
        kind="formula",
        status=status,  # type: ignore[arg-type]
        message=message,
        judged=int(measured.size),
        outside=banded.outside,
        worst=banded.worst(),
        vacuous=banded.vacuous_share,
        undecided=banded.undecided_share,
        informative=banded.informative_share,
        sources=(function_source(function, call), banded.source),
    )


def _judge_law(
    function: Function, law: Law | CallLaw, call: Call, part: Part, kept: Array
) -> Outcome:
    got = part.values.data if isinstance(part.values, np.ma.MaskedArray) else part.values
    finding = judge_law(law, function, call, got)
    holds = finding.holds.all(axis=tuple(range(len(call.batch), finding.holds.ndim)))
    wrong = np.flatnonzero(~holds & kept)
    name = law.title
    judged = int(np.count_nonzero(kept))
    message = ""
    if wrong.size:
        message = f"{name} does not hold of {wrong.size} of {judged} elements\n"
        message += "\n".join(_describe_element(call, finding, int(wrong[0])))
    elif not judged:
        message = "nothing was judged: there is no element, or all are discarded"
    elif finding.trivial:
        message = f"{name} could hardly fail: {finding.trivial}"
    return Outcome(
        name=function.__name__,
        kind=name,
        status="fail" if message else "pass",
        message=message,
        judged=judged,
        outside=int(wrong.size),
        sources=(function_source(function, call),),
    )


def _describe_element(call: Call, finding: Finding, index: int) -> Iterator[str]:
    """One element: what it got, what was expected, its inputs, and a line that calls it again."""
    count = math.prod(call.batch)
    rows = finding.values.reshape(count, -1)[index]
    yield f"  got        {format_numbers(rows)}"
    if finding.expected:
        yield f"  expected   {finding.expected}"
    else:
        other = finding.reference.reshape(count, -1)[index]
        yield f"  expected   {format_numbers(other)}"
        with np.errstate(all="ignore"):
            apart = np.abs(rows.astype(np.float64) - other) / np.spacing(np.abs(np.float32(other)))
        yield f"  apart      {np.max(apart):.3g} ulp"
    for name, values in inputs_at(call, index).items():
        yield f"  {name} = {format_numbers(values)}"


def inputs_at(call: Call, index: int) -> dict[str, tuple[float, ...]]:
    """The numbers that an element of a call got, by name."""
    found = {}
    for name, leaf in leaves(call):
        rows = np.broadcast_to(leaf, (*call.batch, leaf.shape[-1])).reshape(-1, leaf.shape[-1])
        values = rows[index]
        found[name] = tuple(float(np.float32(v)) if values.dtype.kind == "f" else v for v in values)
    return found


Reference = Callable[..., Any]


Steps = tuple[tuple[tuple[str, ...], int], ...]
"""The way from a result to one of its parts: names of members, and the place of one of them."""


@dataclass(frozen=True)
class Part:
    """A part of a call's result: its values, shaped as the batch and then the type, which may be
    masked, and the way to it."""

    type: Type
    values: Any
    steps: Steps

    @property
    def name(self) -> str:
        """Such as "hit.normal", "lights[2].color"; "" where the result is one value."""
        return ".".join(names[n] for names, n in self.steps).replace(".[", "[")

    def named(self, function: str) -> str:
        """Such as "sphere.normal", "corners[1]"; the function's name where there is one value."""
        return f"{function}.{self.name}".replace(".[", "[").removesuffix(".")

    def rows(self, kept: Array) -> Array:
        """Its numbers for the elements that are kept, (count, numbers); booleans as 0.0 and 1.0."""
        values = np.asarray(getattr(self.values, "data", self.values))
        found = values.reshape(kept.size, -1)[kept.reshape(-1)]
        return found.astype(np.float32) if found.dtype == bool else found

    def of(self, reference: Reference) -> Reference:
        """This part of a reference's result, as a reference with the same parameters."""
        plain = self.type.kind != "bool" and not self.type.dims and len(self.type.shape) < 2
        if plain and not self.steps:
            return reference
        found = functools.partial(_part, reference, self.steps, self.type)
        functools.update_wrapper(found, reference, assigned=(), updated=())
        return found


def split_result(outputs: Sequence[tuple[str, Type]], got: Any) -> list[Part]:
    """The parts of a call's result, as `Function` gives it: of `outputs` by name."""
    whole = outputs[0][1] if len(outputs) == 1 else Type("", members=tuple(outputs))
    return list(_parts(whole, got, ()))


def _parts(kind: Type, got: Any, steps: Steps) -> Iterator[Part]:
    if kind.dims and (kind.members or kind.kind in ("int", "uint")):
        names = tuple(f"[{n}]" for n in range(kind.dims[0]))
        kinds: tuple[Type, ...] = (kind.element,) * len(names)
        if not kind.members:  # one by one: side by side integers would become floats
            got = [np.ma.take(got, n, axis=-len(kind.shape)) for n in range(len(names))]
    elif kind.members:
        names, kinds = (tuple(each) for each in zip(*kind.members, strict=True))
        got = got if isinstance(got, tuple) else [got[name] for name in names]
    else:
        yield Part(kind, got, steps)
        return
    for n, (piece, inner) in enumerate(zip(got, kinds, strict=True)):
        yield from _parts(inner, piece, (*steps, (names, n)))


def _part(reference: Reference, steps: Steps, kind: Type, /, *given: Any, **named: Any) -> Any:
    value = reference(*given, **named)
    for names, index in steps:
        value = _take(value, names, index)
    return _flatten(value, kind)


def _take(value: Any, members: Sequence[str], index: int) -> Any:
    """A member by its name from a mapping, a named tuple or a data class, else by its place."""
    names = getattr(value, "_fields", ())
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value)]
    if isinstance(value, Mapping) and members[index] in value:
        return value[members[index]]
    if members[index] in names:
        return getattr(value, members[index])
    if isinstance(value, list | tuple) and len(value) == len(members) and not names:
        return value[index]
    raise FormulaError(
        f"gives {_describe(value)}, not {', '.join(members)}", remedy=f"return {_remedy(members)}"
    )


def _describe(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"a dict of {', '.join(map(str, value))}"
    if isinstance(value, list | tuple):
        return f"a {type(value).__name__} of {len(value)}"
    return "one value"


def _remedy(names: Sequence[str]) -> str:
    if names[0].startswith("["):
        return f"a list of {len(names)}"
    members = ", ".join(f'"{name}": …' for name in names)
    return f"{{{members}}}, or a tuple in that order"


def _flatten(value: Any, kind: Type) -> Any:
    """A matrix's or an array's numbers side by side, in the order of `Part.rows`."""
    if kind.dims:
        return _flatten_array(value, kind)
    if len(kind.base_shape) < 2:
        return where(value, 1.0, 0.0) if kind.kind == "bool" else value
    rows, columns = kind.base_shape
    shape = getattr(value, "shape", ())
    if tuple(shape[-2:]) != kind.base_shape:
        raise FormulaError(
            f"gives shape {shape} for a {kind}",
            remedy=f"build it of its columns, or return an array (…, {rows}, {columns})",
        )
    return stack([value[..., row, :] for row in range(rows)], -1)


def _flatten_array(value: Any, kind: Type) -> Any:
    count = kind.dims[0]
    if not isinstance(value, list | tuple):
        shape, inner = getattr(value, "shape", ()), kind.element.shape
        if not inner and shape[-1:] == (count,):
            return value
        axis = -1 - len(inner)
        if not inner or len(shape) < -axis or shape[axis] != count:
            raise FormulaError(
                f"gives shape {shape} for {kind}", remedy=f"return a list of {count}"
            )
        value = [value[(..., n, *[slice(None)] * len(inner))] for n in range(count)]
    if len(value) != count:
        raise FormulaError(f"gives {len(value)} elements for {kind}")
    size = math.prod(kind.element.shape)
    elements = []
    for each in value:
        element = _flatten(each, kind.element)
        # One number may stand for all components.
        single = getattr(element, "shape", ())[-1:] in ((), (1,))
        elements.append(stack([element] * size, -1) if size > 1 and single else element)
    return stack(elements, -1)


Input = TypeVar("Input")


def match_inputs(reference: Reference, call: Call, kept: Array, folder: str) -> Inputs:
    """The inputs under the names that the reference has for them: the function's own, or in the
    order of its parameters.

    Raises:
        CallError: the reference's parameters are not the function's.
    """
    opaque = read_textures(call, Path(folder))
    inputs = _inputs(call, kept, opaque)
    wanted = [p for p in inspect.signature(reference).parameters.values()]
    required = [p.name for p in wanted if p.default is p.empty]
    known = inputs.parameters()
    if all(name in known for name in required):
        return inputs
    for name, error in opaque.unread.items():
        if parameter_name(name) in required:
            raise error
    every = [*_in_order(call, [*inputs.exact, *inputs.textures, *opaque.unread])]
    numbers = [name for name in every if name in inputs.exact]
    for names in (every, numbers):
        if len(names) in (len(required), len(wanted)):
            return _match_by_order(inputs, names, [p.name for p in wanted], opaque)
    shown = ", ".join(parameter_name(n) for n in every)
    raise CallError(
        f"{reference.__name__} takes {', '.join(p.name for p in wanted)}; "
        f"{call.signature.name} gets {shown}",
        remedy="name the reference's parameters so, or take as many in the same order",
    )


def _match_by_order(
    inputs: Inputs, names: Sequence[str], wanted: Sequence[str], opaque: Opaque
) -> Inputs:
    new = dict(zip(names, wanted, strict=False))
    for name in new.keys() & opaque.unread.keys():
        raise opaque.unread[name]
    return Inputs(
        shared=_rename(inputs.shared, new),
        each=_rename(inputs.each, new),
        textures=_rename(inputs.textures, new),
        arrays=frozenset(new[name] for name in inputs.arrays if name in new),
    )


def leaves(call: Call) -> Iterator[tuple[str, Array]]:
    """Each number or vector that a call has, with its name: "light.constant"."""
    for name, given in call.values.items():
        for (word, _), leaf in zip(given.type.leaves(name), given.leaves, strict=True):
            yield word, leaf


def _in_order(call: Call, known: Sequence[str]) -> Iterator[str]:
    """The inputs in the order of the function's parameters, then the others'."""
    for one in (*call.signature.given, *call.signature.globals):
        yield from (name for name, _ in one.type.leaves(one.name) if name in known)


def _inputs(call: Call, kept: Array, opaque: Opaque) -> Inputs:
    shared: dict[str, Array] = {}
    each: dict[str, Array] = {}
    arrays = set()
    for name, given in call.values.items():
        for (word, kind), leaf in zip(given.type.leaves(name), given.leaves, strict=True):
            exact = leaf.astype(np.float32) if leaf.dtype.kind in "fb" else leaf
            if kind.kind == "float":
                exact = leaf.astype(np.float32)
            own = kind.shape or (1,)
            if kind.dims:
                arrays.add(word)
                own = (*kind.dims, *(kind.base_shape or (1,)))
            if math.prod(leaf.shape[:-1]) == 1:
                shared[word] = exact.reshape(own)
            else:
                whole = np.broadcast_to(exact, (*call.batch, exact.shape[-1]))
                each[word] = whole.reshape(-1, *own)[kept]
    return Inputs(
        shared={**shared, **opaque.uniforms},
        each=each,
        textures=opaque.textures,
        arrays=frozenset(arrays),
    )


def _rename(values: Mapping[str, Input], new: Mapping[str, str]) -> dict[str, Input]:
    return {new[name]: value for name, value in values.items() if name in new}
