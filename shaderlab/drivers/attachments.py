"""What a pass draws into, the same for every graphics API."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Self

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.scene import Target

from .programs.formats import DEPTH


class Attachments(ABC):
    """The attachments of one pass at one size, on a device. As a context manager they are cleared
    first and released in the end.

    Args:
        target: sizes, clear values, depth format, samples.
        colors: format by output name, in the order of the outputs' locations.
        size: (width, height) in pixels.

    Attributes:
        depth: the format of depth and stencil, "" for none.

    Raises:
        UnsupportedError: the device can't make such a target; the message says which.
    """

    def __init__(self, target: Target, colors: Mapping[str, str], size: tuple[int, int]) -> None:
        self.size = size
        self.colors = dict(colors)
        self.depth = target.depth or ""
        self._target = target

    def __enter__(self) -> Self:
        self.clear()
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    @property
    def attached(self) -> tuple[str, ...]:
        """The attachments that can be read: colours by name, "depth" and "stencil"."""
        if not self.depth:
            return tuple(self.colors)
        return (*self.colors, "depth", *(("stencil",) if DEPTH[self.depth].stencil else ()))

    @abstractmethod
    def clear(self) -> None:
        """Set every attachment to its clear value, unmasked."""

    @abstractmethod
    def resolve(self) -> None:
        """Average the samples into what is read, if there are several a pixel."""

    @abstractmethod
    def sample_positions(self) -> Array:
        """Where the device takes a pixel's samples: (samples, 2), from its lower left corner.

        Raises:
            UnsupportedError: it does not say.
        """

    @abstractmethod
    def read(self, name: str) -> Image:
        """One attachment in its own components and type, row 0 at the bottom.

        "depth" is read as floats, whatever its format, "stencil" as unsigned bytes.

        Raises:
            UnsupportedError: depth or stencil of a multisampled target.
        """

    @abstractmethod
    def release(self) -> None:
        """Release all of its memory on the device; the target is of no use afterwards."""


COVERING = """#version 330 core
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
"""A vertex stage of one triangle over the whole target."""

UNREADABLE = "Target(samples=0): the depth of several samples a pixel has no one value"


def of_several_samples(name: str) -> UnsupportedError:
    """Why depth or stencil of a multisampled target is not read."""
    return UnsupportedError(f"reading the {name} of a multisampled target", remedy=UNREADABLE)
