"""A draw that is ready: its program, its pipeline and all that it reads are on the device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.scene import Target
from shaderlab.model.state import COMPARISONS, State
from shaderlab.model.textures import (
    WRAPS,
    CompressedTexture,
    Output,
    Sampling,
    TextureSource,
    level_sizes,
)

from .. import Size
from ..programs.textures import DEPTH, blocks_of, contents, find_image, format_of, kind_of
from ..resources import COVERING, UNREADABLE, DeviceTexels, SceneTextures
from . import state as fixed
from .api import NULL, Structs, lib
from .device import Commands, Device, Resources, recording
from .images import (
    DeviceImage,
    copy_level,
    fill,
    generate_levels,
    new_image,
    new_view,
    read,
    stored_as,
    write,
)
from .program import DEFAULT_BLOCK, BoundImage, Layout, Linker, Program, new_set
from .target import RenderTarget
from .vertices import VertexBuffers, VertexLayout

_GRAPHICS = 0


@dataclass(frozen=True)
class Ready:
    """A draw whose program, pipeline and data are on the device."""

    program: Program
    layout: Layout
    locations: Mapping[int, str]
    state: State
    vertices: VertexBuffers
    instances: int
    descriptors: Any

    def record(self, commands: Commands, size: Size) -> None:
        """Record the draw, between a target's `begin` and its `end`."""
        structs, handle = commands.structs, commands.handle
        box, scissor = fixed.viewport(self.state, size)
        near, far = self.state.depth_range
        lib.vkCmdBindPipeline(handle, _GRAPHICS, self.program.pipeline(self.layout))
        lib.vkCmdSetViewport(handle, 0, 1, structs(
            "Viewport", x=box[0], y=box[1], width=box[2], height=box[3], minDepth=near, maxDepth=far
        ))  # fmt: skip
        lib.vkCmdSetScissor(handle, 0, 1, structs(
            "Rect2D", offset=scissor[:2], extent=scissor[2:]
        ))  # fmt: skip
        if self.descriptors != NULL:
            own = structs.array("VkDescriptorSet", [self.descriptors])
            lib.vkCmdBindDescriptorSets(handle, _GRAPHICS, self.program.layout, 0, 1, own, 0, NULL)
        if min(box[2:]) > 0:
            self.vertices.draw(commands, self.layout.vertices, self.instances)


_USES = ("sampled", "transfer_src", "transfer_dst")


