"""Fragments that a shader keeps out: all that a draw's geometry covers is expected to be seen, but
for what a rule says is discarded.

An expectation that reads an attachment judges what is there. Whatever its kind, it fails where
fragments of the draws that make this attachment are missing, or are seen and should be discarded.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any

import numpy as np

from shaderlab.bands import Band, Rules, Truth
from shaderlab.bands.truth import as_truth
from shaderlab.errors import FormulaError
from shaderlab.expectations.base import OfOutput
from shaderlab.expectations.needs import CapturedFragments, Probe
from shaderlab.expectations.subject import inputs_of
from shaderlab.frame import Array, Fragments, Frame, PassDraw, every_component
from shaderlab.judging.inputs import evaluate, name_of, source_of
from shaderlab.model import Expectation, Programs, Scene
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.stages import may_discard, writes_depth

DiscardRules = Mapping[PassDraw | str, OfOutput]
DrawFaults = MutableMapping[PassDraw, str]
"""What is wrong with the fragments that each draw kept out; "" for nothing."""


def rules_of(scene: Scene) -> DiscardRules:
    """The expectations of a whole scene that say what is discarded, by draw and by shader."""
    rules: dict[PassDraw | str, OfOutput] = {}
    for expectation in scene.expect:
        if isinstance(expectation, OfOutput) and expectation.discards is not None:
            key = expectation.key(scene)
            rules.setdefault(key, expectation)
            rules.setdefault(scene.find_pass(key[0]).draws[key[1]].shaders[-1], expectation)
    return rules


def needed(
    expectation: Expectation, scene: Scene, programs: Programs, rules: DiscardRules
) -> Iterator[CapturedFragments]:
    """The draws that may leave something out of the attachments that an expectation reads, or
    should by a rule."""
    for name in dict.fromkeys(read.pass_name for read in expectation.reads(scene)):
        draws = programs.get(name, ())
        kept = {"depth", "stencil"}.union(*(draw.interface.outputs for draw in draws))
        if all(r.output not in kept for r in expectation.reads(scene) if r.pass_name == name):
            continue
        for index, draw in enumerate(draws):
            text = draw.text("fragment") or ""
            rule = _rule_of((name, index), draw, rules)
            if rule is not None or may_discard(text) or writes_depth(text):
                yield CapturedFragments((name, index))


def fault(
    expectation: Expectation,
    scene: Scene,
    programs: Programs,
    frame: Frame,
    rules: DiscardRules,
    known: DrawFaults,
) -> str:
    """What is wrong with the fragments that were kept out of what an expectation read, or "".

    Args:
        expectation: what was judged.
        scene, programs, frame: what was drawn, with answers to `needed`.
        rules: what `rules_of` gives for the whole scene.
        known: what was found of draws of this frame before; it is added to.

    Raises:
        FormulaError: a rule fails, or is no comparison.
    """
    samples = frame.answers.get(Probe(expectation)) if isinstance(expectation, OfOutput) else None
    if samples is not None and samples.discarded:
        return f"the shader discards {samples.discarded} of the samples, and gives no value there"
    for need in needed(expectation, scene, programs, rules):
        if need.key not in known:
            known[need.key] = _fault_of(need.key, programs, frame, rules)
        if known[need.key]:
            return known[need.key]
    return ""


def _fault_of(key: PassDraw, programs: Programs, frame: Frame, rules: DiscardRules) -> str:
    name, index = key
    draw = programs[name][index]
    by_depth = writes_depth(draw.text("fragment") or "")
    missing, surplus = _faults(key, frame, by_depth, _rule_of(key, draw, rules))
    of = f"of draw {index} of pass {name!r} ({draw.draw.fragment})"
    if missing.any():
        return (
            f"missing: {_places(missing)} {of}, covered by the geometry and discarded by "
            "no rule\n→ if the shader is to discard it, say so: discards=rule, a comparison "
            "of its inputs"
        )
    if surplus.any():
        return f"surplus: {_places(surplus)} {of}, which its rule says is discarded"
    return ""


def _rule_of(key: PassDraw, draw: PreparedDraw, rules: DiscardRules) -> OfOutput | None:
    """The rule of a draw, or else of another one of the same fragment shader."""
    return rules.get(key) or rules.get(draw.draw.shaders[-1])


def _faults(
    key: PassDraw, frame: Frame, by_depth: bool, rule: OfOutput | None
) -> tuple[Array, Array]:
    """Where fragments are missing, and where some are seen that should be discarded."""
    found: Fragments = frame.answers[CapturedFragments(key)]
    everything = found.undiscarded
    missing, surplus = (np.zeros_like(found.covered) for _ in range(2))
    if everything is not None and by_depth:
        # Another order of the surfaces may be meant, but not that none is seen.
        missing = everything.covered & (found.frag_coord[..., 3] == 0.0)
    elif everything is not None:
        missing = everything.covered & ~_seen_alike(found, everything)
    if rule is not None:
        if everything is not None:
            missing[missing] = _truth(rule, frame, key, everything, missing).all_false
        surplus = found.covered.copy()
        surplus[surplus] = _truth(rule, frame, key, found, surplus).all_true
    return missing, surplus


def _seen_alike(found: Fragments, everything: Fragments) -> Array:
    """Where the very fragment is seen that would be if none were discarded."""
    pairs = [(found.frag_coord, everything.frag_coord)]
    pairs += [(values, everything.inputs[name]) for name, values in found.inputs.items()]
    seen: Array = found.covered.copy()
    for one, other in pairs:
        same = (one == other) | ((one != one) & (other != other))
        seen &= every_component(same.reshape(*seen.shape, -1))
    return seen


def _truth(
    rule: OfOutput, frame: Frame, key: PassDraw, fragments: Fragments, where: Array
) -> Truth:
    """Whether each of some fragments is discarded, (count,)."""
    reference: Any = rule.discards
    values = {**fragments.inputs, "frag_coord": fragments.frag_coord}
    each = {name: array[where] for name, array in values.items()}
    inputs = inputs_of(frame, key, each=each, given=getattr(rule, "given", {}))
    bands = getattr(rule, "rules", None) or Rules()
    found = evaluate(reference, inputs, rules=bands, decimal=False)
    count = int(np.count_nonzero(where))
    try:
        if isinstance(found, Band):
            raise TypeError
        truth = as_truth(found)
        yes, no = (np.broadcast_to(f, (count, 1)) for f in (truth.all_true, truth.all_false))
        return Truth(yes[:, 0], no[:, 0])
    except (TypeError, ValueError):
        place = source_of(reference)
        raise FormulaError(
            f"discards of {rule.name!r}: {name_of(reference)}() is no comparison",
            file=place.file,
            line=place.line,
            remedy="return one truth for each fragment, such as alpha < 0.1",
        ) from None


def _places(where: Array) -> str:
    """How many pixels, and the first of them."""
    y, x = (int(k) for k in np.argwhere(where)[0])
    count = int(np.count_nonzero(where))
    return f"{count} fragment{'s' if count > 1 else ''} (the first at pixel {x}, {y})"
