"""Passes that go on in an earlier one's target, and textures that are no longer what they were."""

from __future__ import annotations

from collections.abc import Mapping

from shaderlab.errors import CaseError, nearest
from shaderlab.gl.target import RenderTarget
from shaderlab.model import Draw, Pass, Scene, outputs_read

Targets = Mapping[str, RenderTarget]
"""The targets of the passes so far, in the order in which they ran."""


def taken_over(
    scene: Scene, description: Pass, colors: Mapping[str, str], targets: Targets
) -> RenderTarget:
    """The target of the pass that `description` goes on in, as that one left it.

    Raises:
        CaseError: there is no such earlier pass, or its target is another one.
    """
    before = description.onto
    if before not in targets:
        raise CaseError(
            f"pass {description.name!r} goes on in {before!r}, which is no earlier pass",
            remedy=nearest(before, targets),
        )
    target = targets[before]
    same = scene.find_pass(before).target == description.target
    if not same or target.colors != dict(colors):
        raise CaseError(
            f"pass {description.name!r} goes on in {before!r}, but its target differs",
            remedy="give both the same Target and shaders with the same outputs",
        )
    return target


def refuse_stale(description: Pass, draw: Draw, targets: Targets) -> None:
    """Nothing, if all that a draw reads is still there.

    Raises:
        CaseError: a texture has been drawn over since, or is the target that is being drawn into.
    """
    for name, source in draw.textures.items():
        for read in (output.pass_name for output in outputs_read(source)):
            if read not in targets:
                continue  # what is read does not exist: reported where it is looked for
            if targets[read] is targets[description.name]:
                raise CaseError(
                    f"pass {description.name!r} reads {name!r} from the target it draws into",
                    remedy="draw into another target, and exchange the two",
                )
            last = [other for other, target in targets.items() if target is targets[read]][-1]
            if last != read:
                raise CaseError(
                    f"pass {read!r} was drawn over", remedy=f"read the output of {last!r}"
                )
