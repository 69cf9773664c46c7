"""Render targets: a pass's attachments, cleared, drawn into, and read back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.scene import Target

from ..programs.textures import COLOR
from ..resources import Attachments, multisampled_error
from .api import lib
from .device import GENERAL, Commands, Device, Resources, recording, samples_offered
from .images import STENCIL_ASPECT, DeviceImage, aspects, new_image, new_view, read, stored_as

_KEEP, _CLEAR = 0, 1
_USES = ("sampled", "transfer_src", "transfer_dst")
# Source: Vulkan 1.3 Specification, table Standard Sample Locations, in sixteenths.
_PLACES = {
    1: ((8, 8),),
    2: ((12, 12), (4, 4)),
    4: ((6, 2), (14, 6), (2, 10), (10, 14)),
    8: ((9, 5), (7, 11), (13, 9), (5, 3), (3, 13), (1, 7), (11, 15), (15, 1)),
}


class RenderTarget(Attachments):
    """As `Attachments`, on a device."""

    def __init__(
        self, device: Device, target: Target, colors: Mapping[str, str], size: tuple[int, int]
    ) -> None:
        super().__init__(target, colors, size)
        self.samples = _samples(device, target.samples)
        self._device = device
        self._resources = Resources(device)
        try:
            self._make()
        except BaseException:
            self.release()
            raise

    def _make(self) -> None:
        device, uses = self._device, ("color_attachment", *_USES)
        for word in self.colors.values():
            stored_as(device, word, "color_attachment")
        own = self._resources
        self.images = {n: new_image(own, w, self.size, *uses) for n, w in self.colors.items()}
        self._drawn = self.images
        if self.samples > 1:
            self._drawn = {
                name: new_image(own, w, self.size, *uses, kind="2DMS", samples=self.samples)
                for name, w in self.colors.items()
            }
        # An attachment of sRGB is written as it comes unless a draw asks for encoding.
        self._encoding = {name: new_view(own, image) for name, image in self._drawn.items()}
        self._plain = {
            name: new_view(own, image, as_word="rgba8") if image.word == "srgb8_alpha8" else
            self._encoding[name] for name, image in self._drawn.items()
        }  # fmt: skip
        self.depth_image: DeviceImage | None = None
        if self._target.depth is not None:
            self.depth = stored_as(device, self._target.depth, "depth_stencil_attachment")
            self.depth_image = new_image(
                own, self.depth, self.size, "depth_stencil_attachment", *_USES,
                kind="2DMS" if self.samples > 1 else "2D", samples=self.samples,
            )  # fmt: skip
            self._depth_view = new_view(own, self.depth_image)

    def release(self) -> None:
        self._resources.release()

    def formats(self, locations: Mapping[int, str], *, srgb: bool = False) -> dict[int, str]:
        """The attachments' formats by the locations of the outputs that are drawn to them."""
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
        colors = []
        for place in range(max(locations, default=-1) + 1):
            if place not in locations:
                colors.append(structs("RenderingAttachmentInfo"))
                continue
            name = locations[place]
            kind = "int32" if COLOR[self.colors[name]].integer else "float32"
            values = [int(v) if kind == "int32" else v for v in self._target.clear]
            colors.append(structs(
                "RenderingAttachmentInfo", imageView=views[name], imageLayout=GENERAL,
                loadOp=_CLEAR if clear else _KEEP, clearValue={"color": {kind: values}},
            ))  # fmt: skip
        depth = None
        if self.depth:
            target = self._target
            value = {"depthStencil": (target.clear_depth, target.clear_stencil)}
            depth = structs(
                "RenderingAttachmentInfo", imageView=self._depth_view, imageLayout=GENERAL,
                loadOp=_CLEAR if clear else _KEEP, clearValue=value,
            )  # fmt: skip
        has_stencil = self.depth and aspects(self.depth) & STENCIL_ASPECT
        attached: dict[str, Any] = {"pDepthAttachment": depth} if depth is not None else {}
        if has_stencil:
            attached["pStencilAttachment"] = depth
        info = structs(
            "RenderingInfo", renderArea=((0, 0), self.size), layerCount=1,
            colorAttachmentCount=len(colors), pColorAttachments=colors, **attached,
        )  # fmt: skip
        lib.vkCmdBeginRendering(commands.handle, info)

    def end(self, commands: Commands) -> None:
        """Draw into it no longer."""
        lib.vkCmdEndRendering(commands.handle)
        commands.barrier()

    def resolve(self) -> None:
        if self.samples == 1:
            return
        part = (1, 0, 0, 1)
        with recording(self._device) as commands:
            region = commands.structs(
                "ImageResolve", srcSubresource=part, dstSubresource=part, extent=(*self.size, 1)
            )
            for name, image in self.images.items():
                lib.vkCmdResolveImage(
                    commands.handle, self._drawn[name].handle, GENERAL, image.handle, GENERAL, 1,
                    region,
                )  # fmt: skip
            commands.barrier()

    def sample_positions(self) -> Array:
        if not self._device.limits.standardSampleLocations or self.samples not in _PLACES:
            raise UnsupportedError("sample positions: this device does not say where they are")
        return np.array(_PLACES[self.samples], np.float32) / 16

    def drawn_image(self, name: str) -> DeviceImage:
        """A colour attachment with all of its samples."""
        return self._drawn[name]

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
    """How many samples a pixel gets: as many as are asked for, or as OpenGL has it, the next number
    above that the device offers."""
    offered = samples_offered(device.limits)
    found = [count for count in offered if count >= asked]
    if not found:
        raise UnsupportedError(f"{asked} samples: this device offers {max(offered)}")
    return found[0] if asked else 1
