"""Discarded fragments: what a draw's geometry covers must be visible, unless a rule discards it.

An expectation that reads an attachment judges what is there. Whatever its kind, it fails where
fragments of the draws into this attachment are missing, or are visible and should be discarded.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import numpy as np

from shaderlab.bands import Band, Rules, TriBool
from shaderlab.bands.exact import as_tri_bool
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation, Programs
from shaderlab.model.frame import Array, Fragments, Frame, PassDraw, every_component

from ..judging.bands import CHUNK
from ..judging.references import evaluate, make_error, match_parameters, name_of
from .base import OutputExpectation
from .needs import CapturedFragments, Probe, inputs_of

Lend = Callable[[CapturedFragments], AbstractContextManager[None]]


class DiscardCheck:
    """The draws of a scene that may discard fragments, or should by a rule, and what is wrong with
    what they discarded; each draw is examined once. `scene` and `programs` are what is judged, all
    of a case's scene or a part of it; the expectations of the `whole` one have the rules."""

    def __init__(self, scene: Scene, programs: Programs, whole: Scene) -> None:
        self._scene = scene
        self._programs = programs
        self._rules = _rules_of(whole)
        self._faults: dict[PassDraw, str] = {}
        self._draws = {
            name: tuple(
                CapturedFragments((name, index))
                for index, draw in enumerate(draws)
                if self._rule_of((name, index)) is not None
                or any(word in draw.text("fragment") for word in ("discard", "gl_FragDepth"))
            )
            for name, draws in programs.items()
        }

    def needed(self, expectation: Expectation) -> Iterator[CapturedFragments]:
        """The draws into what an expectation reads that were not examined yet."""
        return (need for need in self._draws_of(expectation) if need.key not in self._faults)

    def _draws_of(self, expectation: Expectation) -> Iterator[CapturedFragments]:
        if not any(self._draws.values()):
            return
        reads = tuple(expectation.find_reads(self._scene))
        for name in dict.fromkeys(read.pass_name for read in reads):
            draws = self._programs.get(name, ())
            kept = {"depth", "stencil"}.union(*(draw.interface.outputs for draw in draws))
            if any(read.output in kept for read in reads if read.pass_name == name):
                yield from self._draws.get(name, ())

    def fault(self, expectation: Expectation, frame: Frame, lend: Lend) -> str:
        """Say what is wrong with the discarded fragments of what an expectation read, or ""; the
        frame, always the same one, gets the answers to needs that are lent. Raises FormulaError: a
        rule fails, or is not a comparison."""
        if isinstance(expectation, OutputExpectation):
            samples = frame.answers.get(Probe(expectation))
            if samples is not None and samples.discarded:
                return (
                    f"the shader discards {samples.discarded} of the samples, so they have no value"
                )
        for need in self._draws_of(expectation):
            if need.key not in self._faults:
                with lend(need):
                    self._faults[need.key] = self._find_fault_of(need.key, frame)
            if self._faults[need.key]:
                return self._faults[need.key]
        return ""

    def _find_fault_of(self, key: PassDraw, frame: Frame) -> str:
        name, index = key
        draw = self._programs[name][index]
        by_depth = "gl_FragDepth" in draw.text("fragment")
        missing, surplus = _faults(key, frame, by_depth, self._rule_of(key))
        of = f"of draw {index} of pass {name!r} ({draw.draw.fragment})"
        if missing.any():
            return (
                f"missing: {_describe_places(missing)} {of}, covered by the geometry and "
                "discarded by no rule\n→ if the shader should discard it, give discards=rule, a "
                "comparison of its inputs"
            )
        if surplus.any():
            return f"surplus: {_describe_places(surplus)} {of}, which its rule discards"
        return ""

    def _rule_of(self, key: PassDraw) -> OutputExpectation | None:
        """The rule of a draw, or else of another one of the same fragment shader."""
        shader = self._programs[key[0]][key[1]].draw.shaders[-1]
        return self._rules.get(key) or self._rules.get(shader)


