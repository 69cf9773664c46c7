"""Checking a function: against a reference's bands, or against a law."""

from __future__ import annotations

import dataclasses
import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.engine.judging.banded import Banded, judge_band
from shaderlab.engine.judging.laws import Close, Finding, Law
from shaderlab.engine.judging.references import Inputs, locate_error, parameter_name, parameters_of
from shaderlab.errors import CallError, FormulaError, ShaderlabError
from shaderlab.functions.call import Call, collect_opaque, read_texels, replace_arguments
from shaderlab.functions.signatures import Type
from shaderlab.glslmath.choice import where
from shaderlab.glslmath.vector import stack
from shaderlab.model.checked import Checked
from shaderlab.model.frame import Array
from shaderlab.model.records import Curve, Outcome, SourceText
from shaderlab.report.text import format_outcome

if TYPE_CHECKING:
    from shaderlab.functions.library import Function


class CallLaw(Checked, ABC):
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
        x = np.asarray(_argument(function, call, self.argument or call.signature.given[0].name))
        back = np.asarray(call_other(self.other, got))
        x = np.broadcast_to(x, back.shape)
        trivial = "it returns its argument" if back.size and np.array_equal(got, x) else ""
        return self.compare(back, x, trivial)


@dataclass(frozen=True)
class Idempotent(Close, CallLaw):
    """f(f(x)) = f(x), in the first parameter or `argument`."""

    argument: str = ""

    def judge_call(self, function: Function, call: Call, got: Any) -> Finding:
        name = self.argument or call.signature.given[0].name
        x = _argument(function, call, name)
        again = np.asarray(function.evaluate(replace_arguments(call, {name: got})))
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
            expected = np.asarray(call_other(self.other, *arguments))
        return self.compare(got, expected)


@dataclass(frozen=True)
class Table(Close, CallLaw):
    """Known values, one for each element. With `digits`, they are figures printed so: a value
    has to round to its figure."""

    values: bool | float | Array
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


def call_other(other: Callable[..., Any], *arguments: Any) -> Any:
    """What a test's own function gives, a list as an array. Raises FormulaError: it fails."""
    try:
        found = other(*arguments)
        return np.asarray(found) if isinstance(found, list | tuple) else found
    except ShaderlabError:
        raise
    except Exception as error:
        raise locate_error(other, error, "it gets arrays, or bands, and returns one") from error


inverse, idempotent, same_as, table = Inverse, Idempotent, SameAs, Table


def judge_law(law: Law | CallLaw, function: Function, call: Call, got: Any) -> Finding:
    if isinstance(law, CallLaw):
        return law.judge_call(function, call, got)
    inputs = {name: _argument(function, call, name) for name in law.inputs}
    changes = law.second_inputs(inputs)
    second = function.evaluate(replace_arguments(call, changes)) if changes else None
    return law.judge(inputs, np.asarray(got), second, call.batch)


def _argument(function: Function, call: Call, name: str) -> Any:
    """An argument's own array, as the function got it. Raises CallError."""
    argument = call.values.get(name)
    if argument is None or argument.type.members:
        known = ", ".join(n for n, a in call.values.items() if not a.type.members)
        message = f"{function.__name__} gets no numbers named {name!r}"
        raise CallError(message, remedy=f"there is: {known}")
    return argument.value


def judge_function(
    function: Function, law: Law | CallLaw | Reference, call: Call, curves: list[Curve]
) -> list[Outcome]:
    """The outcomes of a check: one, or with a reference one for each part of the result, whose
    curve over the only number that varies is added to `curves`. Raises CallError: the reference's
    parameters are not the function's; FormulaError: the reference fails."""
    outputs = call.signature.outputs
    if not outputs:
        raise CallError(f"{function.__name__} returns nothing", remedy="check what it should write")
    got = function.evaluate(call)
    found = split_result(outputs, got)
    kept = find_kept(call, found[0])
    if not isinstance(law, Law | CallLaw):
        inputs = match_inputs(law, call, kept.reshape(-1), function.folder)
        banded = [part.judge(law, inputs, kept) for part in found]
        for part, values in zip(found, banded, strict=True):
            curves += _curves(part.named(function.__name__), values)
        return [judge_reference(function, call, *each) for each in zip(found, banded, strict=True)]
    if not isinstance(got, np.ndarray | np.generic):
        names = ", ".join(part.named("").removeprefix(".") for part in found)
        raise CallError(
            f"{law.title} is a law of one value; {function.__name__} returns {names}",
            remedy="check a reference that returns them all, or call it and compare its results",
        )
    return [_judge_law(function, law, call, np.ma.getdata(got), kept)]


