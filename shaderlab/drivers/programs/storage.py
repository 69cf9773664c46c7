"""What compute shaders read and write: storage blocks and images before a dispatch, their bytes,
and what is left in them.

Members lie where glslang puts them, by the rules of the layout that the shader names (std140,
std430). Layers of an image2DArray or image3D lie above each other in an output, the first lowest.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block, Interface, Member, Variable
from shaderlab.errors import CaseError, UnsupportedError
from shaderlab.model.frame import Array, Bindings, Fragments, Image, Texels
from shaderlab.model.scene import BufferValue, Draw
from shaderlab.model.textures import COLOR_FORMATS, ImageValue, Output

from . import bind, textures
from .textures import Images, find_image, format_of, pixel_values

INVOCATION = "gl_GlobalInvocationID"


@dataclass(frozen=True, kw_only=True)
class Slot:
    """A member of a storage block. Its name is what cases call it: GLSL's, with the block's before
    it where two blocks share one; of an array of structs of run-time length "particles.position".
    """

    name: str
    block: str
    member: Member

    @property
    def variable(self) -> Variable:
        """What it is; `array` is 0 for one of run-time length."""
        array = 0 if self.member.record_stride else self.member.array
        return Variable(name=self.name, type=self.member.type, array=array)

    @property
    def stride(self) -> int:
        """Bytes from one element to the next."""
        return self.member.record_stride or self.member.array_stride


def storage_blocks(interface: Interface) -> dict[str, Block]:
    return {name: block for name, block in interface.blocks.items() if block.kind == "storage"}


def find_slots(interface: Interface) -> dict[str, Slot]:
    """The members of all storage blocks by the names that cases have for them."""
    found = [
        (name, _name(member), member)
        for name, block in storage_blocks(interface).items()
        for member in block.members.values()
    ]
    names = [*(own for _, own, _ in found), *image_variables(interface)]
    slots = {}
    for block, own, member in found:
        name = own if names.count(own) == 1 else f"{block}.{own}"
        slots[name] = Slot(name=name, block=block, member=member)
    return slots


def _name(member: Member) -> str:
    """A member's name; of an array of structs of run-time length without the first one's index."""
    return member.name.replace("[0]", "", 1) if member.record_stride else member.name


def find_outputs(interface: Interface) -> dict[str, Variable]:
    """The images and the members of blocks that a program may write, by name."""
    known = find_slots(interface).values()
    members = {slot.name: slot.variable for slot in known if not slot.member.readonly}
    images = {n: image for n, image in image_variables(interface).items() if not image.readonly}
    texels = {n: Variable(name=n, type=_texel_type(image)) for n, image in images.items()}
    return {**texels, **members}


def bind_storage(
    draw: Draw, interface: Interface, bindings: Bindings, folder: Path, images: Images
) -> Bindings:
    """Return a dispatch's bindings with what its storage blocks and its images hold before. Raises
    CaseError: what is given for a member or an image is missing, unknown, or of the wrong type or
    shape; AssetError: an image file can't be read."""
    known = find_slots(interface)
    bind.compare("buffer", draw, draw.buffers, {n: s.variable for n, s in known.items()})
    exact, decimal = {}, {}
    for name, value in draw.buffers.items():
        exact[name], decimal[name] = _values(known[name], value, images)
    for block in storage_blocks(interface):
        lengths = {
            name: len(exact[name])
            for name, slot in known.items()
            if slot.block == block and slot.member.record_stride
        }
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{count} for {name}" for name, count in lengths.items())
            raise CaseError(
                f"{draw.compute}: one array of structs has one length, but there are {listed}"
            )
    arrays = {name for name, slot in known.items() if slot.variable.array is not None}
    return replace(
        bindings,
        buffers=exact,
        images=_image_contents(draw, interface, folder, images),
        decimal={**bindings.decimal, **decimal},
        arrays=bindings.arrays | arrays,
    )


def require_supported(draw: Draw, interface: Interface) -> None:
    """Check that the lab can give a compute shader what it declares, and read what it writes.
    Raises UnsupportedError: it can't; names what is declared; CaseError: the shader writes
    nothing."""
    for what, remedy in _find_unsupported(interface):
        raise UnsupportedError(f"{draw.compute}: {what}", remedy=remedy)
    if not find_outputs(interface):
        raise CaseError(
            f"{draw.compute} writes to no storage block and no image, so nothing could be checked"
        )