def _rules_of(scene: Scene) -> Mapping[PassDraw | str, OutputExpectation]:
    rules: dict[PassDraw | str, OutputExpectation] = {}
    for expectation in scene.expect:
        if isinstance(expectation, OutputExpectation) and expectation.discards is not None:
            key = expectation.key(scene)
            rules.setdefault(key, expectation)
            rules.setdefault(scene.find_pass(key[0]).draws[key[1]].shaders[-1], expectation)
    return rules


def _faults(
    key: PassDraw, frame: Frame, by_depth: bool, rule: OutputExpectation | None
) -> tuple[Array, Array]:
    """Where fragments are missing, and where some are seen that should be discarded."""
    found = frame.answer(CapturedFragments(key))
    everything = found.undiscarded
    missing, surplus = (np.zeros_like(found.covered) for _ in range(2))
    if everything is not None and by_depth:
        # Another order of the surfaces may be meant, but not that none is seen.
        missing = everything.covered & (found.frag_coord[..., 3] == 0.0)
    elif everything is not None:
        at = np.flatnonzero(everything.covered)
        missing.flat[at] = ~_find_seen_alike(found, everything, at)
    if rule is not None:
        if everything is not None and missing.any():
            missing[missing] = _evaluate_rule(rule, frame, key, everything, missing).all_false
        surplus = found.covered.copy()
        surplus[surplus] = _evaluate_rule(rule, frame, key, found, surplus).all_true
    return missing, surplus


def _find_seen_alike(found: Fragments, everything: Fragments, at: Array) -> Array:
    pairs = [(found.frag_coord, everything.frag_coord)]
    pairs += [(values, everything.inputs[name]) for name, values in found.inputs.items()]
    seen: Array = found.covered.reshape(-1)[at]
    for pair in pairs:
        if pair[0] is pair[1]:
            continue  # what is the same was captured into the same array
        one, other = (values.reshape(found.covered.size, -1)[at] for values in pair)
        seen &= every_component((one == other) | ((one != one) & (other != other)))
    return seen


def _evaluate_rule(
    rule: OutputExpectation, frame: Frame, key: PassDraw, fragments: Fragments, where: Array
) -> TriBool:
    reference: Any = rule.discards
    values = {**fragments.inputs, "frag_coord": fragments.frag_coord}
    each = {name: array.reshape(-1, *array.shape[2:]) for name, array in values.items()}
    inputs = inputs_of(frame, key, each=each, given=getattr(rule, "given", {}))
    asked = match_parameters(reference, inputs)
    names = {name for names in asked.values() for name in names}
    inputs = replace(inputs, each={n: v for n, v in inputs.each.items() if n in names})
    bands = getattr(rule, "rules", None) or Rules()
    numbers = np.flatnonzero(where)
    yes, no = np.zeros((2, len(numbers), 1), np.bool_)
    for start in range(0, max(len(numbers), 1), CHUNK):
        rows = slice(start, start + CHUNK)
        part = inputs.part(numbers[rows])
        found = evaluate(reference, part, rules=bands, decimal=False, parameters=asked)
        try:
            if isinstance(found, Band):
                raise TypeError
            truth = as_tri_bool(found)
            yes[rows], no[rows] = truth.all_true, truth.all_false
        except (TypeError, ValueError):
            message = f"discards of {rule.name!r}: {name_of(reference)}() is not a comparison"
            remedy = "return one truth for each fragment, such as alpha < 0.1"
            raise make_error(reference, message, remedy) from None
    return TriBool(yes[:, 0], no[:, 0])


def _describe_places(where: Array) -> str:
    y, x = (int(k) for k in np.argwhere(where)[0])
    count = int(np.count_nonzero(where))
    return f"{count} fragment{'s' if count > 1 else ''} (the first at pixel {x}, {y})"
