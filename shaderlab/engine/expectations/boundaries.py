"""boundaries: the band holds on both sides of the places where the reference changes most."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass

import numpy as np

from shaderlab.errors import CaseError
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Judgement, Need, Programs
from shaderlab.model.frame import Array, Frame, Samples
from shaderlab.model.phases import phase

from ..judging.banded import NOTHING_DRAWN, judge_band
from ..judging.bands import PLACE
from ..judging.references import Inputs, evaluate, parameters_of
from .base import Context
from .formula import Reference, ReferenceExpectation
from .needs import CapturedFragments, OwnSamples, inputs_of

WAYS = 256
"""Straight ways between the inputs of two pixels."""
PARTS = 64
"""Parts of a way among which the steepest are looked for."""
ROUNDS, PIECES = 3, 8
"""How often such a part is divided again, and into how many."""
STEEPEST = 4
"""Of each way's parts one of so many."""


@dataclass(frozen=True)
class Boundaries(ReferenceExpectation):
    """The band derived from `reference` holds on both sides of the places where the reference
    changes most: steps, edges, thin lines.

    A threshold that is off by a little changes no pixel of most frames. Here straight ways are laid
    between the inputs of pixels that were drawn, and on each a place at which the reference changes
    most is searched for by bisection, to 3·10⁻⁵ of the way; the shader is run beside it. For the
    arguments see `Formula`. The shader must not discard there, nor take derivatives; in
    `gl_FragCoord`, and in `frag_coord`, it gets the pixel of this run. Raises CaseError: the shader
    reads no float that varies over the frame, or a vertex stage writes the output."""

    kind = "boundaries"
    named = "{self.output} at its boundaries"

    output: str
    reference: Reference
    _: KW_ONLY

    def needs(self, scene: Scene, programs: Programs) -> Iterable[Need]:
        if self.is_of_vertex(scene, programs):
            raise CaseError(
                f"boundaries of {self.output!r}: a vertex stage writes it",
                remedy="formula judges each vertex",
            )
        yield CapturedFragments(self.key(scene))
        yield BesideBoundaries(self)

    def judge(self, scene: Scene, frame: Frame) -> Judgement:
        key, samples = self.key(scene), frame.answer(BesideBoundaries(self))
        if not samples.outputs:
            return self.judge_rows((), NOTHING_DRAWN, judged=0)
        each = {**samples.inputs, **self.places(2)}
        inputs = inputs_of(frame, key, each=each, given=self.given)
        measured = samples.outputs[self.own_name(scene)]
        banded = judge_band(measured, self.reference, inputs, rules=self.rules)
        return self.judgement(scene, banded, banded.verdict())

    def places(self, rows: int) -> Mapping[str, Array]:
        """`frag_coord` of points in so many rows of a probe, if the reference asks for it."""
        if PLACE not in parameters_of(self.reference):
            return {}
        x, y = np.meshgrid(np.arange(WAYS) + 0.5, np.arange(rows) + 0.5)
        return {PLACE: np.stack([x, y, np.full_like(x, 0.5), np.ones_like(x)], -1).reshape(-1, 4)}


@dataclass(frozen=True, eq=False)
class BesideBoundaries(OwnSamples):
    """A draw's program run beside the places where an expectation's reference changes most."""

    expectation: Boundaries

    def answer(self, context: Context) -> Samples:
        """Run the program, if anything is drawn. Raises CaseError where no input varies."""
        expectation, session = self.expectation, context.session
        key = expectation.key(session.scene)
        with phase("draw", f"sampling for {expectation.name!r}"):
            captured, bindings = session.capture_fragments(key), context.bindings[key]
            if not captured.covered.any():
                return Samples(inputs={}, outputs={})
            each = {name: v[captured.covered] for name, v in captured.inputs.items()}

            def values(some: Mapping[str, Array]) -> Array:
                count = len(next(iter(some.values())))
                place = {
                    n: np.tile(v, (count // WAYS, 1)) for n, v in expectation.places(1).items()
                }
                inputs = Inputs.of(bindings, each={**some, **place}, given=expectation.given)
                found = evaluate(expectation.reference, inputs, rules=None, decimal=False)
                return np.broadcast_to(found, (count, np.shape(found)[-1] if np.ndim(found) else 1))

            if not any(_varies(v) for v in each.values()):
                raise CaseError(
                    f"boundaries of {expectation.output!r}: no float input varies over the frame",
                    remedy="value judges the output of a shader that gives one colour",
                )
            given = beside_boundaries(each, values)
            return session.probe(key, "fragment", [bindings], given)[0]


def beside_boundaries(
    each: Mapping[str, Array], values: Callable[[Mapping[str, Array]], Array]
) -> dict[str, Array]:
    """Inputs on both sides of places where a function changes most.

    Args:
        each: inputs that were met, by name, (count, components). What is no float stays as one
            end of a way has it.
        values: the function, (count, components) of so many inputs.

    Returns (2 · WAYS, components) by name, in float32 where `each` is.

    >>> x = np.linspace(0.0, 1.0, 9, dtype=np.float32)[:, None]
    >>> near = beside_boundaries({"x": x}, lambda each: each["x"] > 0.3)["x"]
    >>> below, above = near[near < 0.3].max(), near[near > 0.3].min()
    >>> bool(0.3 - below < 1e-4 and above - 0.3 < 1e-4)
    True
    """
    rng = np.random.default_rng(23)
    count = len(next(iter(each.values())))
    starts, ends = rng.integers(0, count, (2, WAYS))
    way = np.arange(WAYS)
    varying = {name for name, found in each.items() if _varies(found)}

    def at(t: Array) -> dict[str, Array]:
        """Inputs at shares of the ways, (…, WAYS), one after the other."""
        share = t.reshape(-1, 1)
        some = {}
        for name, found in each.items():
            start = np.tile(found[starts], (share.size // WAYS, 1))
            end = np.tile(found[ends], (share.size // WAYS, 1))
            some[name] = (
                (start + share * (end - start)).astype(found.dtype) if name in varying else start
            )
        return some

    low, high = np.zeros(WAYS), np.ones(WAYS)
    for number in range(1 + ROUNDS):
        parts = PIECES if number else PARTS
        t = low + np.linspace(0.0, 1.0, parts + 1)[:, None] * (high - low)
        found = np.nan_to_num(values(at(t)).reshape(parts + 1, WAYS, -1).astype(np.float64))
        steepness = np.abs(np.diff(found, axis=0)).max(axis=-1)
        if number:
            chosen = np.argmax(steepness, axis=0)
        else:
            chosen = np.argsort(-steepness, axis=0, kind="stable")[way % STEEPEST, way]
        low, high = t[chosen, way], t[chosen + 1, way]
    width = high - low
    return at(np.clip(np.stack([low - width, high + width]), 0.0, 1.0))


def _varies(values: Array) -> bool:
    return values.dtype.kind == "f" and bool((values != values[:1]).any())


boundaries = Boundaries