@dataclass(eq=False)
class BoundTextures(SceneTextures[RenderTarget]):
    """What a scene's samplers read. Arguments as of `SceneTextures`, and besides:

    Args:
        resources: where they are made, to be released with the scene.
        linker: makes the programs that read texels.
    """

    _resources: Resources
    _linker: Linker
    _attachments: dict[tuple[str, str, str, bool], DeviceTexels] = field(
        default_factory=dict, init=False
    )
    _samplers: dict[tuple[Any, ...], Any] = field(default_factory=dict, init=False)

    @property
    def _device(self) -> Device:
        return self._resources.device

    def bound(self, variable: Variable, source: TextureSource) -> BoundImage:
        """The view and the sampler of a texture that `texels` has looked at."""
        found = self.find(source, self.kind(source, variable))
        if any(word != "nearest" for word in source.filter):
            stored_as(self._device, found.format, "sampled_image_filter_linear")
        seamless = getattr(source, "seamless", True)
        key = (source.filter, source.wrap, source.border, source.compare, source.lod, seamless)
        if key not in self._samplers:
            self._samplers[key] = new_sampler(self._resources, source, seamless=seamless)
        return BoundImage(found.handle, self._samplers[key])

    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        key = (source.pass_name, source.name, kind, source.mipmaps)
        if key not in self._attachments:
            self._attachments[key] = self._attachment(source, kind)
        return self._attachments[key]

    def _attachment(self, source: Output, kind: str) -> DeviceTexels:
        image = find_image(source, self.images)
        target = self.targets[source.pass_name]
        if kind == "2DMS":
            return self._multisampled(source, image, target)
        if source.name not in target.colors and target.samples > 1:
            raise UnsupportedError(
                f"sampling the {source.name} of this target",
                remedy=UNREADABLE,
            )
        if source.name == "stencil":
            raise UnsupportedError("sampling the stencil of this target")
        drawn = target.images.get(source.name, target.depth_image)
        assert drawn is not None
        levels: tuple[Array, ...] = ()
        if source.mipmaps:
            whole = self._image(drawn.word, drawn.size, mipmaps=True)
            copy_level(self._device, drawn, whole)
            generate_levels(self._device, whole)
            drawn, levels = whole, self._smaller(whole, image.values.shape[-1])
        view = new_view(self._resources, drawn, sampled=True)
        return DeviceTexels(source, view, image.format, image.values, levels)

    def _multisampled(self, source: Output, image: Image, target: RenderTarget) -> DeviceTexels:
        drawn = target.drawn_image(source.name)
        view = new_view(self._resources, drawn, sampled=True)
        each = [
            fetched(self._linker, view, "2DMS", number, target.size, "rgba32f")
            for number in range(target.samples)
        ]
        channels = format_of(image.format).components
        return DeviceTexels(source, view, image.format, np.stack(each)[..., :channels])

    def upload(self, source: TextureSource) -> DeviceTexels:
        assert not isinstance(source, Output)
        if isinstance(source, CompressedTexture):
            return self._compressed(source)
        kind = kind_of(source, "", 0)
        images = contents(source, self.folder, self.images)
        height, width = images.layers[0].shape[:2]
        format = stored_as(self._device, source.format, "sampled_image")
        given = [np.stack(images.layers), *(level[None] for level in images.smaller)]
        made = self._image(
            format, (width, height), kind=kind, layers=len(images.layers),
            mipmaps=source.mipmaps is True, levels=len(given),
        )  # fmt: skip
        fill(self._device, made, given)
        values, smaller = images.layers[0], tuple(images.smaller)
        if kind != "2D" or format in DEPTH:
            # A depth is rounded to its format's codes on the way.
            values = self._read(made, 0)
        if source.mipmaps is True:
            generate_levels(self._device, made)
        if source.mipmaps is True or (smaller and format in DEPTH):
            smaller = self._smaller(made)
        return DeviceTexels(source, self._view(made), format, values, smaller)

    def _compressed(self, source: CompressedTexture) -> DeviceTexels:
        blocks = blocks_of(source, self.folder)
        stored_as(self._device, blocks.format, "sampled_image")
        sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
        made = new_image(
            self._resources, blocks.format, blocks.size, "sampled", "transfer_dst",
            levels=len(blocks.levels),
        )  # fmt: skip
        write(self._device, made, blocks.levels)
        view = self._view(made)
        first, *smaller = (
            fetched(self._linker, view, "2D", level, size, "rgba8")
            for level, size in enumerate(sizes)
        )
        return DeviceTexels(source, view, "rgba8", first, tuple(smaller))

    def _image(
        self,
        format: str,
        size: tuple[int, int],
        *,
        kind: str = "2D",
        layers: int = 1,
        mipmaps: bool = False,
        levels: int = 1,
    ) -> DeviceImage:
        count = len(level_sizes(*size)) if mipmaps else levels
        if mipmaps:
            stored_as(self._device, format, "blit_src", "blit_dst", "sampled_image_filter_linear")
        return new_image(
            self._resources, format, size, *_USES, kind=kind, layers=layers, levels=count
        )

    def _view(self, image: DeviceImage) -> Any:
        return new_view(self._resources, image, sampled=True)

    def _read(self, image: DeviceImage, level: int) -> Array:
        found = read(self._device, image, level)
        return found[0] if image.kind == "2D" else found

    def _smaller(self, image: DeviceImage, channels: int = 4) -> tuple[Array, ...]:
        """The levels below the first, as the device has them."""
        levels = range(1, image.levels)
        return tuple(self._read(image, level)[..., :channels] for level in levels)


