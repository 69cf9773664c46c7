"""What the expectations of scenes read of what is drawn, and what none of them reads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from shaderlab.model.case import Scene
from shaderlab.model.expectation import Programs, Read
from shaderlab.model.scene import Pass, Pixel

Named = tuple[str, str]
"""A pass and an output of one of its stages."""


def judged_outputs(scenes: Iterable[Scene]) -> dict[Named, frozenset[Pixel] | None]:
    """What any expectation of these scenes reads, directly or through a later pass: of each output
    some pixels, or all of it (None)."""
    found: dict[Named, frozenset[Pixel] | None] = {}
    for scene in scenes:
        for read in all_reads(scene):
            name = (read.pass_name, read.output)
            known = found.get(name, frozenset())
            found[name] = None if read.pixel is None or known is None else known | {read.pixel}
    return found


def unread_outputs(scene: Scene, programs: Programs) -> tuple[str, ...]:
    """The outputs of fragment and compute shaders that no expectation of the scene reads, nor any
    pass that an expectation reads: "pass.output", or "pass.output of draw 0" where other draws'
    are read.

    An output that is read at single pixels alone is among them.
    """
    read = {(r.pass_name, r.draw, r.output) for r in all_reads(scene) if r.pixel is None}
    found: list[str] = []
    for description in scene.passes:
        draws = [list(draw.outputs) for draw in programs[description.name]]
        if description.target.colors is not None:  # what has no attachment is stored nowhere
            draws = [[n for n in names if n in description.target.colors] for names in draws]
        for output in dict.fromkeys(name for draw in draws for name in draw):
            if (description.name, None, output) in read:
                continue
            writing = [index for index, names in enumerate(draws) if output in names]
            missing = [i for i in writing if (description.name, i, output) not in read]
            whole = f"{description.name}.{output}"
            if missing == writing:
                found.append(whole)
            else:
                found += [f"{whole} of draw {index}" for index in missing]
    return tuple(found)


def all_reads(scene: Scene) -> Iterator[Read]:
    """What expectations read, and what the passes that they read got from earlier ones."""
    used: dict[str, set[str]] = {}
    direct = [read for expectation in scene.expect for read in expectation.reads(scene)]
    for read in direct:
        used.setdefault(read.pass_name, set()).add(read.output)
        yield read
    for description in reversed(scene.passes):
        outputs = used.get(description.name)
        if outputs is not None:
            for read in _reads_of_pass(description, outputs):
                used.setdefault(read.pass_name, set()).add(read.output)
                yield read


def _reads_of_pass(description: Pass, outputs: Iterable[str]) -> Iterator[Read]:
    """What a pass reads of earlier ones: as textures, in buffers, and where it goes on drawing in
    `outputs`."""
    for draw in description.draws:
        for source in draw.outputs_read():
            yield Read(source.pass_name, source.name)
    if description.onto:
        for output in sorted(outputs):
            yield Read(description.onto, output)
