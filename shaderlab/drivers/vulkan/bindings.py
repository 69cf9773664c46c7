"""What a draw reads on the device: vertices, uniforms, textures; and a draw that is ready."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block, Variable
from shaderlab.errors import UnsupportedError
from shaderlab.model.frame import Array, Image
from shaderlab.model.mesh import PRIMITIVES, Mesh
from shaderlab.model.scene import Target
from shaderlab.model.state import COMPARISONS, State
from shaderlab.model.textures import WRAPS, CompressedTexture, Output, TextureSource, level_sizes

from ..programs import bind, textures
from ..resources import COVERING, UNREADABLE, DeviceTexels, SceneTextures
from .device import (
    GENERAL,
    NULL,
    Buffer,
    Commands,
    Device,
    Resources,
    Structs,
    check,
    constant,
    ffi,
    lib,
    recording,
)
from .images import (
    USES,
    DeviceImage,
    RenderTarget,
    choose_format,
    copy_level,
    generate_levels,
    new_image,
    new_view,
    read,
    write,
)
from .program import (
    DEFAULT_BLOCK,
    SAMPLED,
    STORED,
    UNIFORM,
    Binding,
    Layout,
    Linker,
    Program,
    VertexLayout,
    sampler_place,
    viewport,
)

_INDEX_TYPE = constant("INDEX_TYPE_UINT32")
_WHOLE_SIZE = 2**64 - 1  # the package has VK_WHOLE_SIZE as -1
_FORMATS = {"f": "SFLOAT", "i": "SINT", "u": "UINT"}


def layout_of(mesh: Mesh | None, declared: Mapping[str, Variable]) -> VertexLayout:
    """Return the layout of a mesh, made for a vertex stage that declares these inputs."""
    if mesh is None:
        return VertexLayout()
    streams: list[tuple[int, int, int, int]] = []
    attributes: list[tuple[int, int, int, int]] = []
    # Vulkan's first number for a topology is that of points, and so on in the order of PRIMITIVES.
    topology = PRIMITIVES.index(mesh.primitive)
    for name, place in mesh.placements().items():
        variable = declared.get(name)
        if variable is None or variable.location is None:
            continue
        array = mesh.inputs[name]
        if array.dtype.kind in "iu" and textures.numpy_type(variable.type) is np.float32:
            raise UnsupportedError(f"{name}: integers for a {variable.type}: Vulkan converts none")
        columns = array.shape[2] if array.ndim == 3 else 1
        size = array.shape[1]
        letter = "u" if textures.numpy_type(variable.type) is np.uint32 else array.dtype.kind
        channels = "".join(f"{channel}32" for channel in "RGBA"[:size])
        format = constant(f"FORMAT_{channels}_{_FORMATS[letter]}")
        for column in range(columns):
            offset = column * size * array.itemsize
            attributes.append((variable.location + column, len(streams), format, offset))
        streams.append((place.buffer, place.offset, place.stride, place.divisor))
    return VertexLayout(tuple(streams), tuple(attributes), topology)


@dataclass(frozen=True)
class VertexBuffers:
    """A mesh's buffers on the device; `count` is how many vertices a draw takes."""

    buffers: tuple[Buffer, ...]
    indices: Buffer | None
    count: int

    def draw(self, commands: Commands, layout: VertexLayout, instances: int) -> None:
        """Record the draw call, for a pipeline of this layout."""
        streams = layout.streams
        if streams:
            handles = [self.buffers[buffer].handle for buffer, *_ in streams]
            own = commands.structs.array("VkBuffer", handles)
            starts = commands.structs.array("VkDeviceSize", [offset for _, offset, *_ in streams])
            lib.vkCmdBindVertexBuffers(commands.handle, 0, len(handles), own, starts)
        if self.indices is None:
            lib.vkCmdDraw(commands.handle, self.count, instances, 0, 0)
            return
        lib.vkCmdBindIndexBuffer(commands.handle, self.indices.handle, 0, _INDEX_TYPE)
        lib.vkCmdDrawIndexed(commands.handle, self.count, instances, 0, 0, 0)


def upload(resources: Resources, mesh: Mesh | None) -> VertexBuffers:
    """Return the buffers of a mesh, or three vertices without attributes."""
    if mesh is None:
        return VertexBuffers((), None, 3)
    contents = (b"".join(piece for _, piece in own) for own in mesh.parts())
    buffers = tuple(resources.buffer("vertex_buffer", data) for data in contents)
    if mesh.indices is None:
        return VertexBuffers(buffers, None, mesh.vertices)
    indices = resources.buffer("index_buffer", mesh.indices.astype(np.uint32))
    return VertexBuffers(buffers, indices, len(mesh.indices))


