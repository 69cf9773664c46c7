"""Images on the device: made, filled, halved into mipmap levels, and read back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array
from shaderlab.model.textures import level_sizes

from .api import Structs, constant, lib
from .commands import GENERAL, Commands, recording
from .device import Device
from .formats import (
    DEPTH_ASPECT,
    STENCIL_ASPECT,
    aspects,
    packed,
    texel_bytes,
    unpacked,
    vulkan_format,
)
from .memory import Resources

Size = tuple[int, int]

_CUBE, _OTHER_FORMATS = 0x10, 0x8
_VIEWS = {"2D": 1, "2DMS": 1, "3D": 2, "Cube": 3, "2DArray": 5}


@dataclass(frozen=True)
class DeviceImage:
    """An image: `kind` as in `Texels.kind`, `word` its format, `size` (width, height) in texels."""

    handle: Any
    word: str
    kind: str
    size: Size
    layers: int = 1
    levels: int = 1
    samples: int = 1

    @property
    def sizes(self) -> list[Size]:
        """Each level's size."""
        return level_sizes(*self.size)[: self.levels]

    @property
    def depth(self) -> int:
        """Of an image in three dimensions how many layers it has, which are not Vulkan's."""
        return self.layers if self.kind == "3D" else 1

    @property
    def array_layers(self) -> int:
        """How many images there are in it, as Vulkan counts."""
        return self.layers // self.depth


def new_image(
    resources: Resources,
    word: str,
    size: Size,
    *uses: str,
    kind: str = "2D",
    layers: int = 1,
    levels: int = 1,
    samples: int = 1,
) -> DeviceImage:
    """An image without contents, for uses such as "color_attachment" and "sampled".

    Raises:
        UnsupportedError: it is too large for the device.
    """
    device = resources.device
    limit = device.limits.maxImageDimension2D
    if max(size) > limit:
        raise UnsupportedError(f"an image of {size[0]} × {size[1]}: this device ends at {limit}")
    most = device.limits.maxImageDimension3D
    if kind == "3D" and max(*size, layers) > most:
        raise UnsupportedError(f"a texture of {layers} layers: this device ends at {most} each way")
    usage = sum(constant(f"IMAGE_USAGE_{use.upper()}_BIT") for use in uses)
    flags = (_CUBE if kind == "Cube" else 0) | (_OTHER_FORMATS if word == "srgb8_alpha8" else 0)
    made = DeviceImage(None, word, kind, size, layers, levels, samples)
    handle = resources.create("Image", Structs()(
        "ImageCreateInfo", flags=flags, imageType=2 if kind == "3D" else 1,
        format=vulkan_format(word), extent=(*size, made.depth), mipLevels=levels,
        arrayLayers=made.array_layers, samples=samples, usage=usage,
    ))  # fmt: skip
    resources.bind_image_memory(handle)
    image = replace(made, handle=handle)
    with recording(device) as commands:
        commands.make_usable(handle, aspects(word))
    return image


def new_view(
    resources: Resources, image: DeviceImage, *, sampled: bool = False, as_word: str = ""
) -> Any:
    """A view of an image; one that is `sampled` has all its levels, and of depth and stencil the
    depth alone. `as_word` is another format of the same texels."""
    word = as_word or image.word
    aspect = aspects(word)
    if sampled and aspect & DEPTH_ASPECT:
        aspect = DEPTH_ASPECT
    return resources.create("ImageView", Structs()(
        "ImageViewCreateInfo", image=image.handle, viewType=_VIEWS[image.kind],
        format=vulkan_format(word),
        subresourceRange=(aspect, 0, image.levels if sampled else 1, 0, image.array_layers),
    ))  # fmt: skip


def fill(device: Device, image: DeviceImage, levels: Sequence[Array]) -> None:
    """Write the first levels of an image, each (layers, height, width, channels)."""
    write(device, image, [packed(image.word, values) for values in levels])


def write(device: Device, image: DeviceImage, levels: Sequence[Array | bytes]) -> None:
    """Write the first levels of an image, as they lie in memory."""
    with Resources(device) as staging, recording(device) as commands:
        for level, data in enumerate(levels):
            raw = data if isinstance(data, bytes) else data.reshape(-1).view(np.uint8)
            buffer = staging.buffer("transfer_src", raw)
            region = _region(commands, image, level, aspects(image.word) & ~STENCIL_ASPECT)
            lib.vkCmdCopyBufferToImage(
                commands.handle, buffer.handle, image.handle, GENERAL, 1, region
            )
        commands.barrier()


def read(device: Device, image: DeviceImage, level: int = 0, *, stencil: bool = False) -> Array:
    """A level of an image: (layers, height, width, channels); `stencil`: its stencil, in bytes."""
    width, height = image.sizes[level]
    shape = (image.layers, height, width)
    aspect = STENCIL_ASPECT if stencil else aspects(image.word) & ~STENCIL_ASPECT
    size = int(np.prod(shape)) * (1 if stencil else texel_bytes(image.word))
    with Resources(device) as staging:
        buffer = staging.buffer("transfer_dst", size=size)
        with recording(device) as commands:
            region = _region(commands, image, level, aspect)
            lib.vkCmdCopyImageToBuffer(
                commands.handle, image.handle, GENERAL, buffer.handle, 1, region
            )
            commands.barrier()
        data = buffer.bytes[:size].copy()
    return data.reshape(*shape, 1) if stencil else unpacked(image.word, data, shape)


def generate_levels(device: Device, image: DeviceImage) -> None:
    """Halve each level into the next one, by filtering linearly."""
    with recording(device) as commands:
        for level in range(1, image.levels):
            _blit(commands, image, image, level - 1, level)
            commands.barrier()


def copy_level(device: Device, source: DeviceImage, to: DeviceImage) -> None:
    """Copy the largest level of an image to another one of its format and size."""
    with recording(device) as commands:
        part = (aspects(source.word), 0, 0, source.layers)
        region = commands.structs(
            "ImageCopy", srcSubresource=part, dstSubresource=part, extent=(*source.size, 1)
        )
        lib.vkCmdCopyImage(commands.handle, source.handle, GENERAL, to.handle, GENERAL, 1, region)
        commands.barrier()


def _region(commands: Commands, image: DeviceImage, level: int, aspect: int) -> Any:
    return commands.structs(
        "BufferImageCopy", imageSubresource=(aspect, level, 0, image.array_layers),
        imageExtent=(*image.sizes[level], image.depth),
    )  # fmt: skip


def _blit(commands: Commands, source: DeviceImage, to: DeviceImage, one: int, other: int) -> None:
    ends = [((0, 0, 0), (*image.sizes[n], 1)) for image, n in ((source, one), (to, other))]
    parts = [(aspects(source.word), n, 0, source.layers) for n in (one, other)]
    region = commands.structs(
        "ImageBlit", srcSubresource=parts[0], srcOffsets=ends[0], dstSubresource=parts[1],
        dstOffsets=ends[1],
    )  # fmt: skip
    linear = 1
    lib.vkCmdBlitImage(
        commands.handle, source.handle, GENERAL, to.handle, GENERAL, 1, region, linear
    )
