"""Tells mutants that change nothing from those that nobody saw: draws them with other inputs.

These go far beyond a case's own: textures (every channel random, beyond 0…1 where the format
allows), clear colours, sizes, ramps and uniforms of every draw, buffers of every dispatch, and
numbers for a program's stages: around zero, of every size, and those at which formulas turn: 0, ±1
and each constant of the shader.
"""

import functools
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from shaderlab.drivers.programs.bind import find_declared_uniforms
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.drivers.programs.stages import array_elements
from shaderlab.drivers.programs.textures import format_of, shape_of
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.base import Named
from shaderlab.engine.pictures import with_read_passes
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import UnsupportedError
from shaderlab.model import textures
from shaderlab.model.case import Scene
from shaderlab.model.frame import Array, PassDraw, Texels, differ
from shaderlab.model.scene import UNIT_SQUARE, Ramp, Target, UniformBuffer
from shaderlab.mutation.mutants import Trial, part_of

_ROUNDS = 6
_MOST_KEPT = 48  # rounds, each with the pictures of a scene
_SAMPLES = 1024
_SIZES = ((48, 80), (96, 40), (64, 64), (40, 96), (80, 48), (57, 71))
_NUMBER = re.compile(r"(?<![\w.])\d+\.\d*(?:e[-+]?\d+)?", re.IGNORECASE)

_Values = Mapping[tuple[Named, str], Array]
"""What was "drawn" and what the "fragment" and "vertex" stage made of numbers, by output."""


@dataclass(frozen=True)
class InputRound:
    """Other inputs of a scene: what is replaced in each draw, and each pass's target; and, if a
    program is to be run on numbers, a draw of it and its stages' inputs."""

    draws: Mapping[PassDraw, Mapping[str, Any]]
    targets: Mapping[str, Target]
    probed: PassDraw | None
    fragments: Mapping[str, Array]
    vertices: Mapping[str, Array]

    def apply(self, scene: Scene, programs: Programs) -> tuple[Scene, Programs]:
        """Return a scene, mutated or not, and its programs with these inputs instead of its own."""
        prepared = {
            name: tuple(
                replace(draw, draw=replace(draw.draw, **self.draws[name, index]))
                for index, draw in enumerate(draws)
            )
            for name, draws in programs.items()
        }
        passes = tuple(
            replace(p, target=self.targets[p.name], draws=tuple(d.draw for d in prepared[p.name]))
            for p in scene.passes
        )
        return replace(scene, passes=passes, expect=()), prepared


_Known = tuple[InputRound, set[str], _Values]
"""Other inputs, the passes that are drawn with them, and what the case's own shaders make of it."""


class WiderInputs:
    """Other inputs for the scenes of a case, with what its own shaders make of them."""

    def __init__(self, lab: SceneRunner, originals: Mapping[str, Evaluation]) -> None:
        self._lab, self._originals = lab, originals
        self._round = functools.lru_cache(maxsize=_MOST_KEPT)(self._make_round)

    def find_difference(
        self, trials: list[Trial], prepare: Callable[[Trial, Scene], Programs]
    ) -> tuple[Named | None, int]:
        """Return an output that a mutant changes, if one is found, and how many inputs were tried.

        `prepare` compiles the draws of a part of a scene, with the mutant's in them.
        """
        tried = 0
        for number in range(_ROUNDS if trials else 0):
            trial = trials[number % len(trials)]
            effect, variant = trial.effect, trial.scene.variant
            known = self._round(variant, effect.passes, effect.program, number)
            if known is None:
                continue
            inputs, names, expected = known
            part = part_of(effect.scene, names)
            scene, programs = inputs.apply(part, prepare(trial, part))
            run = self._lab.evaluation(scene, programs, like=self._originals[variant])
            with run as mutant:  # what goes wrong is the mutant's: the part ran unmutated
                got = _outputs(mutant, inputs, effect.passes)
            for (output, kind), values in expected.items():
                if (output, kind) not in got or differ(values, got[output, kind]):
                    return output, tried
            # Pixels, and runs of a stage.
            counts = {(name, kind): v[..., 0].size for ((name, _), kind), v in expected.items()}
            tried += sum(counts.values())
        return None, tried

    def _make_round(
        self, variant: str, passes: frozenset[str], program: tuple[str, ...], number: int
    ) -> _Known | None:
        """Make round `number` of other inputs for what a mutant changes; the first keeps uniforms
        and ramps. None where it can't be drawn with them.

        They follow from the unmutated scene, so that every mutant of `program` gets the same ones.
        """
        original = self._originals[variant]
        needed = with_read_passes(original.scene, passes)
        maker = _InputMaker(original, number)
        draws = {
            (p.name, index): draw
            for p in original.scene.passes
            if p.name in needed
            for index, draw in enumerate(original.programs[p.name])
        }
        changes = {key: maker.replace_fields(key, draw) for key, draw in draws.items()}
        targets = maker.targets()
        probed = next((key for key, draw in draws.items() if draw.draw.shaders == program), None)
        if probed is not None and draws[probed].draw.compute:
            probed = None  # its invocations belong together
        stages = maker.stages(draws[probed]) if probed else ({}, {})
        inputs = InputRound(changes, targets, probed, *stages)
        part = part_of(original.scene, needed)
        scene, programs = inputs.apply(part, {n: original.programs[n] for n in needed})
        names = with_read_passes(scene, passes)
        programs = {name: programs[name] for name in names}
        try:
            run = self._lab.evaluation(part_of(scene, names), programs, like=original)
            with run as unmutated:
                return inputs, names, _outputs(unmutated, inputs, passes)
        except Exception:  # whatever goes wrong without the mutant says nothing of it
            return None


