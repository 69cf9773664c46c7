"""Searching for a counterexample to a property, and making it small.

The function is called once for a batch of samples, and so is the test, on arrays. A test that was
written for single numbers is called for each.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.errors import CallError
from shaderlab.files import display_path
from shaderlab.functions.domains import Domain, hints_of, weights
from shaderlab.functions.nesting import Values, element, flat, nested, rows, spelt, stretched
from shaderlab.model.frame import Array

if TYPE_CHECKING:
    from shaderlab.functions.function import Function

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
    """Searches one test's property.

    Args:
        function: what is called.
        domains: by the names of its arguments.
        test: what must not fail.
    """

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
        for name, _ in flat(self._domains):
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
                f"be what {self._function.__name__} gives",
                remedy=f"{self._function.__name__} takes {', '.join(sorted(inputs))}",
            )
        return others

    def run(self, batch: Batch) -> None:
        """Try a batch. Raises what the test raises for its simplest counterexample."""
        __tracebackhide__ = True
        if batch.seed is None:
            values = {n: np.asarray(v)[None] for n, v in flat(dict(batch.values))}
        else:
            rng = np.random.default_rng(batch.seed)
            searched = {n: d for n, d in flat(self._domains) if isinstance(d, Domain)}
            values = {
                name: domain.sample(rng, (SAMPLES, *self._types[name].shape), self._hints)
                for name, domain in searched.items()
            }
        if not values:
            raise CallError(f"given: nothing of {self._function.__name__} is searched")
        count = len(next(iter(values.values())))
        wrong = self._failing(values, count)
        if wrong is None:
            return
        if wrong.stop - wrong.start > 1:  # no single one fails: it is about several together
            self._call_test(self._arguments(rows(values, wrong)))
            return
        self._report(self._smallest(rows(values, wrong)))

    def _report(self, values: Values) -> None:
        """Run the test on one element, to fail as it does."""
        __tracebackhide__ = True
        arguments = self._arguments(values)
        single = {name: element(value, 0) for name, value in arguments.items()}
        place = display_path(*self._function.place)
        note = f"{self._function.__name__} of {place}, at its simplest counterexample:\n"
        note += f"@glsl.example({', '.join(spelt(values))})"
        results = {n: v for n, v in arguments.items() if n in self._result_names}
        note += "".join(f"\n{line}" for line in spelt(results)).replace("=", " = ")
        for some in (single, arguments):
            try:
                holds = self._test(**some)
            except Exception as error:
                error.add_note(note)
                raise
            if holds is not None and not np.all(holds):
                raise AssertionError(f"{self._test.__name__} does not hold\n{note}")

    def _smallest(self, values: Values) -> Values:
        """The same failure with simpler values, one number after the other."""
        for _ in range(_ROUNDS):
            before = sum(weights(v) for v in values.values())
            for name in values:
                domain = dict(flat(self._domains)).get(name)
                if not isinstance(domain, Domain):
                    continue
                shape = values[name].shape
                places: list[Any] = [...]
                if domain.by_component and len(shape) > 1:
                    places = list(np.ndindex(shape[1:]))
                for place in places:
                    values = self._simpler(values, name, domain, place)
            if sum(weights(v) for v in values.values()) >= before:
                break
        return values

    def _simpler(self, values: Values, name: str, domain: Domain, place: Any) -> Values:
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
            if self._fails({k: v[n : n + 1] for k, v in flat(arguments)}):
                return rows(tried, slice(n, n + 1))
        return values

    def _failing(self, values: Values, count: int) -> slice | None:
        """The rows of a failure, one where one is enough; None where the test passes."""
        arguments = self._arguments(values)
        if not self._one_by_one:
            try:
                holds = self._call_test(arguments)
            except ValueError as error:
                if "truth value of an array" not in str(error):
                    return self._halved(arguments)
                self._one_by_one = True
            except Exception:
                return self._halved(arguments)
            else:
                if holds is None or np.all(holds):
                    return None
                if np.ndim(holds) == 0:
                    return self._halved(arguments)
                wrong = ~np.asarray(holds).reshape(len(holds), -1).all(axis=1)
                first = int(np.argmax(wrong))
                return slice(first, first + 1)
        for n in range(count):
            if self._fails_at({name: element(value, n) for name, value in arguments.items()}):
                return slice(n, n + 1)
        return None

    def _halved(self, arguments: dict[str, Any]) -> slice:
        """The fewest rows that fail, found by halving."""
        parts = dict(flat(arguments))
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
        arguments = nested(parts)
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
        """What the test gets for some values: those that it asks for, and the result."""
        fixed = {n: d for n, d in flat(self._domains) if not isinstance(d, Domain)}
        named = nested({**fixed, **values})
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
        return {name: stretched(value, count) for name, value in found.items()}
