"""given: a property of a function as a test of Hypothesis, with its counterexample made small."""

from __future__ import annotations

import inspect
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands.rounding import shortest
from shaderlab.errors import CallError, require_extra
from shaderlab.files import display_path
from shaderlab.functions.library import current_notes
from shaderlab.model.frame import Array
from shaderlab.model.records import Outcome, SourceText

if TYPE_CHECKING:
    from shaderlab.functions.library import Function


_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_TINY = float(np.finfo(np.float32).tiny)


class Domain(ABC):
    @abstractmethod
    def sample(self, rng: np.random.Generator, shape: tuple[int, ...], hints: Array) -> Array:
        """Random values and special ones; `hints` are numbers that the function is made of.

        Args:
            rng: the only source of chance.
            shape: of the values: the first axis counts samples, the others are those of the type.
            hints: numbers, (n,).
        """

    @abstractmethod
    def simpler(self, value: Any) -> list[Any]:
        """Values of the domain that are simpler than one, the simplest first; for one number, or
        for a whole vector where its numbers depend on each other."""

    by_component = True
    """Whether each number of a vector is a value by itself."""


@dataclass(frozen=True)
class Floats(Domain):
    """float32 values from `low` to `high`, both included; of vectors and matrices, each
    component's."""

    low: float
    high: float

    def __post_init__(self) -> None:
        if not -np.inf < self.low < self.high < np.inf:
            raise CallError(f"floats({self.low}, {self.high}): give two numbers, the lower first")

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
        if self.low > self.high:
            raise CallError(f"ints({self.low}, {self.high}): give two numbers, the lower first")

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
    digits, _, exponent = f"{np.float32(value):.9g}".partition("e")
    written = shortest(value).partition("e")[0]
    figures = len(written.strip("-0.").replace(".", ""))
    power = abs(int(exponent)) if exponent else max(len(digits.split(".")[0].strip("-")) - 2, 0)
    return figures + 0.5 * (value < 0) + power + (0.0 if value == 1 else 0.5) + abs(value) * 1e-9


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


def take_rows(values: Values, rows: slice) -> Values:
    return {name: value[rows] for name, value in values.items()}


def stretch(value: Any, count: int) -> Any:
    """Fixed values as many as there are samples."""
    if isinstance(value, Mapping):
        return {name: stretch(v, count) for name, v in value.items()}
    array = np.asanyarray(value)
    return (
        array
        if array.ndim and len(array) == count
        else np.broadcast_to(array, (count, *array.shape))
    )


def element(value: Any, n: int) -> Any:
    if isinstance(value, Mapping):
        return {name: element(v, n) for name, v in value.items()}
    return value[n]


def format_arguments(values: Values) -> Iterator[str]:
    def text(value: Any) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{n!r}: {text(v)}" for n, v in value.items()) + "}"
        single = np.asarray(value)[0]
        if np.ndim(single):
            return "[" + ", ".join(map(format_number, np.ravel(single))) + "]"
        return format_number(single)

    for name, value in nest(values).items():
        yield f"{name}={text(value)}"


def format_number(value: Any) -> str:
    """The shortest text with the same float32, integer or boolean."""
    return str(value) if np.asarray(value).dtype.kind != "f" else shortest(value)


SAMPLES = 10_000
"""Samples of a draw."""
_ROUNDS = 6

Test = Callable[..., Any]


@dataclass(frozen=True)
class Batch:
    """What one draw tries: samples by a seed, or some values."""

    seed: int | None
    values: tuple[tuple[str, Any], ...] = ()

    def __repr__(self) -> str:
        return f"{SAMPLES} samples of seed {self.seed}" if self.seed is not None else "an example"


