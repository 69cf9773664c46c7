"""Whether two evaluations gave the same, bit for bit, and which outputs expectations read."""

from __future__ import annotations

from collections.abc import Mapping

from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.expectations.needs import CapturedFragments, CapturedVertices
from shaderlab.engine.expectations.reads import Named
from shaderlab.model.frame import differ
from shaderlab.model.scene import Pixel

Judged = Mapping[Named, "frozenset[Pixel] | None"]
"""What expectations read of each output: some pixels, or all of it (None)."""


def is_read(output: Named, mutant: Evaluation, original: Evaluation, judged: Judged) -> bool:
    """Whether a change of this output lies where an expectation looks."""
    pixels = judged.get(output, frozenset())
    images = mutant.drawn.images
    if pixels is None or output not in images:
        return pixels is None
    one, other = images[output].values, original.drawn.images[output].values
    return any(differ(one[p.y, p.x], other[p.y, p.x]) for p in pixels)


def changed(mutant: Evaluation, original: Evaluation) -> set[Named]:
    """Outputs that differ in any bit: of the passes drawn, and of what was captured of both."""
    images = original.drawn.images
    found = {
        key
        for key, image in mutant.drawn.images.items()
        if differ(image.values, images[key].values)
    }
    for need, answer in mutant.answers.items():
        other = original.answers.get(need)
        if other is None:
            continue
        if isinstance(need, CapturedVertices):
            found |= {
                (need.key[0], name)
                for one, before in ((answer, other), (answer.entering, other.entering))
                if one is not None
                for name, values in one.outputs.items()
                if differ(values, before.outputs[name])
            }
        elif isinstance(need, CapturedFragments) and differ(answer.covered, other.covered):
            found.add((need.key[0], "coverage"))
    return found