def _outputs(evaluation: Evaluation, inputs: InputRound, passes: Collection[str]) -> _Values:
    """What passes draw, and what the round's program makes of its numbers, as the target has it."""
    session, drawn, key = evaluation.session, evaluation.drawn, inputs.probed
    found = {(o, "drawn"): image.values for o, image in drawn.images.items() if o[0] in passes}
    if key is None:
        return found
    bindings = drawn.bindings[key]
    with suppress(UnsupportedError):  # stages that can't be run on given inputs
        made = session.probe(key, "fragment", [bindings], inputs.fragments)[0].outputs
        for name, values in made.items():
            image = drawn.images.get((key[0], name))
            kept = values if image is None else _stored(values, image.format)
            found[(key[0], name), "fragment"] = kept
        if inputs.vertices:
            made = session.probe(key, "vertex", [bindings], inputs.vertices)[0].outputs
            found |= {((key[0], name), "vertex"): values for name, values in made.items()}
    return found


def _stored(values: Array, format: str) -> Array:
    """What is left of float outputs in an attachment: 8-bit formats clamp, and keep 256 codes."""
    if format.endswith("8") and values.dtype.kind == "f":
        codes = 65535.0 if format.startswith("srgb") else 255.0  # sRGB has finer steps in the dark
        rounded: Array = np.rint(np.nan_to_num(np.clip(values, 0.0, 1.0)) * codes)
        return rounded
    return values.astype(np.float16) if format.endswith("16f") else values


