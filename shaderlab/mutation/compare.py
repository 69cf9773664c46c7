"""Whether two trials gave the same: bit for bit, and which outputs an expectation reads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from shaderlab.checks import draw_key, outputs_read, split_output
from shaderlab.frame import Array, PassDraw
from shaderlab.model import Coverage, Exact, Measure, Output, Pixel, Scene
from shaderlab.model import outputs_read as outputs_of
from shaderlab.pipeline.trial import Trial

Named = tuple[str, str]
"""A pass and an output of one of its stages."""


Judged = Mapping[Named, "frozenset[Pixel] | None"]
"""What expectations read of each output: some pixels, or all of it (None)."""


def judged_outputs(scenes: Iterable[Scene]) -> dict[Named, frozenset[Pixel] | None]:
    """What any expectation of these scenes reads, directly or through a texture."""
    found: dict[Named, frozenset[Pixel] | None] = {}

    def add(output: Named, pixel: Pixel | None = None) -> None:
        known = found.get(output, frozenset())
        found[output] = None if pixel is None or known is None else known | {pixel}

    for scene in scenes:
        for expectation in scene.expect:
            if isinstance(expectation, Coverage):
                add((draw_key(scene, expectation.pass_name, expectation.draw)[0], "coverage"))
            if isinstance(expectation, Measure):
                for named in outputs_read(expectation, scene):
                    add(named)
            output = getattr(expectation, "output", None)
            if output is not None:
                at = getattr(expectation, "at", None)
                add(_named(output, scene), at if isinstance(at, Pixel) else None)
            if isinstance(expectation, Exact) and isinstance(expectation.equals, Output):
                add((expectation.equals.pass_name, expectation.equals.name))
        for description in reversed(scene.passes):
            if any(name == description.name for name, _ in found):
                for draw in description.draws:
                    for texture in draw.textures.values():
                        for source in outputs_of(texture):
                            add((source.pass_name, source.name))
    return found


def is_read(output: Named, mutant: Trial, original: Trial, judged: Judged) -> bool:
    """Whether a change of this output lies where an expectation looks."""
    pixels = judged.get(output, frozenset())
    if pixels is None or output not in mutant.images:
        return pixels is None
    one, other = mutant.images[output].values, original.images[output].values
    return any(differ(one[p.y, p.x], other[p.y, p.x]) for p in pixels)


def changed(mutant: Trial, original: Trial) -> set[Named]:
    """Outputs that differ in any bit: of the passes drawn, and of what was captured of both."""
    found = {
        key
        for key, image in mutant.images.items()
        if differ(image.values, original.images[key].values)
    }
    for key, samples in mutant.captured_vertices.items():
        found |= _changed_samples(key, samples.outputs, original.vertices(key).outputs)
    for key, fragments in mutant.captured_fragments.items():
        if differ(fragments.covered, original.fragments(key).covered):
            found.add((key[0], "coverage"))
    return found


def differ(one: Array, other: Array) -> bool:
    """Whether two arrays differ in any bit; one NaN is as good as another."""
    if one.shape != other.shape or one.dtype != other.dtype:
        return True
    if one.dtype.kind != "f":
        return not np.array_equal(one, other)
    same = (one == other) & (np.signbit(one) == np.signbit(other))
    return not bool((same | (np.isnan(one) & np.isnan(other))).all())


def _changed_samples(
    key: PassDraw, one: Mapping[str, Array], other: Mapping[str, Array]
) -> set[Named]:
    return {(key[0], name) for name in one if differ(one[name], other[name])}


def _named(output: str, scene: Scene) -> Named:
    pass_name, name = split_output(output, scene)
    return scene.find_pass(pass_name).name, name
