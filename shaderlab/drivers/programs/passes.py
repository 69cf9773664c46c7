"""Rules between passes: which may go on in an earlier one's target, and which textures are still
what they were drawn as."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from shaderlab.errors import CaseError, UnsupportedError, nearest
from shaderlab.model.case import Scene
from shaderlab.model.scene import Draw, Pass
from shaderlab.model.textures import outputs_read


def check_continues(
    scene: Scene,
    description: Pass,
    colors: Mapping[str, str],
    earlier: Mapping[str, Mapping[str, str]],
) -> None:
    """Check that a pass can draw on in the target of the one that it names.

    Args:
        scene: whose passes these are.
        description: a pass with `onto`.
        colors: its colour attachments, format by output name.
        earlier: those of the passes before it, by pass.

    Raises:
        CaseError: there is no such earlier pass, or its target is another one.
    """
    before = description.onto
    if before not in earlier:
        raise CaseError(
            f"pass {description.name!r} goes on in {before!r}, which is no earlier pass",
            remedy=nearest(before, earlier),
        )
    same = scene.find_pass(before).target == description.target
    if not same or earlier[before] != colors:
        raise CaseError(
            f"pass {description.name!r} goes on in {before!r}, but its target differs",
            remedy="give both the same Target and shaders with the same outputs",
        )


def check_reads(scene: Scene, description: Pass, draw: Draw, earlier: Iterable[str]) -> None:
    """Check that all that a draw reads is still there; `earlier` are the passes before its own.

    Raises:
        CaseError: a texture has been drawn over since, is the target that is being drawn into, or
            is a renderbuffer.
        UnsupportedError: a texture is a buffer of a dispatch.
    """
    images = {p.name: p.draws[0].images for p in scene.passes if p.computes}
    owners = {name: _owner(scene, name) for name in earlier}
    for name, source in draw.textures.items():
        for output in outputs_read(source):
            read = output.pass_name
            if output.name not in images.get(read, (output.name,)):
                raise UnsupportedError(
                    f"sampling a buffer: {name!r} is a texture, and {output.path} is left in a "
                    "storage buffer",
                    remedy="read it in another compute pass: buffers={…: Output(…)}",
                )
            if read not in owners:
                continue  # what is read does not exist: reported where it is looked for
            drawn = scene.find_pass(read).target
            if output.name == "depth" and drawn.depth and drawn.depth_storage == "renderbuffer":
                raise CaseError(
                    f"{name!r} is the depth of pass {read!r}, which keeps it in a renderbuffer: "
                    "that is drawn with, and no sampler reads it",
                    remedy=f"give {read!r} a Target(depth_storage='texture')",
                )
            if owners[read] == _owner(scene, description.name):
                raise CaseError(
                    f"pass {description.name!r} reads {name!r} from the target it draws into",
                    remedy="draw into another target, and exchange the two",
                )
            last = [other for other, owner in owners.items() if owner == owners[read]][-1]
            if last != read:
                raise CaseError(
                    f"pass {read!r} was drawn over", remedy=f"read the output of {last!r}"
                )


def _owner(scene: Scene, name: str) -> str:
    """The pass whose target a pass draws into: its own, or that of the one it goes on from."""
    before = scene.find_pass(name).onto
    return _owner(scene, before) if before else name