@dataclass(frozen=True)
class BoundImage:
    """A texture for a binding: its view and its sampler."""

    view: Any
    sampler: Any


def new_set(
    resources: Resources,
    layout: Any,
    bindings: Mapping[str, Binding],
    buffers: Mapping[str, Any],
    images: Mapping[str, BoundImage],
) -> Any:
    """Return a set with these buffers by the names of their blocks, and textures by their samplers'
    names as in OpenGL; NULL if there is nothing to bind."""
    if not bindings:
        return NULL
    structs = Structs()
    sizes = [(binding.kind, binding.count) for binding in bindings.values()]
    pool = resources.create(
        "DescriptorPool",
        structs("DescriptorPoolCreateInfo", maxSets=1, poolSizeCount=len(sizes), pPoolSizes=sizes),
    )
    made = ffi.new("VkDescriptorSet *")
    info = structs(
        "DescriptorSetAllocateInfo", descriptorPool=pool, descriptorSetCount=1, pSetLayouts=[layout]
    )
    check(lib.vkAllocateDescriptorSets(resources.device.handle, info, made), "binding")
    writes = []
    for name, buffer in buffers.items():
        whole = structs("DescriptorBufferInfo", buffer=buffer, range=_WHOLE_SIZE)
        own = bindings[name]
        writes.append(structs(
            "WriteDescriptorSet", dstSet=made[0], dstBinding=own.number, descriptorCount=1,
            descriptorType=own.kind, pBufferInfo=[whole],
        ))  # fmt: skip
    for name, image in images.items():
        place = sampler_place(name, bindings)
        if place is None:
            continue
        shown = structs(
            "DescriptorImageInfo", sampler=image.sampler, imageView=image.view, imageLayout=GENERAL
        )
        writes.append(structs(
            "WriteDescriptorSet", dstSet=made[0], dstBinding=place[0].number, descriptorCount=1,
            dstArrayElement=place[1], descriptorType=SAMPLED, pImageInfo=[shown],
        ))  # fmt: skip
    changed = structs.array("VkWriteDescriptorSet", writes)
    lib.vkUpdateDescriptorSets(resources.device.handle, len(writes), changed, 0, NULL)
    return made[0]


_NONE: Mapping[str, Buffer] = {}


def block_buffers(
    own: Resources,
    bindings: Mapping[str, Binding],
    values: Mapping[str, Array],
    stored: Mapping[str, Buffer] = _NONE,
) -> dict[str, Any]:
    """Return a buffer's handle for each block of a program, released with `own`; `values` are
    uniforms and members by OpenGL's names, `stored` storage buffers by their blocks' names. Raises
    UnsupportedError: a storage block has no buffer."""
    found = {}
    for name, binding in bindings.items():
        if binding.kind == STORED:
            if name not in stored:
                raise UnsupportedError(f"{name}: storage buffers have no values here")
            found[name] = stored[name].handle
        elif binding.kind == UNIFORM:
            assert binding.block is not None
            data = _pack_block(binding.block, values)
            found[name] = own.buffer("uniform_buffer", data).handle
    return found


def _pack_block(block: Block, values: Mapping[str, Array]) -> bytes:
    """Return a block's bytes; a struct's stand-in for samplers that were lifted out of it is 0."""
    given = dict(values)
    for member in block.members.values():
        if block.name == DEFAULT_BLOCK and member.name not in given:
            given[member.name] = np.zeros(1, np.float32)
    return bind.pack_block(block, given)


_GRAPHICS = constant("PIPELINE_BIND_POINT_GRAPHICS")


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

    def record(self, commands: Commands, target: RenderTarget) -> None:
        structs, handle = commands.structs, commands.handle
        box, scissor = viewport(self.state, target.size)
        target.begin(commands, self.locations, srgb=self.state.srgb)
        lib.vkCmdBindPipeline(handle, _GRAPHICS, self.program.pipeline(self.layout))
        area = structs("Viewport", x=box[0], y=box[1], width=box[2], height=box[3])
        area.minDepth, area.maxDepth = self.state.depth_range
        lib.vkCmdSetViewport(handle, 0, 1, area)
        kept = structs("Rect2D", offset=scissor[:2], extent=scissor[2:])
        lib.vkCmdSetScissor(handle, 0, 1, kept)
        if self.descriptors != NULL:
            own = structs.array("VkDescriptorSet", [self.descriptors])
            lib.vkCmdBindDescriptorSets(handle, _GRAPHICS, self.program.layout, 0, 1, own, 0, NULL)
        if min(box[2:]) > 0:
            self.vertices.draw(commands, self.layout.vertices, self.instances)
        target.end(commands)


