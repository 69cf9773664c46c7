"""What a scene keeps on a device, the same for every graphics API: the attachments that a pass
draws into, the textures that samplers read, linked programs."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Self, TypeVar

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image, Texels
from shaderlab.model.scene import Target
from shaderlab.model.textures import CompressedTexture, Output, TextureSource

from .programs.textures import DEPTH, check_sampler, find_image, texture_kind

COVERING = """#version 330 core
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
"""A vertex stage of one triangle over the whole target."""

UNREADABLE = "Target(samples=0): the depth of several samples a pixel has no one value"


def multisampled_error(name: str) -> UnsupportedError:
    """Return the error for depth or stencil of a multisampled target, which can't be read."""
    return UnsupportedError(f"reading the {name} of a multisampled target", remedy=UNREADABLE)


class Attachments(ABC):
    """The attachments of one pass at one size, (width, height) in pixels, on a device. As a context
    manager they are cleared first and released in the end. Making them raises UnsupportedError
    where the device can't.

    `colors` are formats by output name, in the order of the outputs' locations; `depth` is the
    format of depth and stencil, "" for none; `samples` is how many samples a pixel has.
    """

    samples: int

    def __init__(
        self, device: Any, target: Target, colors: Mapping[str, str], size: tuple[int, int]
    ) -> None:
        width, height = size
        if max(size) > (most := int(device.info["max_texture_size"])):
            raise UnsupportedError(f"a target of {width} × {height}: this device ends at {most}")
        self._device = device
        self.size = size
        self.colors = dict(colors)
        self.depth = target.depth or ""
        self._target = target
        self._make()

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
    def _make(self) -> None:
        """Make them on the device."""

    @abstractmethod
    def clear(self) -> None:
        """Set every attachment to its clear value, unmasked."""

    @abstractmethod
    def resolve(self) -> None:
        """Average the samples into what is read, if there are several a pixel."""

    @abstractmethod
    def sample_positions(self) -> Array:
        """Read where the device takes a pixel's samples: (samples, 2), from its lower left corner.
        Raises UnsupportedError: it does not say."""

    @abstractmethod
    def read(self, name: str) -> Image:
        """Read one attachment in its own components and type, row 0 at the bottom.

        "depth" is read as floats, whatever its format, "stencil" as unsigned bytes. Raises
        UnsupportedError: depth or stencil of a multisampled target."""

    @abstractmethod
    def release(self) -> None:
        """Release all memory on the device; the target is of no use afterwards."""


@dataclass(frozen=True)
class DeviceTexels:
    """A texture on a device: the `handle` of it, or of a view, as the API has it, and what its
    first level and those below it hold. Its source is kept, so that no other one gets its id."""

    source: TextureSource
    handle: Any
    format: str
    values: Array
    smaller: tuple[Array, ...] = ()


TargetKind = TypeVar("TargetKind", bound=Attachments)


@dataclass(eq=False)
class SceneTextures(ABC, Generic[TargetKind]):
    """The textures of one scene on a device, each made once, attachments of earlier passes among
    them. Files' paths are relative to `folder`; `images` are what passes have drawn so far."""

    folder: Path
    images: Mapping[tuple[str, str], Image]
    targets: Mapping[str, TargetKind]
    _uploaded: dict[int, DeviceTexels] = field(default_factory=dict, init=False)
    _attached: dict[tuple[object, ...], DeviceTexels] = field(default_factory=dict, init=False)
    # A sampler keeps filters and wraps apart from the images: one attachment can have several.
    _samplers: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False)

    def texels(self, program: str, variable: Variable, source: TextureSource) -> Texels:
        """Return what a sampler will read, exactly. Raises CaseError: the texture can't be made, or
        is none that such a sampler reads; AssetError: an image file can't be read;
        UnsupportedError: the device has no such texture."""
        kind = self.kind(source, variable)
        if isinstance(source, Output):
            format = find_image(source, self.images).format
        else:
            format = "rgba8" if isinstance(source, CompressedTexture) else source.format  # decoded
        check_sampler(program, variable, source, kind, format)
        found = self.find(source, kind)
        return Texels(
            found.values,
            source.filter,
            source.wrap,
            source.border,
            kind=kind,
            format=found.format,
            smaller=found.smaller,
            compare=source.compare,
            lod=source.lod,
            seamless=getattr(source, "seamless", True),
        )

    def kind(self, source: TextureSource, variable: Variable) -> str:
        """Return what a texture is to the sampler that reads it: "2D", "3D", "cube", "2DMS", …"""
        samples = layers = 0
        if isinstance(source, Output) and source.pass_name in self.targets:
            drawn = self.targets[source.pass_name].samples
            samples = drawn if drawn > 1 else 0
        elif isinstance(source, Output):
            layers = find_image(source, self.images).layers
        return texture_kind(source, variable.type, samples, layers)

    def find(self, source: TextureSource, kind: str) -> DeviceTexels:
        """Return the texture on the device; it is made now if it is not there."""
        if isinstance(source, Output) and source.pass_name in self.targets:
            key = (source.pass_name, source.name, kind, source.mipmaps)
            if key not in self._attached:
                self._attached[key] = self.attachment(source, kind)
            return self._attached[key]
        if id(source) not in self._uploaded:
            self._uploaded[id(source)] = self.upload(source)
        return self._uploaded[id(source)]

    def sampler(self, source: TextureSource) -> Any:
        """Return the sampler of a texture's filters and wraps; it is made now if there is none."""
        seamless = getattr(source, "seamless", True)
        key = (source.filter, source.wrap, source.border, source.compare, source.lod, seamless)
        if key not in self._samplers:
            self._samplers[key] = self.new_sampler(source)
        return self._samplers[key]

    @abstractmethod
    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        """Return what an earlier pass drew, as a texture."""

    @abstractmethod
    def upload(self, source: TextureSource) -> DeviceTexels:
        """Make a texture that is no attachment; an output is the image of a dispatch."""

    @abstractmethod
    def new_sampler(self, source: TextureSource) -> Any:
        """Make a sampler of a texture's filters and wraps."""


CAPACITY = 16


Program = TypeVar("Program", bound=Any)


class ProgramCache(Generic[Program]):
    """Programs by what they are made of, so that equal ones are made once.

    The `CAPACITY` most recently used ones are kept: a software driver's machine code takes a
    megabyte. A program is used before the next one is asked for.
    """

    def __init__(self, device: Any) -> None:
        self.device = device
        self._made: dict[Hashable, Program] = {}

    def get(self, key: Hashable, make: Callable[[], Program]) -> Program:
        """Return the program of this key; it is made now if there is none."""
        program = self._made.pop(key, None) or make()
        self._made[key] = program
        if len(self._made) > CAPACITY:
            self.drop(self._made.pop(next(iter(self._made))))
        return program

    def release(self) -> None:
        while self._made:
            self.drop(self._made.popitem()[1])

    def drop(self, program: Program) -> None:
        """Release a program that is kept no longer."""
        program.release()