class Search:
    """Searches one test's property."""

    def __init__(self, function: Function, domains: Mapping[str, Any], test: Test) -> None:
        self._function = function
        self._domains = domains
        self._test = test
        self._one_by_one = False

    @cached_property
    def _hints(self) -> Array:
        return hints_of("".join(s.code for s in self._function.signatures))

    @cached_property
    def _types(self) -> dict[str, Any]:
        """The type of each argument that is searched, members by their whole names."""
        inputs = {i.name: i.type for s in self._function.signatures for i in (*s.given, *s.globals)}
        found = {}
        for name, _ in flatten(self._domains):
            head, *members = name.split(".")
            if head not in inputs:
                known = ", ".join(inputs)
                message = f"given: {self._function.__name__} takes no {head!r}"
                raise CallError(message, remedy=f"there is: {known}")
            kind = inputs[head]
            for member in members:
                kind = dict(kind.members)[member]
            found[name] = kind
        return found

    @cached_property
    def _result_names(self) -> list[str]:
        """The test's parameters that get the result, or parts of it."""
        signatures = self._function.signatures
        inputs = {i.name for s in signatures for i in (*s.given, *s.globals)}
        outputs = {name for s in signatures for name, _ in s.outputs}
        others = [n for n in inspect.signature(self._test).parameters if n not in inputs]
        if len(others) > 1 and not outputs.issuperset(others):
            raise CallError(
                f"{self._test.__name__} has parameters {', '.join(others)}, of which only one can "
                f"be the result of {self._function.__name__}",
                remedy=f"{self._function.__name__} takes {', '.join(sorted(inputs))}",
            )
        return others

    def run(self, batch: Batch) -> None:
        """Try a batch. Raises what the test raises for its smallest counterexample."""
        __tracebackhide__ = True
        if batch.seed is None:
            values = {n: np.asarray(v)[None] for n, v in flatten(dict(batch.values))}
        else:
            rng = np.random.default_rng(batch.seed)
            searched = {n: d for n, d in flatten(self._domains) if isinstance(d, Domain)}
            values = {
                name: domain.sample(rng, (SAMPLES, *self._types[name].shape), self._hints)
                for name, domain in searched.items()
            }
        if not values:
            raise CallError(f"given: nothing of {self._function.__name__} is searched")
        count = len(next(iter(values.values())))
        wrong = self._find_failure(values, count)
        if wrong is None:
            return
        if wrong.stop - wrong.start > 1:  # no single one fails: it is about several together
            self._call_test(self._arguments(take_rows(values, wrong)))
            return
        self._report(self._simplify(take_rows(values, wrong)))

    def _report(self, values: Values) -> None:
        """Run the test on one element, to fail as it does."""
        __tracebackhide__ = True
        arguments = self._arguments(values)
        single = {name: element(value, 0) for name, value in arguments.items()}
        place = display_path(*self._function.place)
        note = f"smallest counterexample for {self._function.__name__} of {place}:\n"
        note += f"@glsl.example({', '.join(format_arguments(values))})"
        results = {n: v for n, v in arguments.items() if n in self._result_names}
        note += "".join(f"\n{line}" for line in format_arguments(results)).replace("=", " = ")
        for some in (single, arguments):
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
            before = sum(weights(v) for v in values.values())
            for name in values:
                domain = dict(flatten(self._domains)).get(name)
                if not isinstance(domain, Domain):
                    continue
                shape = values[name].shape
                places: list[Any] = [...]
                if domain.by_component and len(shape) > 1:
                    places = list(np.ndindex(shape[1:]))
                for place in places:
                    values = self._simplify_number(values, name, domain, place)
            if sum(weights(v) for v in values.values()) >= before:
                break
        return values

    def _simplify_number(self, values: Values, name: str, domain: Domain, place: Any) -> Values:
        old = values[name]
        whole = (0, ...) if place is ... else (0, *place)
        choices = domain.simpler(old[whole])
        if not choices:
            return values
        many = np.repeat(old, len(choices), axis=0)
        for n, choice in enumerate(choices):
            many[(n, *whole[1:])] = choice
        tried = {n: np.repeat(v, len(choices), axis=0) for n, v in values.items()} | {name: many}
        arguments = self._arguments(tried)
        for n in range(len(choices)):
            if self._fails({k: v[n : n + 1] for k, v in flatten(arguments)}):
                return take_rows(tried, slice(n, n + 1))
        return values

    def _find_failure(self, values: Values, count: int) -> slice | None:
        """The rows of a failure, one where one is enough; None where the test passes."""
        arguments = self._arguments(values)
        if not self._one_by_one:
            try:
                holds = self._call_test(arguments)
            except ValueError as error:
                if "truth value of an array" not in str(error):
                    return self._halve(arguments)
                self._one_by_one = True
            except Exception:
                return self._halve(arguments)
            else:
                if holds is None or np.all(holds):
                    return None
                if np.ndim(holds) == 0:
                    return self._halve(arguments)
                wrong = ~np.asarray(holds).reshape(len(holds), -1).all(axis=1)
                first = int(np.argmax(wrong))
                return slice(first, first + 1)
        for n in range(count):
            if self._fails_at({name: element(value, n) for name, value in arguments.items()}):
                return slice(n, n + 1)
        return None

    def _halve(self, arguments: dict[str, Any]) -> slice:
        """The fewest rows that fail, found by halving."""
        parts = dict(flatten(arguments))
        start, stop = 0, len(next(iter(parts.values())))
        while stop - start > 1:
            middle = (start + stop) // 2
            for half in (slice(start, middle), slice(middle, stop)):
                if self._fails({name: value[half] for name, value in parts.items()}):
                    start, stop = half.start, half.stop
                    break
            else:
                break
        return slice(start, stop)

    def _fails(self, parts: Values) -> bool:
        """Whether the test fails on some rows, given by whole names."""
        arguments = nest(parts)
        if self._one_by_one:
            arguments = {name: element(value, 0) for name, value in arguments.items()}
        return self._fails_at(arguments)

    def _fails_at(self, arguments: dict[str, Any]) -> bool:
        try:
            holds = self._test(**arguments)
        except Exception:
            return True
        return not (holds is None or np.all(holds))

    def _call_test(self, arguments: dict[str, Any]) -> Any:
        with np.errstate(all="ignore"):
            return self._test(**arguments)

    def _arguments(self, values: Values) -> dict[str, Any]:
        """What the test gets for some values: those among its parameters, and the result."""
        fixed = {n: d for n, d in flatten(self._domains) if not isinstance(d, Domain)}
        named = nest({**fixed, **values})
        result = self._function(**named)
        parts: dict[str, Any] = getattr(result, "_asdict", dict)()
        wanted = inspect.signature(self._test).parameters
        count = len(next(iter(values.values())))
        found = {}
        for name in wanted:
            if name in self._result_names:
                found[name] = parts.get(name, parts or result)
            elif name in named:
                found[name] = named[name]
        return {name: stretch(value, count) for name, value in found.items()}


