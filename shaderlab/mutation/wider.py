"""Inputs far beyond a case's own, to tell mutants that change nothing from those that nobody saw.

A mutant that passes every expectation is run on random inputs and uniforms: numbers around zero,
numbers of every size, the case's own values changed, and numbers at which formulas turn: 0, ±1
and each constant of the shader.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from shaderlab.evaluation import Evaluation
from shaderlab.frame import Array, PassDraw
from shaderlab.programs.bind import declared
from shaderlab.programs.formats import shape_of
from shaderlab.programs.varyings import elements

SAMPLES = 1024
ROUNDS = 6
_NUMBER = re.compile(r"(?<![\w.])\d+\.\d*(?:e[-+]?\d+)?", re.IGNORECASE)


@dataclass(frozen=True)
class Round:
    """Inputs of one draw's stages, and the uniforms to run them with."""

    fragments: Mapping[str, Array]
    vertices: Mapping[str, Array]
    uniforms: Mapping[str, Array]


def rounds(original: Evaluation, key: PassDraw, seed: int) -> list[Round]:
    """Random inputs for a draw; the first round keeps the case's own uniforms.

    They follow from the unmutated shader, so that every mutant gets the same ones.
    """
    draw = original.programs[key[0]][key[1]]
    random = np.random.default_rng(seed)
    turns = _turning_points((draw.text("vertex") or "") + (draw.text("fragment") or ""))
    own = original.drawn.bindings[key].uniforms
    kinds = {n: v.type for n, v in declared(draw.interface).items()}
    varyings = {
        v.name: (shape_of(v.type), v.type) for v in elements(draw.interface.varyings.values())
    }
    mesh = draw.draw.mesh
    attributes: dict[str, tuple[tuple[int, ...], str]] = {}
    if mesh is not None and draw.draw.geometry is None:
        kinds_of = {n: v.type for n, v in draw.interface.attributes.items()}
        attributes = {n: (a.shape[1:], kinds_of[n]) for n, a in mesh.inputs.items()}
    return [
        Round(
            fragments=_inputs(random, varyings, turns),
            vertices=_inputs(random, attributes, turns),
            uniforms={n: _like(random, v, turns, kinds.get(n, "float")) for n, v in own.items()}
            if number
            else {},
        )
        for number in range(ROUNDS)
    ]


def outputs(
    evaluation: Evaluation, key: PassDraw, some: Iterable[Round]
) -> Iterator[tuple[tuple[str, int], Array]]:
    """Each output of a draw's stages by name and round, as the pass's target stores it."""
    session, bindings = evaluation.session, evaluation.drawn.bindings[key]
    for number, given in enumerate(some):
        changed = replace(bindings, uniforms={**bindings.uniforms, **given.uniforms})
        fragments = session.probe_fragments(key, changed, given.fragments)
        for name, values in fragments.outputs.items():
            image = evaluation.drawn.images.get((key[0], name))
            yield (name, number), values if image is None else stored(values, image.format)
        if given.vertices:
            vertices = session.probe_vertices(key, changed, given.vertices)
            yield from (((name, number), values) for name, values in vertices.outputs.items())


def stored(values: Array, format: str) -> Array:
    """What is left of float outputs in an attachment: 8-bit formats clamp, and keep 256 codes."""
    if format.endswith("8") and values.dtype.kind == "f":
        codes = 65535.0 if format.startswith("srgb") else 255.0  # sRGB has finer steps in the dark
        rounded: Array = np.rint(np.nan_to_num(np.clip(values, 0.0, 1.0)) * codes)
        return rounded
    return values.astype(np.float16) if format.endswith("16f") else values


def _inputs(
    random: np.random.Generator,
    variables: Mapping[str, tuple[tuple[int, ...], str]],
    turns: Array,
) -> dict[str, Array]:
    return {
        name: _spread(random, (SAMPLES, *shape), turns, kind)
        for name, (shape, kind) in variables.items()
    }


def _like(random: np.random.Generator, value: Array, turns: Array, kind: str) -> Array:
    """A uniform's value changed: often by a factor, sometimes altogether."""
    if value.dtype.kind in "iu":
        return random.integers(0, 2 if kind == "bool" else 8, value.shape).astype(value.dtype)
    if random.random() < 0.5:
        return (value * random.uniform(0.4, 2.5, value.shape)).astype(value.dtype)
    return _spread(random, value.shape, turns, kind).astype(value.dtype)


def _spread(random: np.random.Generator, shape: tuple[int, ...], turns: Array, kind: str) -> Array:
    if kind[0] in "iub" and not kind.startswith("bool"):
        return random.integers(0, 8, shape).astype(np.uint32 if kind[0] == "u" else np.int32)
    near = random.uniform(-2.0, 2.0, shape)
    sizes = 10.0 ** random.uniform(-4.0, 4.0, shape) * random.choice([-1.0, 1.0], shape)
    choice = random.random(shape)
    numbers = np.where(choice < 0.45, near, np.where(choice < 0.8, sizes, 0.0))
    return np.where(choice < 0.8, numbers, random.choice(turns, shape)).astype(np.float32)


def _turning_points(text: str) -> Array:
    """0, ±1, and each constant of the shader with its float32 neighbours."""
    values: list[np.float32 | float] = [0.0, 1.0, -1.0, 0.5]
    for word in dict.fromkeys(_NUMBER.findall(text)):
        number = np.float32(word)
        values += [number, -number, np.nextafter(number, np.float32(0)), number * np.float32(1.005)]
    return np.array(values, np.float32)