def _find_unsupported(interface: Interface) -> Iterator[tuple[str, str | None]]:
    """Yield what is declared that the lab can't give to a compute shader, with remedies."""
    for name, variable in interface.uniforms.items():
        if variable.type == "atomic_uint":
            remedy = "declare a uint in a buffer block instead, or an r32ui image"
            yield f"{name} is an atomic_uint", remedy
    for name, image in image_variables(interface).items():
        if _image_kind(image) not in KINDS:
            known = ", ".join(f"image{kind}" for kind in KINDS)
            yield f"{name} is an {image.type}; compute passes have {known}", None
        if image.array is not None:
            yield f"{name} is an array of images", f"declare {image.array} of them"
        if _image_format(image) not in FORMATS:
            remedy = f"compute passes have {', '.join(FORMATS)}"
            yield f"{name} has the format {_image_format(image)}", remedy
    for name, block in storage_blocks(interface).items():
        if block.array is not None:
            yield f"{name} is an array of storage blocks", None
    for slot in find_slots(interface).values():
        member = slot.member
        if member.record_stride and member.array is not None:
            yield f"{slot.name} is an array in an array of run-time length", None
        known_type = member.type.endswith(("float", "int", "uint", "2", "3", "4"))
        if not known_type or member.type.startswith("d"):
            yield f"{slot.name} is {member.type}", None


def _values(slot: Slot, value: BufferValue, images: Images) -> tuple[Array, Array]:
    """What a member holds, as the shader gets it and as written, in the shapes of uniforms."""
    variable = slot.variable
    if isinstance(value, Output):
        value = _values_left(variable, find_image(value, images), value)
    if variable.array == 0:
        count = len(value) if isinstance(value, list | tuple) else (*np.shape(value), 0)[0]
        if not count:
            raise CaseError(f"buffer {slot.name!r} is {variable.type}[]: it takes an array")
        variable = replace(variable, array=count)
    return bind.convert_value(variable, value, "buffer")


def _values_left(variable: Variable, image: Image, source: Output) -> Array:
    """What an earlier pass left, in the shape that a member takes."""
    shape = textures.shape_of(variable.type)
    wanted, found = np.dtype(textures.numpy_type(variable.type)), image.values.dtype
    if image.values.shape[-1] != shape[0] or found != wanted:
        raise CaseError(
            f"buffer {variable.name!r} is {variable.type}, but {source.path} has "
            f"{image.values.shape[-1]} components of {found}"
        )
    if len(shape) == 2:  # a pixel for each column
        values = image.values.reshape(-1, shape[1], shape[0]).swapaxes(1, 2)
    else:
        values = image.values.reshape(-1, *shape)
    return values if variable.array is not None else values[0]


def pack_storage(
    block: Block, members: Mapping[str, Slot], values: Mapping[str, Array]
) -> bytearray:
    """Return a block's bytes, all gaps zero; `values` are as of `bind_storage`. An array of
    run-time length ends where its elements do, so that its `length()` is theirs.
    """
    open_ended = [n for n, s in members.items() if s.variable.array == 0]
    size = block.size
    if open_ended:
        start = min(members[name].member.offset for name in open_ended)
        size = start + len(values[open_ended[0]]) * members[open_ended[0]].stride
    data = bytearray(size)
    for name, slot in members.items():
        whole = values[name] if slot.variable.array is not None else values[name][None]
        bind.view_member(slot.member, data, len(whole))[...] = whole
    return data


def unpack_storage(slot: Slot, data: bytearray, like: Array) -> Array:
    """What a member holds in a block's bytes, in the shape of what it held before."""
    count = len(like) if slot.variable.array is not None else 1
    return bind.view_member(slot.member, data, count).reshape(like.shape).copy()


def member_image(slot: Slot, values: Array) -> Image:
    """A member as an image of one row: a pixel for each element, of a matrix for each column."""
    whole = values if slot.variable.array is not None else values[None]
    letter = {"i": "i", "u": "u"}.get(slot.member.type[0], "")
    if whole.ndim == 3:
        whole = whole.swapaxes(1, 2).reshape(-1, whole.shape[1])
    kind = f"{letter}vec{whole.shape[1]}" if whole.shape[1] > 1 else slot.member.type
    return Image(np.ascontiguousarray(whole[None]), textures.output_format(kind))


def capture_invocations(draw: Draw, interface: Interface, bindings: Bindings) -> Fragments:
    """What the invocations of a dispatch got: the contents of its storage blocks before, a pixel
    for each element, and the invocations' own numbers, x first: a column for each x, a row for each
    y, one z above the other."""
    local = interface.local_size or (1, 1, 1)
    sizes = [groups * size for groups, size in zip(draw.groups, local, strict=True)]
    z, y, x = np.indices(sizes[::-1], np.uint32).reshape(3, -1, sizes[0])
    inputs = {INVOCATION: np.stack([x, y, z], axis=-1)}
    for name, values in bindings.buffers.items():
        inputs[name] = values[None] if name in bindings.arrays else values[None, None]
    covered = np.ones(x.shape, bool)
    return Fragments(covered=covered, frag_coord=np.zeros((*x.shape, 4)), inputs=inputs)


KINDS = ("2D", "2DArray", "3D")
FORMATS = tuple(word for word in COLOR_FORMATS if not word.startswith("srgb"))
_NEAREST, _EDGE = ("nearest",) * 2, ("clamp_to_edge",) * 2


def image_variables(interface: Interface) -> dict[str, Variable]:
    return {name: v for name, v in interface.uniforms.items() if "image" in v.type}


