"""What a scene's samplers read, the same for every graphics API: which texture, in which format,
and what its levels hold."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from shaderlab.compiler.reflection import Variable
from shaderlab.model.frame import Array, Image, Texels
from shaderlab.model.textures import CompressedTexture, Output, TextureSource

from .programs.textures import check_sampler, find_image, kind_of


class Sampled(Protocol):
    """A target, whose attachments may be read as textures."""

    @property
    def samples(self) -> int: ...


@dataclass(frozen=True)
class DeviceTexels:
    """A texture on a device, and what its levels hold.

    Attributes:
        source: what it was made from; kept with it, so that no other one gets its id.
        handle: the texture, or a view of it, as the API has it.
        format: as `shaderlab.Texture` has it.
        values: the first level.
        smaller: the levels below it.
    """

    source: TextureSource
    handle: Any
    format: str
    values: Array
    smaller: tuple[Array, ...] = ()


Kind = TypeVar("Kind", bound=Sampled)


@dataclass(eq=False)
class SceneTextures(ABC, Generic[Kind]):
    """The textures of one scene on a device, each made once, attachments of earlier passes among
    them.

    Args:
        folder: what the paths of their files are relative to.
        images: what passes have drawn so far.
        targets: the passes' targets.
    """

    folder: Path
    images: Mapping[tuple[str, str], Image]
    targets: Mapping[str, Kind]
    _uploaded: dict[int, DeviceTexels] = field(default_factory=dict, init=False)

    def texels(self, program: str, variable: Variable, source: TextureSource) -> Texels:
        """What a sampler will read, exactly.

        Raises:
            CaseError: the texture can't be made, or is none that such a sampler reads.
            AssetError: an image file can't be read.
            UnsupportedError: the device has no such texture.
        """
        kind = self.kind(source, variable)
        check_sampler(program, variable, source, kind, self._format(source))
        found = self.find(source, kind)
        return Texels(
            found.values, source.filter, source.wrap, source.border,
            kind=kind, format=found.format, smaller=found.smaller, compare=source.compare,
            lod=source.lod, seamless=getattr(source, "seamless", True),
        )  # fmt: skip

    def kind(self, source: TextureSource, variable: Variable) -> str:
        """What a texture is to the sampler that reads it: "2D", "3D", "cube", "2DMS", …"""
        samples = layers = 0
        if isinstance(source, Output) and source.pass_name in self.targets:
            drawn = self.targets[source.pass_name].samples
            samples = drawn if drawn > 1 else 0
        elif isinstance(source, Output):
            layers = find_image(source, self.images).layers
        return kind_of(source, variable.type, samples, layers)

    def find(self, source: TextureSource, kind: str) -> DeviceTexels:
        """The texture on the device; it is made now if it is not there."""
        if isinstance(source, Output) and source.pass_name in self.targets:
            return self.attachment(source, kind)
        if id(source) not in self._uploaded:
            self._uploaded[id(source)] = self.upload(source)
        return self._uploaded[id(source)]

    @abstractmethod
    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        """What an earlier pass drew, as a texture."""

    @abstractmethod
    def upload(self, source: TextureSource) -> DeviceTexels:
        """Make a texture that is no attachment; an output is the image of a dispatch."""

    def _format(self, source: TextureSource) -> str:
        if isinstance(source, CompressedTexture):
            return "rgba8"  # what its texels are once they are decoded
        if isinstance(source, Output):
            return find_image(source, self.images).format
        return source.format
