"""Images on the device: made, filled, halved into mipmap levels, drawn to, and read back."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image, leading
from shaderlab.model.textures import level_sizes

from .. import Size
from ..programs.textures import COLOR, DEPTH, format_of
from ..resources import Attachments, multisampled_error
from .device import (
    GENERAL,
    Commands,
    Device,
    Resources,
    Structs,
    constant,
    ffi,
    lib,
    list_sample_counts,
    recording,
)

_CUBE = constant("IMAGE_CREATE_CUBE_COMPATIBLE_BIT")
_OTHER_FORMATS = constant("IMAGE_CREATE_MUTABLE_FORMAT_BIT")
_VIEWS = {"2D": "2D", "2DMS": "2D", "3D": "3D", "Cube": "CUBE", "2DArray": "2D_ARRAY"}


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
    """Return an image without contents, for uses such as "color_attachment" and "sampled". Raises
    UnsupportedError: it is too large for the device."""
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
    dimensions = constant("IMAGE_TYPE_3D" if kind == "3D" else "IMAGE_TYPE_2D")
    handle = resources.create("Image", Structs()(
        "ImageCreateInfo", flags=flags, imageType=dimensions,
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
    """Return a view of an image; one that is `sampled` has all its levels, and of depth and stencil
    the depth alone. `as_word` is another format of the same texels."""
    word = as_word or image.word
    aspect = aspects(word)
    if sampled and aspect & DEPTH_ASPECT:
        aspect = DEPTH_ASPECT
    return resources.create("ImageView", Structs()(
        "ImageViewCreateInfo", image=image.handle, format=vulkan_format(word),
        viewType=constant(f"IMAGE_VIEW_TYPE_{_VIEWS[image.kind]}"),
        subresourceRange=(aspect, 0, image.levels if sampled else 1, 0, image.array_layers),
    ))  # fmt: skip


def write(device: Device, image: DeviceImage, levels: Sequence[Array | bytes]) -> None:
    """Write the first levels of an image, each (layers, height, width, channels), or its blocks."""
    with Resources(device) as staging, recording(device) as commands:
        for level, data in enumerate(levels):
            raw = data if isinstance(data, bytes) else pack_texels(image.word, data).reshape(-1)
            buffer = staging.buffer("transfer_src", raw)
            region = _region(commands, image, level, aspects(image.word) & ~STENCIL_ASPECT)
            lib.vkCmdCopyBufferToImage(
                commands.handle, buffer.handle, image.handle, GENERAL, 1, region
            )
        commands.barrier()


def read(device: Device, image: DeviceImage, level: int = 0, *, stencil: bool = False) -> Array:
    """Return a level of an image, or its `stencil` in bytes: (layers, height, width, channels)."""
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
    return data.reshape(*shape, 1) if stencil else unpack_texels(image.word, data, shape)


def generate_levels(device: Device, image: DeviceImage) -> None:
    """Halve each level into the next one, by filtering linearly."""
    with recording(device) as commands:
        for level in range(1, image.levels):
            ends = [((0, 0, 0), (*image.sizes[n], 1)) for n in (level - 1, level)]
            parts = [(aspects(image.word), n, 0, image.layers) for n in (level - 1, level)]
            region = commands.structs(
                "ImageBlit",
                srcSubresource=parts[0],
                srcOffsets=ends[0],
                dstSubresource=parts[1],
                dstOffsets=ends[1],
            )
            own = (image.handle, GENERAL)
            lib.vkCmdBlitImage(commands.handle, *own, *own, 1, region, constant("FILTER_LINEAR"))
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
        "BufferImageCopy",
        imageSubresource=(aspect, level, 0, image.array_layers),
        imageExtent=(*image.sizes[level], image.depth),
    )


_CHANNELS = {"r": "R{0}", "rg": "R{0}G{0}", "rgb": "R{0}G{0}B{0}A{0}", "rgba": "R{0}G{0}B{0}A{0}"}
_NUMBERS = {
    "8": (8, "UNORM"), "16f": (16, "SFLOAT"), "32f": (32, "SFLOAT"), "32i": (32, "SINT"),
    "32ui": (32, "UINT"),
}  # fmt: skip
_SPELT = {
    f"{channels}{numbers}": f"{pattern.format(bits)}_{kind}"
    for channels, pattern in _CHANNELS.items()
    for numbers, (bits, kind) in _NUMBERS.items()
} | {
    "srgb8_alpha8": "R8G8B8A8_SRGB",
    "depth16": "D16_UNORM",
    "depth24": "X8_D24_UNORM_PACK32",
    "depth32f": "D32_SFLOAT",
    "depth24_stencil8": "D24_UNORM_S8_UINT",
    "depth32f_stencil8": "D32_SFLOAT_S8_UINT",
    "bc1": "BC1_RGB_UNORM_BLOCK",
    "bc3": "BC3_UNORM_BLOCK",
    "bc7": "BC7_UNORM_BLOCK",
    "etc2_rgb8": "ETC2_R8G8B8_UNORM_BLOCK",
    "etc2_eac_rgba8": "ETC2_R8G8B8A8_UNORM_BLOCK",
}  # fmt: skip
_FINER = {"depth24": "depth32f", "depth24_stencil8": "depth32f_stencil8"}
COLOR_ASPECT, DEPTH_ASPECT, STENCIL_ASPECT = (
    constant(f"IMAGE_ASPECT_{kind}_BIT") for kind in ("COLOR", "DEPTH", "STENCIL")
)


def vulkan_format(word: str) -> int:
    """Return the VkFormat of a format; three channels get a fourth: few devices draw to three."""
    return constant(f"FORMAT_{_SPELT[word]}")


def choose_format(device: Device, word: str, *uses: str) -> str:
    """Return the format that a device keeps an image of a format in: the same, or, for 24 bits of
    depth where it has none, 32. It must serve for `uses`, such as "color_attachment". Raises
    UnsupportedError: the device has no such image."""
    for candidate in (word, _FINER.get(word, word)):
        if not find_missing_uses(device, candidate, *uses):
            return candidate
    what = ", ".join(use.replace("_", " ") for use in find_missing_uses(device, word, *uses))
    raise UnsupportedError(f"{word}: this device has no VK_FORMAT_{_SPELT[word]} as {what}")


def find_missing_uses(device: Device, word: str, *uses: str) -> list[str]:
    """Return those of the uses that a device does not offer for a format, in optimal tiling."""
    found = ffi.new("VkFormatProperties *")
    lib.vkGetPhysicalDeviceFormatProperties(device.physical, vulkan_format(word), found)
    have = found.optimalTilingFeatures
    return [use for use in uses if not have & constant(f"FORMAT_FEATURE_{use.upper()}_BIT")]


def aspects(word: str) -> int:
    if word not in DEPTH:
        return COLOR_ASPECT
    return DEPTH_ASPECT | (STENCIL_ASPECT if DEPTH[word].stencil else 0)


def pack_texels(word: str, values: Array) -> Array:
    """Texels as a buffer holds them: depths as codes, three channels with a fourth, which is 1."""
    if word in DEPTH:
        return _encode_depths(word, values)
    kind = format_of(word)
    if kind.components != 3:
        return np.ascontiguousarray(values)
    one = 255 if kind.numpy is np.uint8 else 1
    padded = np.full((*values.shape[:-1], 4), one, kind.numpy)
    padded[..., :3] = values
    return padded


def unpack_texels(word: str, data: Array, shape: tuple[int, ...]) -> Array:
    """Return a buffer's bytes as texels, (*shape, channels)."""
    if word in DEPTH:
        return _decode_depths(word, data).reshape(*shape, 1)
    kind = format_of(word)
    stored = 4 if kind.components == 3 else kind.components
    values = data.view(kind.numpy).reshape(*shape, stored)
    return leading(values, kind.components)


