"""given: a property of a function as a test of Hypothesis, with its counterexample made small."""

from __future__ import annotations

import inspect
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.rounding import LARGEST, shortest
from shaderlab.errors import CallError, require_extra, suggest
from shaderlab.files import display_path
from shaderlab.functions.call import is_range
from shaderlab.functions.library import NOTES, Function
from shaderlab.model.checked import Checked, check_arguments, is_array
from shaderlab.model.frame import Array
from shaderlab.model.records import Outcome, SourceText

if TYPE_CHECKING:
    from shaderlab.functions.signatures import Type


_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_TINY = float(np.finfo(np.float32).tiny)


class Domain(Checked, ABC):
    @abstractmethod
    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        """Random values and special ones, of a shape whose first axis counts samples; `hints` are
        numbers, (n,), that the function is made of."""

    @abstractmethod
    def simpler(self, value: Any) -> list[Any]:
        """Values of the domain that are simpler than one, the simplest first; for one number, or
        for a whole vector where its numbers depend on each other."""

    by_component = True  # each number of a vector is a value by itself


@dataclass(frozen=True)
class Floats(Domain):
    """float32 values from `low` to `high`, both included; of vectors and matrices, each
    component's."""

    low: float
    high: float

    def __post_init__(self) -> None:
        if not -LARGEST <= self.low < self.high <= LARGEST:
            raise CallError(f"floats({self.low}, {self.high}): give two floats, the lower first")

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        count = math.prod(shape)
        low, high = np.float32(self.low), np.float32(self.high)
        # One in each of so many equal pieces, so that no piece of a hundredth is left out.
        even = low + (high - low) * (rng.permutation(count) + rng.random(count)) / count
        near = rng.choice(np.array([low, high, 0.0]), count) + rng.choice([-1.0, 1.0], count) * (
            (high - low) * 10.0 ** rng.uniform(-9.0, 0.0, count)
        )
        special = rng.choice(self._special(hints), count)
        kind = rng.random(count)
        found = np.where(kind < 0.5, even, np.where(kind < 0.75, near, special))
        found = np.where((found >= low) & (found <= high), found, even)
        found = np.clip(found.astype(np.float32), low, high).reshape(shape)
        return _with_corners(found, self.low, self.high)

    def _special(self, hints: Array) -> Array:
        plain = np.array([0.0, -0.0, 1.0, 0.5, 2.0, 0.25, 0.1, _TINY, 1e-6, 1e-3, 10.0, 100.0])
        whole = np.arange(math.ceil(max(self.low, -64)), math.floor(min(self.high, 64)) + 1)
        points = np.concatenate([plain, -plain, whole, hints, -hints]).astype(np.float32)
        points = np.concatenate([points, np.array([self.low, self.high], np.float32)])
        around = [np.nextafter(points, np.float32(end)) for end in (-np.inf, np.inf)]
        points = np.concatenate([points, *around])
        inside = (points >= np.float32(self.low)) & (points <= np.float32(self.high))
        if math.copysign(1.0, self.low) > 0.0:  # −0.0 lies below 0.0: 1/x has another sign there
            inside &= ~np.signbit(points)
        special: Array = points[inside & ((points == 0.0) | (np.abs(points) >= _TINY))]
        return special

    def simpler(self, value: Any) -> list[Any]:
        x = float(value)
        found = [0.0, 1.0, -1.0, 0.5, 2.0, self.low, self.high, float(round(x)), float(int(x))]
        found += [float(f"{x:.{digits}g}") for digits in range(1, 9)]
        found += [round(x, digits) for digits in range(1, 7)]
        found += [x / 2.0, x - math.copysign(1.0, x)]
        low, high = float(np.float32(self.low)), float(np.float32(self.high))
        inside = {float(np.float32(v)) for v in found if low <= float(np.float32(v)) <= high}
        return sorted((v for v in inside if weight(v) < weight(x)), key=weight)