def find_kept(call: Call, part: Part) -> Array:
    """Which calls are not discarded."""
    mask = np.ma.getmaskarray(part.values)
    return np.asarray(~mask.all(axis=tuple(range(len(call.batch), mask.ndim))))


def format_failures(call: Call, outcomes: Sequence[Outcome]) -> str:
    lines = [str(call.signature)]
    for outcome in outcomes:
        if outcome.status != "pass":
            lines += [f"{outcome.name}:"] * (len(outcomes) > 1) + [*format_outcome(outcome)]
    return "\n".join(lines)


def function_source(function: Function, call: Call) -> SourceText:
    file, line = function.place_of(call.signature)
    return SourceText(file=file, line=line, language="glsl", text=call.signature.definition)


def judge_reference(function: Function, call: Call, part: Part, banded: Banded) -> Outcome:
    """The outcome of a part of a call's result under a reference."""
    status, message = banded.verdict()
    sources = (function_source(function, call), banded.source)
    name = part.named(function.__name__)
    return banded.outcome(
        name=name, kind="formula", status=status, message=message, sources=sources
    )


def _curves(name: str, banded: Banded) -> list[Curve]:
    """The curve over the only number that varies, of 300 points and the worst one; or over the only
    two a map of 30 × 16 cells, each the value that is furthest in its band; or none."""
    varying = {
        f"{over}.{'xyzw'[n]}" if values.shape[1] > 1 else over: values[:, n]
        for over, values in banded.inputs.each.items()
        if values.ndim == 2
        for n in range(values.shape[1])
    }
    names = list(varying)
    if len(banded.inputs.each) > len(names) or not banded.measured.size or len(names) not in (1, 2):
        return []
    x, y = varying[names[0]], varying[names[-1]]
    if x is y:
        order = np.argsort(x, kind="stable")
        some = {*order[:: max(1, len(order) // 300)], banded.furthest()[0]}
        rows = np.array([row for row in order if row in some])
        return [banded.curve(name, names[0], name, x[rows].tolist(), rows)]
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return []
    columns, lines = (
        np.digitize(v, np.linspace(v.min(), v.max(), n + 1)[1:-1]) for v, n in ((x, 30), (y, 16))
    )
    order = np.argsort(np.abs(banded.measure_distances()), kind="stable")
    rows = np.array(sorted(dict(zip((columns * 16 + lines)[order], order, strict=True)).values()))
    found = banded.curve(name, names[0], name, x[rows].tolist(), rows)
    return [replace(found, title=found.y_label, y_label=names[1], y=tuple(y[rows].tolist()))]


def _judge_law(
    function: Function, law: Law | CallLaw, call: Call, got: Array, kept: Array
) -> Outcome:
    finding = judge_law(law, function, call, got)
    parts = (len(call.batch), finding.holds.ndim)
    rows = kept.reshape((*kept.shape, *[1] * (parts[1] - parts[0])))
    finding = replace(finding, slack=np.where(rows, finding.slack, np.inf))
    wrong = np.count_nonzero(~finding.holds.all(axis=tuple(range(*parts))) & kept)
    judged = int(np.count_nonzero(kept))
    message = ""
    if wrong:
        message = f"{law.title} does not hold of {wrong} of {judged} elements"
    elif not judged:
        message = "nothing was judged: there is no element, or all are discarded"
    elif finding.trivial:
        message = f"{law.title} could hardly fail: {finding.trivial}"
    worst = None
    if wrong:
        count = math.prod(call.batch)
        worst = finding.find_worst(count, lambda index: inputs_at(call, index), broken=True)
    return Outcome(
        name=function.__name__, kind=law.title, status="fail" if message else "pass",
        message=message, judged=judged, outside=int(wrong), worst=worst,
        sources=(function_source(function, call),),
    )  # fmt: skip


def inputs_at(call: Call, index: int) -> dict[str, tuple[float, ...]]:
    """The numbers that an element of a call got, by name."""
    found = {}
    for name, _, leaf in leaves(call):
        rows = np.broadcast_to(leaf, (*call.batch, leaf.shape[-1])).reshape(-1, leaf.shape[-1])
        values = rows[index]
        found[name] = tuple(float(np.float32(v)) if values.dtype.kind == "f" else v for v in values)
    return found


Reference = Callable[..., Any]


@dataclass(frozen=True)
class Part:
    """A part of a call's result that is no struct and no array: its values, shaped as the batch and
    then the type, which may be masked; and the way to it, for each step the names of all members
    and the place of one of them."""

    type: Type
    values: Any
    steps: tuple[tuple[tuple[str, ...], int], ...]

    def named(self, function: str) -> str:
        """Such as "sphere.normal", "corners[1]"; the function's name where there is one value."""
        return ".".join([function, *(names[n] for names, n in self.steps)]).replace(".[", "[")

    def rows(self, kept: Array) -> Array:
        """Its numbers for the elements that are kept, (count, numbers); booleans as 0.0 and 1.0."""
        found = np.ma.getdata(self.values).reshape(kept.size, math.prod(self.type.shape))
        found = found if kept.all() else found[kept.reshape(-1)]
        return found.astype(np.float32) if found.dtype == bool else found

    def judge(self, reference: Reference, inputs: Inputs, kept: Array) -> Banded:
        """Its numbers beside a reference's band."""
        return judge_band(self.rows(kept), self.of(reference), inputs, rules=None)

    def of(self, reference: Reference) -> Reference:
        """This part of a reference's result, as a reference with the same parameters."""
        if self.type.kind != "bool" and len(self.type.shape) < 2 and not self.steps:
            return reference

        @functools.wraps(reference, assigned=(), updated=())
        def find_part(*given: Any, **named: Any) -> Any:
            value = reference(*given, **named)
            kind = self.type
            for names, index in self.steps:
                value = _take(value, names, index)
            if len(kind.shape) < 2:
                return where(value, 1.0, 0.0) if kind.kind == "bool" else value
            shape = getattr(value, "shape", ())
            if tuple(shape[-2:]) != kind.shape:
                rows, columns = kind.shape
                raise FormulaError(
                    f"gives shape {shape} for a {kind}",
                    remedy=f"build it of its columns, or return an array (…, {rows}, {columns})",
                )
            return stack([value[..., row, :] for row in range(kind.shape[0])], -1)

        return find_part


def split_result(outputs: Sequence[tuple[str, Type]], got: Any) -> list[Part]:
    """The parts of a call's result, as `Function` gives it: of `outputs` by name."""
    whole = outputs[0][1] if len(outputs) == 1 else Type("", members=tuple(outputs))
    return list(_parts(whole, got, ()))


def _parts(kind: Type, got: Any, steps: tuple[Any, ...]) -> Iterator[Part]:
    if kind.dims:
        names = tuple(f"[{n}]" for n in range(kind.dims[0]))
        kinds: tuple[Type, ...] = (kind.element,) * len(names)
        if not kind.members:
            got = [np.ma.take(got, n, axis=-len(kind.shape)) for n in range(len(names))]
    elif kind.members:
        names, kinds = (tuple(each) for each in zip(*kind.members, strict=True))
        got = got if isinstance(got, tuple) else [got[name] for name in names]
    else:
        yield Part(kind, got, steps)
        return
    for n, (piece, inner) in enumerate(zip(got, kinds, strict=True)):
        yield from _parts(inner, piece, (*steps, (names, n)))


def _take(value: Any, members: Sequence[str], index: int) -> Any:
    """A member by its name from a mapping, a named tuple or a data class, else by its place; of an
    array's elements, which may be components of a vector."""
    names = getattr(value, "_fields", ())
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value)]
    if isinstance(value, Mapping) and members[index] in value:
        return value[members[index]]
    if members[index] in names:
        return getattr(value, members[index])
    if isinstance(value, list | tuple) and len(value) == len(members) and not names:
        return value[index]
    is_array = members[0].startswith("[")
    if is_array and getattr(value, "shape", ())[-1:] == (len(members),):
        return value[..., index : index + 1]
    shown = ", ".join(members)
    pairs = ", ".join(f'"{name}": …' for name in members)
    remedy = f"return {{{pairs}}}, or a tuple in that order"
    if is_array:
        remedy = f"return a list of {len(members)}"
    parts = value if isinstance(value, Mapping | list | tuple) else ()
    given = f"{type(value).__name__} of {len(parts)}" if parts else "one value"
    raise FormulaError(f"gives {given}, not {shown}", remedy=remedy)


def match_inputs(reference: Reference, call: Call, kept: Array, folder: str) -> Inputs:
    """The inputs under the names that the reference has for them: the function's own, or in the
    order of its parameters. Raises CallError: the reference's parameters are not the function's, or
    one is a texture whose texels are not known without a driver."""
    uniforms, textures = collect_opaque(call)
    numbers = _number_inputs(call, kept)
    numbers = replace(numbers, shared={**numbers.shared, **uniforms})
    new = _match_names(reference, call, numbers, textures)
    label = call.signature.name
    return Inputs(
        shared={new[n]: value for n, value in numbers.shared.items() if n in new},
        each={new[n]: value for n, value in numbers.each.items() if n in new},
        textures={
            new[n]: read_texels(source, f"{label}: {n}", Path(folder))
            for n, (_, source) in textures.items()
            if n in new
        },
        arrays=frozenset(new[n] for n in numbers.arrays if n in new),
    )


def _match_names(
    reference: Reference, call: Call, numbers: Inputs, textures: Collection[str]
) -> dict[str, str]:
    """The reference's name for each input that it may read."""
    parameters = parameters_of(reference).values()
    wanted = [p.name for p in parameters]
    required = [p.name for p in parameters if p.default is p.empty]
    inputs = (*call.signature.given, *call.signature.globals)
    every = [name for one in inputs for name, _ in one.type.leaves(one.name)]
    every = [name for name in every if name in numbers.exact or name in textures]
    known = {*numbers.parameters(), *map(parameter_name, textures)}
    if known.issuperset(required):
        return {n: n for n in every if n not in textures or parameter_name(n) in wanted}
    for names in (every, [name for name in every if name not in textures]):
        if len(names) in (len(required), len(wanted)):
            return dict(zip(names, wanted, strict=False))
    shown = ", ".join(map(parameter_name, every))
    raise CallError(
        f"{reference.__name__} takes {', '.join(wanted)}; {call.signature.name} gets {shown}",
        remedy="name the reference's parameters so, or take as many in the same order",
    )


def leaves(call: Call) -> Iterator[tuple[str, Type, Array]]:
    """Each number or vector that a call has, with its name, such as "light.constant"."""
    for name, given in call.values.items():
        for (word, kind), leaf in zip(given.type.leaves(name), given.leaves, strict=True):
            yield word, kind, leaf


@np.errstate(over="ignore")
def _number_inputs(call: Call, kept: Array) -> Inputs:
    shared: dict[str, Array] = {}
    each: dict[str, Array] = {}
    arrays = set()
    for word, kind, leaf in leaves(call):
        exact = leaf.astype(np.float32) if leaf.dtype.kind in "fb" or kind.kind == "float" else leaf
        own = (*kind.dims, *(kind.base_shape or (1,)))
        if kind.dims:
            arrays.add(word)
        if math.prod(leaf.shape[:-1]) == 1:
            shared[word] = exact.reshape(own)
        else:
            whole = np.broadcast_to(exact, (*call.batch, exact.shape[-1]))
            rows = whole.reshape(-1, *own)
            each[word] = rows if kept.all() else rows[kept]
    return Inputs(shared=shared, each=each, arrays=frozenset(arrays))