class _InputMaker:
    """Makes the other inputs of one round. What draws share, they go on sharing."""

    def __init__(self, original: Evaluation, number: int) -> None:
        self._original = original
        self._keeps = number == 0
        self._size = _SIZES[number % len(_SIZES)]
        self._random = np.random.default_rng(number)
        self._shared: dict[int, Any] = {}
        self._turns = np.zeros(1, np.float32)

    def targets(self) -> dict[str, Target]:
        made: dict[str, Target] = {}
        for p in self._original.scene.passes:
            if p.computes:
                made[p.name] = p.target
                continue
            width, height = self._size
            if any(d.state.in_pixels for d in p.draws) and p.target.size:
                width, height = p.target.size[0] + width // 8, p.target.size[1] + height // 8
            clear = tuple(self._random.uniform(0.0, 1.0, 4).tolist())
            images = self._original.drawn.images.items()
            if any(o == p.name and i.values.dtype.kind in "iu" for (o, _), i in images):
                clear = p.target.clear
            made[p.name] = made.get(p.onto) or replace(p.target, size=(width, height), clear=clear)
        return made

    def replace_fields(self, key: PassDraw, prepared: PreparedDraw) -> Mapping[str, Any]:
        draw, bindings = prepared.draw, self._original.drawn.bindings[key]
        texels = bindings.textures
        self._turns = _turning_points("".join(prepared.texts.values()))
        own = {n: self._once(s, self._texture, texels[n]) for n, s in draw.textures.items()}
        changes: dict[str, Any] = {"textures": own}
        if not self._keeps:
            kinds = {n: v.type for n, v in find_declared_uniforms(prepared.interface).items()}
            changes["uniforms"] = {
                n: self._number(v, kinds.get(n, "float")) for n, v in draw.uniforms.items()
            }
            words = {"i": "int", "u": "uint"}
            held = {n: bindings.buffers[n] for n in draw.buffers}
            changes["buffers"] = {
                n: v
                if isinstance(v, textures.Output)
                else self._spread(held[n].shape, words.get(held[n].dtype.kind, "float"))
                for n, v in draw.buffers.items()
            }
            changes["images"] = {
                n: v if isinstance(v, textures.Output) else self._image(bindings.images[n])
                for n, v in draw.images.items()
            }
            changes["blocks"] = {n: self._once(b, self._buffer) for n, b in draw.blocks.items()}
            if draw.domain is not None and draw.domain != UNIT_SQUARE:
                changes["domain"] = {n: self._ramp(r) for n, r in draw.domain.items()}
        return changes

    def stages(self, prepared: PreparedDraw) -> tuple[dict[str, Array], dict[str, Array]]:
        """Random inputs of the fragment stage, and of the vertex stage where it can be run."""
        draw, interface = prepared.draw, prepared.interface
        varyings = {
            v.name: (shape_of(v.type), v.type) for v in array_elements(interface.varyings.values())
        }
        attributes = {}
        if draw.mesh is not None and not (draw.geometry or draw.tess_evaluation):
            types = {n: v.type for n, v in interface.attributes.items()}
            attributes = {n: (a.shape[1:], types[n]) for n, a in draw.mesh.inputs.items()}
        return self._inputs(varyings), self._inputs(attributes)

    def _inputs(self, variables: Mapping[str, tuple[tuple[int, ...], str]]) -> dict[str, Array]:
        return {n: self._spread((_SAMPLES, *s), kind) for n, (s, kind) in variables.items()}

    def _once(self, thing: Any, make: Any, *more: Any) -> Any:
        """What stands for a thing that several draws may share; kept alive with its identity."""
        if id(thing) not in self._shared:
            self._shared[id(thing)] = (thing, make(thing, *more))
        return self._shared[id(thing)][1]

    def _texture(self, source: textures.TextureSource, texels: Texels) -> textures.TextureSource:
        shape, format = texels.values.shape, texels.format
        if isinstance(source, textures.CubeTexture):
            return replace(source, faces=[self._texels(shape[1:], format) for _ in range(6)])
        if isinstance(source, textures.TextureArray):
            return replace(source, layers=[self._texels(shape[1:], format) for _ in source.layers])
        if isinstance(source, textures.Texture):
            levels: Any = source.mipmaps
            if not isinstance(levels, bool):
                levels = [self._texels(level.shape, format) for level in texels.smaller]
            return replace(source, image=self._texels(shape, format), mipmaps=levels)
        if isinstance(source, textures.CompressedTexture):
            format = "rgba8"
        if texels.kind != "2D" or format not in textures.TEXTURE_FORMATS:
            return source  # samples, or a stencil: only drawing makes these
        sampling = {f.name: getattr(source, f.name) for f in fields(textures.Sampling)}
        image = self._texels((*shape[:2], format_of(format).components), format)
        return textures.Texture(
            image=image, format=format, mipmaps="mipmap" in source.filter[0], **sampling
        )

    def _texels(self, shape: Sequence[int], format: str) -> Array:
        known = format_of(format)
        size = (*shape[:2], known.components)
        if known.integer:
            return self._random.integers(0, 8, size).astype(known.numpy)
        if format.endswith("8") or format.startswith("depth"):
            return self._random.random(size, np.float32)
        return self._spread(size, "float")

    def _image(self, held: Texels) -> Array:
        if held.values.ndim != 4:
            return self._texels(held.values.shape, held.format)
        return np.stack([self._texels(layer.shape, held.format) for layer in held.values])

    def _buffer(self, buffer: UniformBuffer) -> UniformBuffer:
        return UniformBuffer(values={n: self._number(v, "") for n, v in buffer.values.items()})

    def _ramp(self, ramp: Ramp) -> Ramp:
        numbers = (ramp.origin, ramp.dx, ramp.dy)
        return Ramp(*(self._number(number, "float").tolist() for number in numbers))

    def _number(self, before: Any, kind: str) -> Array:
        """Another value: often the same one, or it times a factor, sometimes another altogether."""
        value = np.asarray(before)
        whole = kind[:1] in ("i", "u", "b") if kind else value.dtype.kind in "iub"
        choice = self._random.random()
        if choice < 0.25:
            return value
        if whole:
            both = kind.startswith("b") or value.dtype.kind == "b"
            return self._random.integers(0, 2 if both else 8, value.shape)
        if choice < 0.65:
            return (value * self._random.uniform(0.4, 2.5, value.shape)).astype(np.float32)
        return self._spread(value.shape, "float")

    def _spread(self, shape: Sequence[int], kind: str) -> Array:
        random, size = self._random, tuple(shape)
        if kind[0] in "iub" and not kind.startswith("bool"):
            return random.integers(0, 8, size).astype(np.uint32 if kind[0] == "u" else np.int32)
        near = random.uniform(-2.0, 2.0, size)
        sizes = 10.0 ** random.uniform(-4.0, 4.0, size) * random.choice([-1.0, 1.0], size)
        choice = random.random(size)
        numbers = np.where(choice < 0.45, near, np.where(choice < 0.8, sizes, 0.0))
        return np.where(choice < 0.8, numbers, random.choice(self._turns, size)).astype(np.float32)


def _turning_points(text: str) -> Array:
    """0, ±1, and each constant of the shader with its float32 neighbours."""
    values: list[np.float32 | float] = [0.0, 1.0, -1.0, 0.5]
    for word in dict.fromkeys(_NUMBER.findall(text)):
        number = np.float32(word)
        values += [number, -number, np.nextafter(number, np.float32(0)), number * np.float32(1.005)]
    return np.array(values, np.float32)
