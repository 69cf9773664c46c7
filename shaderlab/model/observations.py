"""What one of several drivers does at some pixels, as plain data: what disagreements are
attributed by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

Pixel = tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class Look:
    """Pixels (column, row) of an output, "pass.output", to look at."""

    output: str
    pixels: tuple[Pixel, ...]


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that a driver does and its own inputs do not allow.

    `kind` is "fragment stage", "vertex stage", "coverage", "interpolation" or "clear"; `text` is a
    sentence; `file` and `line` are the shader's, where one is to blame ("" and 0: none).
    """

    kind: str
    text: str
    pixel: Pixel | None = None
    file: str = ""
    line: int = 0


@dataclass(frozen=True, kw_only=True)
class Observation:
    """An output on one driver, at the pixels that were asked for.

    Attributes:
        output: "pass.output".
        seen: the draw of the pass that is seen at each pixel, −1 for none.
        inputs: what its fragment shader got there, by name.
        at_edge: whether an edge of a triangle passes so close to the pixel's centre that it may
            be covered or not.
        vertices: a digest of what a draw hands to rasterisation, by the draw's number.
        reads: the outputs of earlier passes that the pass reads.
        samples_textures: whether the pass reads textures.
        after: what changes colours after the fragment stage, such as "blending"; "" for nothing.
        fault: the first that was found.
        refused: why something was not looked at.
    """

    output: str
    seen: tuple[int, ...] = ()
    inputs: tuple[Mapping[str, tuple[float, ...]], ...] = ()
    at_edge: tuple[bool, ...] = ()
    vertices: Mapping[str, str] = field(default_factory=dict)
    reads: tuple[str, ...] = ()
    samples_textures: bool = False
    after: str = ""
    fault: Fault | None = None
    refused: tuple[str, ...] = ()
