"""Which attachments a scene asks for by name. Colours are read back always, depth and stencil only
where something samples or judges them."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

from shaderlab.model.case import Scene
from shaderlab.model.expect import Exact, output_of
from shaderlab.model.measure import Measure
from shaderlab.model.textures import Output, outputs_read


def names_asked_for(scene: Scene) -> dict[str, set[str]]:
    """The outputs that textures, expectations and the picture name, by pass.

    A name without a pass is the last pass's.
    """
    found: dict[str, set[str]] = {}
    for output in _asked(scene):
        split = output_of(output) if isinstance(output, str) else output
        name = split if isinstance(split, str) else split.name
        where = scene.passes[-1].name if isinstance(split, str) else split.pass_name
        found.setdefault(where, set()).add(name)
    return found


def _asked(scene: Scene) -> Iterator[str | Output]:
    yield scene.case.picture
    for description in scene.passes:
        for draw in description.draws:
            for source in draw.textures.values():
                yield from outputs_read(source)
    for expectation in scene.expect:
        yield getattr(expectation, "output", "")
        if isinstance(expectation, Exact) and isinstance(expectation.equals, Output):
            yield expectation.equals
        if isinstance(expectation, Measure):
            for row in expectation.readings:
                yield from row.reads.values()
            names = set(inspect.signature(expectation.statistic).parameters)
            for description in scene.passes:
                for name in ("depth", "stencil"):
                    # A parameter is a name without its dots.
                    if re.sub(r"\W+", "_", f"{description.name}.{name}") in names:
                        yield Output(description.name, name)