def _image_kind(image: Variable) -> str:
    """What comes after "image" in its type: "2D", "2DArray" or "3D"."""
    return image.type.partition("image")[2]


def _image_format(image: Variable) -> str:
    """The format of its texels: its layout's, or where it has none (`writeonly`) the widest."""
    letter = image.type.partition("image")[0]
    return image.format or {"": "rgba32f", "i": "rgba32i", "u": "rgba32ui"}[letter]


def _image_contents(
    draw: Draw, interface: Interface, folder: Path, images: Images
) -> dict[str, Texels]:
    """Return what a dispatch's images hold before it. Raises CaseError: what is given for an image
    is missing, unknown, or does not fit it; AssetError: an image file can't be read."""
    known = image_variables(interface)
    bind.compare("image", draw, draw.images, known)
    return {
        name: Texels(
            _texels_given(draw, known[name], value, folder, images),
            _NEAREST,
            _EDGE,
            (0.0,) * 4,
            kind=_image_kind(known[name]),
            format=_image_format(known[name]),
        )
        for name, value in draw.images.items()
    }


def image_output(image: Texels) -> Image:
    """What an image holds as a pass's output: its layers one above the other."""
    values = image.values
    if image.kind == "2D":
        return Image(values, image.format)
    return Image(values.reshape(-1, *values.shape[2:]), image.format, layers=len(values))


def texel_places(image: Image) -> Array:
    """Where each texel of an output lies in its image, as imageStore has it: (height, width, 2) of
    column and row; or, with its layer, 3."""
    height, width = image.values.shape[:2]
    y, x = np.indices((height, width), np.int32)
    if not image.layers:
        return np.stack([x, y], axis=-1)
    rows = height // image.layers
    return np.stack([x, y % rows, y // rows], axis=-1)


def _texel_type(image: Variable) -> str:
    form = format_of(_image_format(image)) if _image_format(image) in FORMATS else None
    count = form.components if form else 4
    letter = image.type.partition("image")[0]
    return f"{letter}vec{count}" if count > 1 else {"": "float", "i": "int", "u": "uint"}[letter]


def _texels_given(
    draw: Draw, image: Variable, value: ImageValue, folder: Path, images: Images
) -> Array:
    """(height, width, components), or with the layers in front."""
    word, layered = _image_format(image), _image_kind(image) != "2D"
    form, owner = format_of(word), f"{draw.compute}: image {image.name!r}"
    if isinstance(value, Output):
        return _texels_left(image, find_image(value, images), value, owner)
    if not layered:
        return _require_exact(pixel_values(value, word, folder, owner), value, owner, word)
    given: Any = value() if callable(value) else value
    whole = given if isinstance(given, str | Path) else np.asanyarray(given)
    if isinstance(whole, np.ndarray) and whole.ndim == 3 and form.components == 1:
        whole = whole[..., None]
    if not isinstance(whole, np.ndarray) or whole.ndim != 4 or 0 in whole.shape:
        shape = f"not {whole.shape}" if isinstance(whole, np.ndarray) else "no file"
        raise CaseError(
            f"{owner} is an {image.type}: it takes an array (layers, height, width, "
            f"{form.components}), {shape}"
        )
    layers = [pixel_values(layer, word, folder, owner) for layer in whole]
    return _require_exact(np.stack(layers), whole[..., : form.components], owner, word)


def _require_exact(values: Array, given: Any, owner: str, word: str) -> Array:
    """The values, if an integer format holds what was given for them."""
    if values.dtype.kind in "iu" and isinstance(given, np.ndarray) and given.dtype != values.dtype:
        same = given.reshape(-1) == values.reshape(-1)[: given.size]
        if format_of(word).integer and given.size == values.size and not same.all():
            raise CaseError(f"{owner} is {word}, which holds not all of what is given for it")
    return values


def _texels_left(image: Variable, found: Image, source: Output, owner: str) -> Array:
    """What an earlier pass left, in the shape that an image takes."""
    word, layered = _image_format(image), _image_kind(image) != "2D"
    wanted, values = format_of(word), found.values
    fits = values.shape[-1] == wanted.components and values.dtype == np.dtype(wanted.numpy)
    if not fits or layered != bool(found.layers):
        layers = f" in {found.layers} layers" if found.layers else ""
        raise CaseError(
            f"{owner} is an {image.type} of {word}, but {source.path} has {values.shape[-1]} "
            f"components of {values.dtype}{layers}"
        )
    return values.reshape(found.layers, -1, *values.shape[1:]) if layered else values


def lay_out(values: Mapping[str, Array], image: Image) -> dict[str, Array]:
    """Those of some values that there is one of for each texel (or element) of an output, in the
    shape of that output: (height, width, components)."""
    height, width = image.values.shape[:2]
    return {
        name: v.reshape(height, width, *v.shape[2:])
        for name, v in values.items()
        if v.shape[:2] == (height, width)
        or (v.shape[0] * v.shape[1] == height * width and 1 in (v.shape[0], height))
    }