@dataclass(eq=False)
class BoundTextures(SceneTextures[RenderTarget]):
    """What a scene's samplers read; `linker` makes the programs that read texels."""

    _resources: Resources
    linker: Linker

    @property
    def _device(self) -> Device:
        return self._resources.device

    def bind(self, variable: Variable, source: TextureSource) -> BoundImage:
        """Return the view and the sampler of a texture that `texels` has looked at."""
        found = self.find(source, self.kind(source, variable))
        if any(word != "nearest" for word in source.filter):
            choose_format(self._device, found.format, "sampled_image_filter_linear")
        return BoundImage(found.handle, self.sampler(source))

    def new_sampler(self, source: TextureSource) -> Any:
        device, structs = self._device, Structs()
        smaller, larger = source.filter
        seamless = getattr(source, "seamless", True)
        mipmaps = "mipmap" in smaller
        lod = source.lod if mipmaps else tuple(min(max(v, 0.0), _ONE_LEVEL) for v in source.lod)
        if not seamless and "nonSeamlessCubeMap" not in device.features:
            raise UnsupportedError(
                "seamless=False: this device has no VK_EXT_non_seamless_cube_map"
            )
        chain, border = {}, _BORDERS.get(source.border, 0)
        if "clamp_to_border" in source.wrap and source.border not in _BORDERS:
            if "customBorderColorWithoutFormat" not in device.features:
                raise UnsupportedError(
                    f"a border of {source.border}: this device has no VK_EXT_custom_border_color"
                )
            color = {"float32": source.border}
            own = structs("SamplerCustomBorderColorCreateInfoEXT", customBorderColor=color)
            chain, border = {"pNext": own}, _CUSTOM_BORDER
        across, up, *along_r = (WRAPS.index(word) for word in source.wrap)
        return self._resources.create("Sampler", structs(
            "SamplerCreateInfo", **chain, flags=0 if seamless else _NOT_SEAMLESS,
            magFilter=larger.startswith("linear"), minFilter=smaller.startswith("linear"),
            mipmapMode=smaller.endswith("mipmap_linear"), addressModeU=across, addressModeV=up,
            addressModeW=(*along_r, up)[0], minLod=lod[0], maxLod=lod[1], borderColor=border,
            compareEnable=source.compare is not None,
            compareOp=COMPARISONS.index(source.compare or "lequal"),
        ))  # fmt: skip

    def attachment(self, source: Output, kind: str) -> DeviceTexels:
        image = textures.find_image(source, self.images)
        target = self.targets[source.pass_name]
        if kind == "2DMS":
            return self._fetch_samples(source, image, target)
        if source.name not in target.colors and target.samples > 1:
            raise UnsupportedError(f"sampling the {source.name} of this target", remedy=UNREADABLE)
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

    def _fetch_samples(self, source: Output, image: Image, target: RenderTarget) -> DeviceTexels:
        view = new_view(self._resources, target.drawn[source.name], sampled=True)
        numbers = range(target.samples)
        each = [fetch_texels(self.linker, view, "2DMS", n, target.size, "rgba32f") for n in numbers]
        channels = textures.format_of(image.format).components
        return DeviceTexels(source, view, image.format, np.stack(each)[..., :channels])

    def upload(self, source: TextureSource) -> DeviceTexels:
        assert not isinstance(source, Output)
        if isinstance(source, CompressedTexture):
            return self._upload_compressed(source)
        kind = textures.texture_kind(source, "", 0)
        images = textures.texture_contents(source, self.folder, self.images)
        height, width = images.layers[0].shape[:2]
        format = choose_format(self._device, source.format, "sampled_image")
        given = [np.stack(images.layers), *(level[None] for level in images.smaller)]
        made = self._image(
            format,
            (width, height),
            kind=kind,
            layers=len(images.layers),
            mipmaps=source.mipmaps is True,
            levels=len(given),
        )
        write(self._device, made, given)
        values, smaller = images.layers[0], tuple(images.smaller)
        if kind != "2D" or format in textures.DEPTH:
            # A depth is rounded to its format's codes on the way.
            values = self._read(made, 0)
        if source.mipmaps is True:
            generate_levels(self._device, made)
        if source.mipmaps is True or (smaller and format in textures.DEPTH):
            smaller = self._smaller(made)
        return DeviceTexels(source, self._view(made), format, values, smaller)

    def _upload_compressed(self, source: CompressedTexture) -> DeviceTexels:
        blocks = textures.load_blocks(source, self.folder)
        choose_format(self._device, blocks.format, "sampled_image")
        sizes = level_sizes(*blocks.size)[: len(blocks.levels)]
        uses = ("sampled", "transfer_dst")
        made = new_image(self._resources, blocks.format, blocks.size, *uses, levels=len(sizes))
        write(self._device, made, blocks.levels)
        view = self._view(made)
        first, *smaller = (
            fetch_texels(self.linker, view, "2D", level, size, "rgba8")
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
            choose_format(
                self._device, format, "blit_src", "blit_dst", "sampled_image_filter_linear"
            )
        return new_image(
            self._resources, format, size, *USES, kind=kind, layers=layers, levels=count
        )

    def _view(self, image: DeviceImage) -> Any:
        return new_view(self._resources, image, sampled=True)

    def _read(self, image: DeviceImage, level: int) -> Array:
        found = read(self._device, image, level)
        return found[0] if image.kind == "2D" else found

    def _smaller(self, image: DeviceImage, channels: int = 4) -> tuple[Array, ...]:
        """Return the levels below the first, as the device has them."""
        levels = range(1, image.levels)
        return tuple(self._read(image, level)[..., :channels] for level in levels)


_NOT_SEAMLESS = constant("SAMPLER_CREATE_NON_SEAMLESS_CUBE_MAP_BIT_EXT")
_BORDERS = {
    (0.0, 0.0, 0.0, 0.0): constant("BORDER_COLOR_FLOAT_TRANSPARENT_BLACK"),
    (0.0, 0.0, 0.0, 1.0): constant("BORDER_COLOR_FLOAT_OPAQUE_BLACK"),
    (1.0, 1.0, 1.0, 1.0): constant("BORDER_COLOR_FLOAT_OPAQUE_WHITE"),
}
_CUSTOM_BORDER = constant("BORDER_COLOR_FLOAT_CUSTOM_EXT")
# A texture without mipmaps has no level but the first; up to here its filters are told apart by
# the level of detail, as the specification recommends for OpenGL's two filters without mipmaps.
_ONE_LEVEL = 0.25


_FETCH = """#version 330 core
uniform sampler{kind} texels;
uniform int number;
out vec4 color;
void main() {{ color = texelFetch(texels, ivec2(gl_FragCoord.xy), number); }}
"""


def fetch_texels(
    linker: Linker, view: Any, kind: str, number: int, size: tuple[int, int], word: str
) -> Array:
    """Read the sample ("2DMS") or the level ("2D") of this number of a float or normalised texture,
    of (width, height) texels, in the format `word`: (height, width, channels)."""
    program = linker.link({"vertex": COVERING, "fragment": _FETCH.format(kind=kind)})
    with (
        Resources(linker.device) as own,
        RenderTarget(linker.device, Target(), {"color": word}, size) as target,
    ):
        sampler = own.create("Sampler", Structs()("SamplerCreateInfo", maxLod=1000.0))
        buffer = own.buffer("uniform_buffer", number.to_bytes(16, "little"))
        images = {"texels": BoundImage(view, sampler)}
        draw_covering(own, program, target, {DEFAULT_BLOCK: buffer.handle}, images)
        return target.read("color").values


def draw_covering(
    own: Resources,
    program: Program,
    target: RenderTarget,
    buffers: Mapping[str, Any],
    images: Mapping[str, BoundImage],
) -> None:
    """Draw one triangle over a whole target; `buffers` and `images` as for `new_set`."""
    locations = program.locations(target.colors)
    layout = Layout(VertexLayout(), tuple(target.formats(locations).items()), "", 1, State())
    bound = new_set(own, program.set_layout, program.bindings, buffers, images)
    vertices = VertexBuffers((), None, 3)
    with recording(own.device) as commands:
        Ready(program, layout, locations, State(), vertices, 1, bound).record(commands, target)
