"""Whether calls that were made otherwise came to the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from shaderlab.engine.expectations.gl_calls import GlCalls
from shaderlab.model.case import Scene
from shaderlab.model.frame import TracedCall
from shaderlab.mutation.results import Fate


def fate_of_unseen(
    scene: Scene, mutant: Sequence[TracedCall], original: Sequence[TracedCall]
) -> Fate:
    """The fate of a mutant that draws the same pixels, by the calls that were made.

    It is equivalent where each call that does something finds the very state that it found
    before. It has survived where other calls are made of a function that the scene has a
    `gl_calls` for, and all pass.
    """
    if _actions(mutant) == _actions(original):
        return Fate(status="equivalent", by="all that is drawn or written finds the same state")
    for expectation in scene.expect:
        if isinstance(expectation, GlCalls) and (
            _counted(expectation, mutant) != _counted(expectation, original)
        ):
            by = f"in the calls of {scene.variant}: {expectation.function}"
            return Fate(status="survived", by=by)
    return Fate(status="no difference", by="the same pixels, and no gl_calls is about these calls")


def _actions(trace: Sequence[TracedCall]) -> list[tuple[str, str, str]]:
    """Calls that do more than set state, with the state that they find."""
    return [(c.pass_name, str(c), c.state) for c in trace if c.state]


def _counted(expectation: GlCalls, trace: Sequence[TracedCall]) -> Counter[str]:
    """The calls that an expectation looks at, whatever their order."""
    return Counter(
        str(call)
        for call in trace
        if call.function == expectation.function and expectation.pass_name in (None, call.pass_name)
    )