_NOT_SEAMLESS = 4
_BORDERS = {(0.0, 0.0, 0.0, 0.0): 0, (0.0, 0.0, 0.0, 1.0): 2, (1.0, 1.0, 1.0, 1.0): 4}
_CUSTOM_BORDER = 1000287003
# A texture without mipmaps has no level but the first; up to here its filters are told apart by
# the level of detail, as the specification recommends for OpenGL's two filters without mipmaps.
_ONE_LEVEL = 0.25


def new_sampler(resources: Resources, sampling: Sampling, *, seamless: bool = True) -> Any:
    """A sampler of these filters and wraps.

    Raises:
        UnsupportedError: the device has no such border, or filters every cube across its edges.
    """
    device, structs = resources.device, Structs()
    smaller, larger = sampling.filter
    mipmaps = "mipmap" in smaller
    lod = sampling.lod if mipmaps else tuple(min(max(v, 0.0), _ONE_LEVEL) for v in sampling.lod)
    if not seamless and "nonSeamlessCubeMap" not in device.features:
        raise UnsupportedError("seamless=False: this device has no VK_EXT_non_seamless_cube_map")
    chain, border = {}, _BORDERS.get(sampling.border, 0)
    if "clamp_to_border" in sampling.wrap and sampling.border not in _BORDERS:
        chain, border = {"pNext": _custom_border(device, structs, sampling)}, _CUSTOM_BORDER
    across, up, *along_r = (WRAPS.index(word) for word in sampling.wrap)
    return resources.create("Sampler", structs(
        "SamplerCreateInfo", **chain, flags=0 if seamless else _NOT_SEAMLESS,
        magFilter=larger.startswith("linear"), minFilter=smaller.startswith("linear"),
        mipmapMode=smaller.endswith("mipmap_linear"), addressModeU=across, addressModeV=up,
        addressModeW=(*along_r, up)[0], minLod=lod[0], maxLod=lod[1], borderColor=border,
        compareEnable=sampling.compare is not None,
        compareOp=COMPARISONS.index(sampling.compare or "lequal"),
    ))  # fmt: skip


def _custom_border(device: Device, structs: Structs, sampling: Sampling) -> Any:
    needed = ("customBorderColors", "customBorderColorWithoutFormat")
    if not device.features.issuperset(needed):
        raise UnsupportedError(
            f"a border of {sampling.border}: this device has no VK_EXT_custom_border_color"
        )
    return structs(
        "SamplerCustomBorderColorCreateInfoEXT", customBorderColor={"float32": sampling.border}
    )


_FETCH = """#version 330 core
uniform sampler{kind} texels;
uniform int number;
out vec4 color;
void main() {{ color = texelFetch(texels, ivec2(gl_FragCoord.xy), number); }}
"""


def fetched(
    linker: Linker, view: Any, kind: str, number: int, size: tuple[int, int], word: str
) -> Array:
    """One sample ("2DMS"), or one level ("2D"), of a float or normalised texture.

    Args:
        linker: makes the program.
        view: of the texture.
        kind: as in `Texels.kind`.
        number: of the sample or of the level.
        size: (width, height) in texels.
        word: the format to read them in.

    Returns:
        (height, width, channels)
    """
    texts = {"vertex": COVERING, "fragment": _FETCH.format(kind=kind)}
    program = linker.link(texts)
    colors = {"color": word}
    with Resources(linker.device) as own, RenderTarget(linker.device, Target(), colors, size) as to:
        sampler = own.create("Sampler", Structs()("SamplerCreateInfo", maxLod=1000.0))
        buffer = own.buffer("uniform_buffer", number.to_bytes(16, "little"))
        bound = new_set(
            own, program.set_layout, program.bindings, {DEFAULT_BLOCK: buffer.handle},
            {"texels": BoundImage(view, sampler)},
        )  # fmt: skip
        layout = Layout(VertexLayout(), ((0, word),), "", 1, State())
        ready = Ready(program, layout, {0: "color"}, State(), VertexBuffers((), None, 3), 1, bound)
        with recording(linker.device) as commands:
            to.begin(commands, ready.locations)
            ready.record(commands, size)
            to.end(commands)
        return to.read("color").values