def texel_bytes(word: str) -> int:
    """Return how many bytes a texel takes in a buffer."""
    if word in DEPTH:
        return 2 if word == "depth16" else 4
    kind = format_of(word)
    count = 4 if kind.components == 3 else kind.components
    return count * int(np.dtype(kind.numpy).itemsize)


def _encode_depths(word: str, values: Array) -> Array:
    if word.startswith("depth32f"):
        return np.ascontiguousarray(values, np.float32)
    most = 0xFFFF if word == "depth16" else 0xFFFFFF
    codes = np.rint(np.clip(values.astype(np.float64), 0.0, 1.0) * most)
    return np.ascontiguousarray(codes, np.uint16 if word == "depth16" else np.uint32)


def _decode_depths(word: str, data: Array) -> Array:
    if word.startswith("depth32f"):
        return data.view(np.float32).copy()
    if word == "depth16":
        return (data.view(np.uint16) / 65535.0).astype(np.float32)
    return ((data.view(np.uint32) & 0xFFFFFF) / float(0xFFFFFF)).astype(np.float32)


_KEEP, _CLEAR = constant("ATTACHMENT_LOAD_OP_LOAD"), constant("ATTACHMENT_LOAD_OP_CLEAR")
USES = ("sampled", "transfer_src", "transfer_dst")
# Source: Vulkan 1.3 Specification, table Standard Sample Locations, in sixteenths.
_PLACES = {
    1: ((8, 8),),
    2: ((12, 12), (4, 4)),
    4: ((6, 2), (14, 6), (2, 10), (10, 14)),
    8: ((9, 5), (7, 11), (13, 9), (5, 3), (3, 13), (1, 7), (11, 15), (15, 1)),
}