@dataclass(frozen=True)
class Ints(Domain):
    """Whole numbers from `low` to `high`, both included."""

    low: int
    high: int

    def __post_init__(self) -> None:
        if not -(2**31) <= self.low <= self.high < 2**32:
            raise CallError(f"ints({self.low}, {self.high}): give two of 32 bits, the lower first")

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        even = rng.integers(self.low, self.high, shape, endpoint=True)
        points = np.concatenate([[self.low, self.high, 0, 1, -1, 2], np.rint(hints)])
        points = points[(points >= self.low) & (points <= self.high)]
        special = rng.choice(points, shape).astype(np.int64)
        found = np.where(rng.random(shape) < 0.25, special, even)
        return _with_corners(found, self.low, self.high)

    def simpler(self, value: Any) -> list[Any]:
        n = int(value)
        found = {0, 1, -1, 2, self.low, self.high, n // 2, n - 1, n + 1, -n}
        inside = (v for v in found if self.low <= v <= self.high)
        return sorted((v for v in inside if weight(v) < weight(n)), key=weight)


@dataclass(frozen=True)
class OneOf(Domain):
    """Some values, the simplest first."""

    values: Sequence[Any]
    by_component = False

    def __post_init__(self) -> None:
        if not self.values or not is_array(self.values):
            raise CallError("one_of: give numbers, or arrays of numbers of one shape")

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        values: Array = np.asarray(self.values)
        return values[rng.integers(0, len(values), shape[0])]

    def simpler(self, value: Any) -> list[Any]:
        values = [np.asarray(v) for v in self.values]
        place = next(n for n, v in enumerate(values) if np.array_equal(v, value))
        return list(values[:place])


@dataclass(frozen=True)
class Directions(Domain):
    by_component = False

    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        if len(shape) != 2:
            raise CallError("glsl.directions() are of vectors", remedy="give a range: (0, 1)")
        vectors = rng.normal(size=shape)
        axes = np.concatenate([np.eye(shape[-1]), -np.eye(shape[-1])])
        some = rng.random(shape[:-1]) < 0.1
        vectors[some] = axes[rng.integers(0, len(axes), int(some.sum()))]
        length = np.linalg.norm(vectors, axis=-1, keepdims=True)
        return np.asarray(vectors / np.maximum(length, _TINY), np.float32)

    def simpler(self, value: Any) -> list[Any]:
        size = len(value)
        axes = [sign * axis for axis in np.eye(size) for sign in (1.0, -1.0)]
        rounded = [np.round(value, digits) for digits in (0, 1, 2)]
        units = [v / np.linalg.norm(v) for v in rounded if np.linalg.norm(v) > 0.0]
        found = [np.asarray(v, np.float32) for v in (*axes, *units)]
        return [v for v in found if weights(v) < weights(value)]


def _with_corners(values: Array, low: float, high: float) -> Array:
    """The samples, of which the first few are the same simple number in all their components: all
    arguments together, where each has some."""
    corners = np.clip(np.array([0, low, high, 1, -1]), low, high)
    for n in range(min(len(corners), len(values))):
        values[n] = corners[n]
    return values


floats, ints, directions = Floats, Ints, Directions


def bools() -> Domain:
    return OneOf([False, True])


def one_of(*values: Any) -> Domain:
    """One of these values, numbers or arrays; the simplest first."""
    return OneOf(values)


def hints_of(code: str) -> Array:
    """The numbers that stand in a piece of GLSL: branches change there."""
    return np.unique(np.array([float(n) for n in _NUMBER.findall(code)], np.float64))


def weight(value: float) -> float:
    """How far a number is from a simple one: 0 for 0, little for few digits."""
    if value == 0:
        return 0.0 if math.copysign(1.0, value) > 0.0 else 0.25
    if not math.isfinite(value):
        return 50.0
    written = len(shortest(abs(value)))
    return written + 0.5 * (value < 0) - 0.5 * (value == 1) + abs(value) * 1e-9


def weights(values: Any) -> float:
    return float(sum(weight(float(v)) for v in np.ravel(values)))


Values = dict[str, Array]


def flatten(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Mappings as one, with names such as "light.power"."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from flatten(value, f"{before}{name}.")
        else:
            yield before + name, value


def nest(values: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        *heads, last = name.split(".")
        inner = found
        for head in heads:
            inner = inner.setdefault(head, {})
        inner[last] = value
    return found


def take(values: Mapping[str, Any], rows: int | slice) -> dict[str, Any]:
    """Some rows of all arrays in nested mappings."""
    return nest({name: value[rows] for name, value in flatten(values)})


def format_arguments(values: Mapping[str, Any]) -> Iterator[str]:
    """The first row of each argument as a keyword."""

    def text(value: Any) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{n!r}: {text(v)}" for n, v in value.items()) + "}"
        single = np.asarray(value)[0]
        if np.ndim(single):
            return "[" + ", ".join(map(format_number, np.ravel(single))) + "]"
        return format_number(single)

    for name, value in nest(values).items():
        yield f"{name}={text(value)}"


def _to_array(value: Any, label: str) -> Array:
    try:
        return np.asarray(value)
    except ValueError:
        raise CallError(f"{label} {value!r:.60}, of which rows differ in length") from None


def format_number(value: Any) -> str:
    """The shortest text with the same float32, integer or boolean."""
    return str(value) if np.asarray(value).dtype.kind != "f" else shortest(value)


SAMPLES = 10_000
"""Samples of a draw."""
_ROUNDS = 6

Test = Callable[..., Any]
Batch = int | dict[str, Any]
"""What one draw tries: samples by a seed, or the values of an example."""


class Search:
    """Searches one test's property."""

    def __init__(self, function: Function, domains: Mapping[str, Any], test: Test) -> None:
        self._function = function
        self._test = test
        self._given = domains
        self._one_by_one = self._is_sampled = False

    @cached_property
    def _inputs(self) -> dict[str, Type]:
        """The types of what the function takes, by name."""
        signatures = self._function.signatures
        return {i.name: i.type for s in signatures for i in (*s.given, *s.globals)}

    @cached_property
    def _domains(self) -> dict[str, Any]:
        found = {}
        for name, value in flatten(self._given):
            kind = self._type_of(name)
            if is_range(value, kind, f"given: {name}"):
                value = (Floats if kind.name == "float" else Ints)(*value)
            elif isinstance(value, str) and value == "unit":
                value = Directions()
            if isinstance(value, Domain):
                found[name] = value
        return found

    @cached_property
    def _fixed(self) -> dict[str, Any]:
        return {n: d for n, d in flatten(self._given) if n not in self._domains}

    @cached_property
    def _result_names(self) -> list[str]:
        """The test's parameters that get the result, or parts of it."""
        outputs = {name for s in self._function.signatures for name, _ in s.outputs}
        others = [n for n in inspect.signature(self._test).parameters if n not in self._inputs]
        if len(others) > 1 and not outputs.issuperset(others):
            raise CallError(
                f"{self._test.__name__} has parameters {', '.join(others)}, of which only one can "
                f"be the result of {self._function.__name__}",
                remedy=f"{self._function.__name__} takes {', '.join(sorted(self._inputs))}",
            )
        return others

    @cached_property
    def proof(self) -> tuple[bool, dict[str, tuple[float, ...]]]:
        """Whether the test is shown to hold for all arguments, on every conforming device; else
        arguments for which it does not hold in float32, or none."""
        from shaderlab.functions.proving import prove_test

        domains: Mapping[str, Any] = self._domains
        try:
            ends = {n: "unit" if d == Directions() else (d.low, d.high) for n, d in domains.items()}
            ends |= {n: (float(v), float(v)) for n, v in self._fixed.items()}
            found = prove_test(self._function, self._test, ends, self._result_names)
        except Exception:  # the test does what bands don't, or the function what can't be proved
            return False, {}
        for batch, row, _ in found.points.values():
            return False, batch.example(row, domains)
        return all(claim.status == "proved" for claim in found.claims()), {}

    def run(self, batch: Batch) -> int:
        """Try a batch; of what is proved samples once, since a driver may not conform. How many
        arguments were tried. Raises what the test raises for its smallest counterexample."""
        __tracebackhide__ = True
        if isinstance(batch, dict):
            values = {n: _to_array(v, f"example: {n} is")[None] for n, v in flatten(batch)}
        elif self.proof[0] and self._is_sampled:
            return 0
        else:
            rng = np.random.default_rng(batch)
            hints = hints_of("".join(s.code for s in self._function.signatures))
            values = {
                name: domain.sample(rng, (SAMPLES, *self._type_of(name).shape), hints)
                for name, domain in self._domains.items()
            }
            for name, value in self.proof[1].items():
                values[name][0] = np.reshape(value, values[name].shape[1:])
        if not values:
            message = f"given: nothing of {self._function.__name__} is searched"
            raise CallError(message, remedy=f"{next(iter(self._inputs), 'x')}=(0, 1)")
        arguments = self._arguments(values)
        if not self._fails(arguments):
            self._is_sampled |= not isinstance(batch, dict)
            return _count(arguments)
        wrong = self._halve(arguments)
        values = {name: value[wrong] for name, value in values.items()}
        if wrong.stop - wrong.start > 1:  # no single one fails: it is about several together
            self._test(**self._arguments(values))
        else:
            self._report(self._simplify(values))
        return _count(arguments)

    def _type_of(self, name: str) -> Type:
        """The type of an argument, or of a member by its whole name."""
        head, *members = name.split(".")
        known: Mapping[str, Type] = self._inputs
        for part in (head, *members):
            if part not in known:
                message = f"given: {self._function.__name__} takes no {name!r}"
                raise CallError(message, remedy=suggest(part, known))
            known = dict((kind := known[part]).members)
        return kind

    def _report(self, values: Values) -> None:
        """Run the test on one element, to fail as it does."""
        __tracebackhide__ = True
        arguments = self._arguments(values)
        place = display_path(*self._function.place)
        note = f"smallest counterexample for {self._function.__name__} of {place}:\n"
        note += f"@glsl.example({', '.join(format_arguments(values))})"
        results = {n: v for n, v in arguments.items() if n in self._result_names}
        note += "".join(f"\n{line}" for line in format_arguments(results)).replace("=", " = ")
        for some in (take(arguments, 0), arguments):
            try:
                holds = self._test(**some)
            except Exception as error:
                error.add_note(note)
                raise
            if holds is not None and not np.all(holds):
                raise AssertionError(f"{self._test.__name__} does not hold\n{note}")

    def _simplify(self, values: Values) -> Values:
        """The same failure with simpler values, one number after the other."""
        for _ in range(_ROUNDS):
            before = sum(map(weights, values.values()))
            for name in [n for n in values if n in self._domains]:
                domain, shape = self._domains[name], values[name].shape[1:]
                for place in np.ndindex(shape) if domain.by_component else [()]:
                    values = self._simplify_number(values, name, domain, place)
            if sum(map(weights, values.values())) >= before:
                break
        return values

    def _simplify_number(
        self, values: Values, name: str, domain: Domain, place: tuple[int, ...]
    ) -> Values:
        choices = domain.simpler(values[name][(0, *place)])
        if not choices:
            return values
        tried = {n: np.repeat(v, len(choices), axis=0) for n, v in values.items()}
        for n, choice in enumerate(choices):
            tried[name][(n, *place)] = choice
        arguments = self._arguments(tried)
        for n in range(len(choices)):
            if self._fails(take(arguments, slice(n, n + 1))):
                return {name: value[n : n + 1] for name, value in tried.items()}
        return values

    def _halve(self, arguments: dict[str, Any]) -> slice:
        """The fewest rows that fail, found by halving."""
        start, stop = 0, _count(arguments)
        while stop - start > 1:
            middle = (start + stop) // 2
            for half in (slice(start, middle), slice(middle, stop)):
                if self._fails(take(arguments, half)):
                    start, stop = half.start, half.stop
                    break
            else:
                break
        return slice(start, stop)

    def _fails(self, arguments: dict[str, Any]) -> bool:
        """Whether the test fails on some rows: on all as arrays, or, if it is written for single
        numbers, on one of them."""
        if not self._one_by_one:
            try:
                return self._fails_at(arguments)
            except ValueError:
                self._one_by_one = True
        return any(self._fails_at(take(arguments, n)) for n in range(_count(arguments)))

    def _fails_at(self, arguments: dict[str, Any]) -> bool:
        """Whether the test fails. Raises ValueError: it takes an array for one number."""
        try:
            with np.errstate(all="ignore"):
                holds = self._test(**arguments)
        except Exception as error:
            if isinstance(error, ValueError) and "truth value of an array" in str(error):
                raise
            return True
        return not (holds is None or np.all(_to_array(holds, f"{self._test.__name__} returns")))

    def _arguments(self, values: Values) -> dict[str, Any]:
        """What the test gets for some values: those among its parameters, and the result."""
        count = len(next(iter(values.values())))
        named = nest({**self._fixed, **values})
        result = self._function(**named)
        parts: dict[str, Any] = getattr(result, "_asdict", dict)()
        found = {}
        for name in inspect.signature(self._test).parameters:
            if name in self._result_names:
                found[name] = parts.get(name, parts or result)
            elif name in named:
                found[name] = named[name]
        return nest({name: _stretch(value, count) for name, value in flatten(found)})


def _count(arguments: Mapping[str, Any]) -> int:
    return len(next(value for _, value in flatten(arguments)))


def _stretch(value: Any, count: int) -> Any:
    """A fixed value as often as there are samples."""
    array = np.asanyarray(value)
    if array.ndim and len(array) == count:
        return array
    return np.broadcast_to(array, (count, *array.shape))


DRAWS = 10


def given(function: Function, /, **domains: Any) -> Callable[[Test], Test]:
    """A test of a property: `@glsl.given(lighting.fresnel, cosine=glsl.floats(0, 1))`.

    A proof for all arguments is tried first, as of `Function.prove`: of a test that compares, such
    as `assert 0 <= y <= 1`. Else the property is searched with samples. The report says which.

    The test gets the arguments by their names, and by any other name what the function returns for
    them; with `out` parameters that is a mapping, or each of them by its own name. It asserts on
    arrays, or on single numbers, or returns where the property holds.

    `domains` has for each parameter and global the domain that is searched, such as `floats(0, 1)`,
    or `(0, 1)` for one number, a mapping of them for a struct, or a value. Raises AssertionError:
    from the test, for a counterexample made as simple as possible; a note has it as a line to paste
    above the test: `@glsl.example(…)`."""
    check_arguments(given, function=function)

    def decorate(test: Test) -> Test:
        if not inspect.isfunction(test):
            raise CallError(f"glsl.given is written above a test, not {test!r:.60}")
        with require_extra("pytest", "glsl.given"):
            import hypothesis
            from hypothesis import strategies

        search = Search(function, domains, test)

        def run(batch: Batch) -> None:
            __tracebackhide__ = True
            _run(search, function, batch, test.__code__.co_firstlineno)

        # Hypothesis takes it for the test: failures show that, and the database knows it by that.
        for name in ("__name__", "__qualname__", "__module__", "__doc__"):
            setattr(run, name, getattr(test, name))
        run.__annotations__ = {}
        code = test.__code__
        run.__code__ = run.__code__.replace(
            co_filename=code.co_filename, co_firstlineno=code.co_firstlineno
        )
        settings = hypothesis.settings(
            max_examples=DRAWS,
            deadline=None,
            verbosity=hypothesis.Verbosity.quiet,
            phases=[p for p in hypothesis.Phase if p.name in ("explicit", "reuse", "generate")],
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        seeds = strategies.integers(0, 2**32 - 1)
        found: Test = settings(hypothesis.given(batch=seeds)(run))
        for values in reversed(getattr(test, "shaderlab_examples", ())):
            found = hypothesis.example(batch=values)(found)
        return found

    return decorate


def _run(search: Search, function: Function, batch: Batch, at: int) -> None:
    """Run a batch, and note how it fares, where a report wants it: whether it is proved."""
    __tracebackhide__ = True
    found = NOTES.get()
    file, line = function.place
    outcome = Outcome(
        name=function.__name__,
        kind="given",
        status="pass",
        judged=1 if isinstance(batch, dict) else SAMPLES,
        sources=(SourceText(file=file, line=line, language="glsl", text=str(function.__doc__)),),
        line=at,
    )
    try:
        judged = search.run(batch)
        outcome = replace(outcome, judged=judged, kind="proof" if search.proof[0] else "given")
    except Exception as error:
        said = "\n".join([str(error) or type(error).__name__, *getattr(error, "__notes__", ())])
        outcome = replace(outcome, status="fail", outside=1, message=said)
        raise
    finally:
        if found is not None:
            found.outcomes.append(outcome)


def example(**values: Any) -> Callable[[Test], Test]:
    """Arguments that `given` tries first; stands below it."""

    def decorate(test: Test) -> Test:
        known = getattr(test, "shaderlab_examples", ())
        test.shaderlab_examples = (values, *known)  # type: ignore[attr-defined]
        return test

    return decorate