DRAWS = 10


def given(function: Function, /, **domains: Any) -> Callable[[Test], Test]:
    """A test of a property: `@glsl.given(lighting.fresnel, cosine=glsl.floats(0, 1))`.

    The test gets the arguments by their names, and by any other name what the function returns for
    them; with `out` parameters that is a mapping, or each of them by its own name. It asserts on
    arrays, or on single numbers, or returns where the property holds.

    Args:
        function: what is called.
        domains: for each parameter and global the domain that is searched, such as
            `floats(0, 1)`, a mapping of domains for a struct, or a value.

    Raises:
        AssertionError: from the test, for a counterexample made as simple as possible; a note has
            it as a line to paste above the test: `@glsl.example(…)`.
    """

    def decorate(test: Test) -> Test:
        with require_extra("pytest", "glsl.given"):
            import hypothesis
            from hypothesis import strategies

        search = Search(function, domains, test)

        def run(batch: Batch) -> None:
            __tracebackhide__ = True
            with _note_outcome(function, test, batch):
                search.run(batch)

        # Hypothesis takes it for the test: failures show that, and the database knows it by that.
        for name in ("__name__", "__qualname__", "__module__", "__doc__"):
            setattr(run, name, getattr(test, name))
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
        batches = strategies.integers(0, 2**32 - 1).map(Batch)
        found: Test = settings(hypothesis.given(batch=batches)(run))
        for values in reversed(getattr(test, "shaderlab_examples", ())):
            found = hypothesis.example(batch=Batch(None, tuple(values.items())))(found)
        return found

    return decorate


@contextmanager
def _note_outcome(function: Function, test: Test, batch: Batch) -> Iterator[None]:
    """Note how a batch fares, where a report wants it."""
    __tracebackhide__ = True
    found = current_notes()
    file, line = function.place
    outcome = Outcome(
        name=function.__name__,
        kind="given",
        status="pass",
        judged=1 if batch.seed is None else SAMPLES,
        sources=(SourceText(file=file, line=line, language="glsl", text=str(function.__doc__)),),
        line=test.__code__.co_firstlineno,
    )
    try:
        yield
    except Exception as error:
        if found is not None:
            said = "\n".join([str(error) or type(error).__name__, *getattr(error, "__notes__", ())])
            found.outcomes.append(replace(outcome, status="fail", outside=1, message=said))
        raise
    if found is not None:
        found.outcomes.append(outcome)


def example(**values: Any) -> Callable[[Test], Test]:
    """Arguments that `given` tries first; stands below it."""

    def decorate(test: Test) -> Test:
        known = getattr(test, "shaderlab_examples", ())
        test.shaderlab_examples = (values, *known)  # type: ignore[attr-defined]
        return test

    return decorate
