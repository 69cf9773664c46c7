"""`given`: a property of a function as a test of Hypothesis.

Hypothesis decides what is tried, and keeps what failed in its database. A draw of it is a batch of
samples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from shaderlab.errors import extra
from shaderlab.functions.notes import notes
from shaderlab.functions.searching import SAMPLES, Batch, Search, Test
from shaderlab.model.records import Outcome, SourceText

if TYPE_CHECKING:
    from shaderlab.functions.function import Function

DRAWS = 10


def given(function: Function, /, **domains: Any) -> Callable[[Test], Test]:
    """A test of a property: `@glsl.given(lighting.fresnel, cosine=glsl.floats(0, 1))`.

    The test gets the arguments by their names, and by any other name what the function gives for
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

    def decorated(test: Test) -> Test:
        with extra("pytest", "glsl.given"):
            import hypothesis
            from hypothesis import strategies

        search = Search(function, domains, test)

        def run(batch: Batch) -> None:
            __tracebackhide__ = True
            with _noted(function, test, batch):
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

    return decorated


@contextmanager
def _noted(function: Function, test: Test, batch: Batch) -> Iterator[None]:
    """Note how a batch fares, where a report wants it."""
    __tracebackhide__ = True
    found = notes()
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

    def decorated(test: Test) -> Test:
        known = getattr(test, "shaderlab_examples", ())
        test.shaderlab_examples = (values, *known)  # type: ignore[attr-defined]
        return test

    return decorated