class RenderTarget(Attachments):
    _device: Device

    def _make(self) -> None:
        self.samples = _samples(self._device, self._target.samples)
        self._resources = Resources(self._device)
        try:
            self._make_images()
        except BaseException:
            self.release()
            raise

    def _make_images(self) -> None:
        device, uses = self._device, ("color_attachment", *USES)
        for word in self.colors.values():
            choose_format(device, word, "color_attachment")
        own = self._resources
        self.images = {n: new_image(own, w, self.size, *uses) for n, w in self.colors.items()}
        self.drawn = self.images  # with all of their samples
        if self.samples > 1:
            self.drawn = {
                name: new_image(own, w, self.size, *uses, kind="2DMS", samples=self.samples)
                for name, w in self.colors.items()
            }
        # An attachment of sRGB is written as it comes unless a draw asks for encoding.
        self._encoding = {name: new_view(own, image) for name, image in self.drawn.items()}
        self._plain = dict(self._encoding)
        for name, image in self.drawn.items():
            if image.word == "srgb8_alpha8":
                self._plain[name] = new_view(own, image, as_word="rgba8")
        self.depth_image: DeviceImage | None = None
        if self._target.depth is not None:
            self.depth = choose_format(device, self._target.depth, "depth_stencil_attachment")
            kind, uses = "2DMS" if self.samples > 1 else "2D", ("depth_stencil_attachment", *USES)
            made = new_image(own, self.depth, self.size, *uses, kind=kind, samples=self.samples)
            self.depth_image, self._depth_view = made, new_view(own, made)

    def release(self) -> None:
        self._resources.close()

    def formats(self, locations: Mapping[int, str], *, srgb: bool = False) -> dict[int, str]:
        """Return the attachments' formats by the locations of outputs."""
        plain = {"srgb8_alpha8": "srgb8_alpha8" if srgb else "rgba8"}
        return {at: plain.get(self.colors[n], self.colors[n]) for at, n in locations.items()}

    def clear(self) -> None:
        with recording(self._device) as commands:
            locations = dict(enumerate(self.colors))
            self.begin(commands, locations, clear=True)
            self.end(commands)

    def begin(
        self,
        commands: Commands,
        locations: Mapping[int, str],
        *,
        srgb: bool = False,
        clear: bool = False,
    ) -> None:
        """Draw into this target from now on, with a program that writes its outputs at these
        locations; outputs without an attachment here go nowhere."""
        structs, views = commands.structs, self._encoding if srgb else self._plain
        how = {"imageLayout": GENERAL, "loadOp": _CLEAR if clear else _KEEP}

        def attach(view: Any, value: Mapping[str, Any]) -> Any:
            return structs("RenderingAttachmentInfo", imageView=view, clearValue=value, **how)

        colors = []
        for place in range(max(locations, default=-1) + 1):
            if place not in locations:
                colors.append(structs("RenderingAttachmentInfo"))
                continue
            name = locations[place]
            kind = "int32" if COLOR[self.colors[name]].integer else "float32"
            values = [int(v) if kind == "int32" else v for v in self._target.clear]
            colors.append(attach(views[name], {"color": {kind: values}}))
        depth = None
        if self.depth:
            target = self._target
            value = {"depthStencil": (target.clear_depth, target.clear_stencil)}
            depth = attach(self._depth_view, value)
        has_stencil = self.depth and aspects(self.depth) & STENCIL_ASPECT
        attached: dict[str, Any] = {"pDepthAttachment": depth} if depth is not None else {}
        if has_stencil:
            attached["pStencilAttachment"] = depth
        info = structs(
            "RenderingInfo",
            renderArea=((0, 0), self.size),
            layerCount=1,
            colorAttachmentCount=len(colors),
            pColorAttachments=colors,
            **attached,
        )
        lib.vkCmdBeginRendering(commands.handle, info)

    def end(self, commands: Commands) -> None:
        lib.vkCmdEndRendering(commands.handle)
        commands.barrier()

    def resolve(self) -> None:
        if self.samples == 1:
            return
        part = (COLOR_ASPECT, 0, 0, 1)
        with recording(self._device) as commands:
            region = commands.structs(
                "ImageResolve", srcSubresource=part, dstSubresource=part, extent=(*self.size, 1)
            )
            for name, image in self.images.items():
                ends = (self.drawn[name].handle, GENERAL, image.handle, GENERAL)
                lib.vkCmdResolveImage(commands.handle, *ends, 1, region)
            commands.barrier()

    def sample_positions(self) -> Array:
        if not self._device.limits.standardSampleLocations or self.samples not in _PLACES:
            raise UnsupportedError("sample positions: this device does not say where they are")
        return np.array(_PLACES[self.samples], np.float32) / 16

    def read(self, name: str) -> Image:
        if name in self.colors:
            return Image(read(self._device, self.images[name])[0], self.colors[name])
        assert self.depth_image is not None
        if self.samples > 1:
            raise multisampled_error(name)
        stencil = name == "stencil"
        values = read(self._device, self.depth_image, stencil=stencil)[0]
        return Image(values, "stencil8" if stencil else self.depth)


def _samples(device: Device, asked: int) -> int:
    """Return the samples of a pixel: as OpenGL has it, the next number that the device offers."""
    offered = list_sample_counts(device.limits)
    found = [count for count in offered if count >= asked]
    if not found:
        raise UnsupportedError(f"{asked} samples: this device offers {max(offered)}")
    return found[0] if asked else 1
