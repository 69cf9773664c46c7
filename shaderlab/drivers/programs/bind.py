"""Fitting a draw's data to its program's interface: what is missing, surplus or the wrong shape.

Every value comes out twice: as the float32 (or integer) array that the shader will get, and as the
float64 numbers that the case wrote.
"""

from collections.abc import Callable, Iterable, Mapping
from operator import attrgetter
from typing import Any

import numpy as np

from shaderlab.compiler.reflection import Block, Interface, Member, Variable
from shaderlab.errors import CaseError, UnsupportedError, suggest
from shaderlab.model.frame import Array, Bindings, Texels
from shaderlab.model.scene import UNIT_SQUARE, Draw, Ramp, UniformBuffer
from shaderlab.model.textures import TextureSource

from .stages import PREFIX, VaryingPart, array_elements
from .textures import numpy_type, shape_of

Contents = Callable[[str, Variable, TextureSource], Texels]
"""Gives a texture's contents to a sampler of a program, once it has checked that they fit."""


def bind(draw: Draw, interface: Interface, texels: Contents) -> Bindings:
    """Return all uniforms, block members and textures of a draw, checked against what its program
    declares; `texels` gives a texture's contents. Raises CaseError: a uniform, a block's member or
    a texture is missing, unknown, or of the wrong type or shape; UnsupportedError: a program that
    draws has images."""
    for name in draw.uniforms:
        if name not in interface.uniforms:
            _refuse_member(draw, interface, name)
    samplers = {n: v for n, v in interface.uniforms.items() if "sampler" in v.type}
    uniforms = interface.uniforms.items()
    images = {n: v for n, v in uniforms if "image" in v.type}
    if images and not draw.compute:
        name, image = next(iter(images.items()))
        raise UnsupportedError(
            f"{' + '.join(draw.shaders)}: {name} is an {image.type}; compute passes alone have "
            "images",
            remedy="write an output, and read textures",
        )
    opaque = samplers.keys() | images.keys()
    plain = {n: v for n, v in uniforms if n not in opaque and not n.startswith(PREFIX)}
    compare("uniform", draw, draw.uniforms, plain, other={"texture": samplers, "image": images})
    compare("texture", draw, draw.textures, samplers, other={"uniform": plain, "image": images})
    known = find_declared_uniforms(interface)
    values = {**draw.uniforms, **_block_values(draw, interface)}
    exact, decimal = {}, {}
    for name, value in values.items():
        exact[name], decimal[name] = convert_value(known[name], value)
    return Bindings(
        uniforms=exact,
        decimal=decimal,
        textures={
            name: texels(" + ".join(draw.shaders), samplers[name], source)
            for name, source in draw.textures.items()
        },
        arrays=frozenset(n for n in values if known[n].array is not None),
    )


def find_declared_uniforms(interface: Interface) -> dict[str, Variable]:
    """Uniforms and members of uniform blocks by name."""
    return {**interface.uniforms, **block_members(interface)}


def convert_value(variable: Variable, value: Any, what: str = "uniform") -> tuple[Array, Array]:
    """A value as the shader gets it, and as written, both of one shape; errors call it `what`.

    Shapes: a number (1,), a vector (n,), a matrix (rows, columns); arrays have one more axis in
    front. Raises CaseError: `value` is not numeric, has another shape, or is out of range."""
    shape = shape_of(variable.type)
    if variable.array is not None:
        shape = (variable.array, *shape)
    try:
        decimal = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        raise CaseError(
            f"{what} {variable.name!r} ({variable.type}) is not numbers: {value!r}"
        ) from None
    if shape[-1:] == (1,) and decimal.shape == shape[:-1]:
        decimal = decimal[..., None]
    if decimal.shape != shape:
        raise CaseError(
            f"{what} {variable.name!r} is {_format_type(variable)}: it takes shape {shape}, "
            f"not {decimal.shape}"
        )
    kind = numpy_type(variable.type)
    with np.errstate(over="ignore", invalid="ignore"):
        exact = decimal.astype(kind)
    finite = np.isfinite(exact if exact.dtype.kind == "f" else decimal)
    if not finite.all() and (np.isnan(decimal).any() or (~finite & np.isfinite(decimal)).any()):
        raise CaseError(f"{what} {variable.name!r} holds {value!r}, which no {variable.type} does")
    if exact.dtype.kind in "iu" and (exact != decimal).any():
        integers = "no integer" if (decimal % 1).any() else f"beyond what {variable.type} holds"
        raise CaseError(f"{what} {variable.name!r} is {variable.type}, but {value!r} is {integers}")
    return exact, decimal


def check_attributes(draw: Draw, interface: Interface) -> None:
    """Compare a mesh's attributes with the vertex shader's inputs, by name and size. Raises
    CaseError: one is missing, not read by the shader, or has another number of components."""
    assert draw.mesh is not None
    compare(
        "attribute",
        draw,
        draw.mesh.inputs,
        interface.attributes,
        surplus="the vertex shader does not read it; pass mesh.only(…) with those it does read",
    )
    for name, variable in interface.attributes.items():
        have = draw.mesh.inputs[name].shape[1:]
        if have != shape_of(variable.type):
            given = f"{have[0]} components" if len(have) == 1 else f"{have[0]} × {have[1]} numbers"
            raise CaseError(f"attribute {name!r} is {variable.type}, but the mesh gives {given}")


def check_domain(draw: Draw, inputs: Mapping[str, Variable]) -> None:
    """Compare a domain's ramps with the fragment shader's inputs. Raises CaseError: an input has no
    ramp, or a ramp has no input."""
    compare("input", draw, _ramps(draw, inputs), inputs, place="domain")


def make_ramp_uniforms(draw: Draw, inputs: Mapping[str, Variable]) -> dict[str, Array]:
    """The uniforms of the generated domain stage, by name."""
    values: dict[str, Array] = {}
    for name, ramp in _ramps(draw, inputs).items():
        variable = inputs[name]
        size = shape_of(variable.type)
        integer = variable.type[0] in "iu"
        for part in ("origin",) if integer else ("origin", "dx", "dy"):
            given = np.asarray(getattr(ramp, part), np.float64)
            if part != "origin" and given.ndim == 0:
                given = np.broadcast_to(given, size)
            probe = Variable(name=f"{PREFIX}{name}_{part}", type=variable.type, location=None)
            values[probe.name] = convert_value(probe, given)[0]
    return values


def convert_inputs(
    variables: Mapping[str, Variable], values: Mapping[str, Any]
) -> dict[str, Array]:
    """Input values as arrays (1, components), matrices (1, rows, columns), of the shader's type."""
    known = {v.name: v for v in array_elements(variables.values())}
    own = {name: value for name, value in values.items() if name in known}
    return {name: convert_value(known[name], value)[0][None] for name, value in own.items()}


def complete_inputs(
    draw: Draw, varyings: Mapping[str, Variable], inputs: Mapping[str, Array]
) -> dict[str, Array]:
    """All fragment inputs of a draw, (count, components): those given, and for the others the value
    that the draw's domain has at the centre of the screen. Raises CaseError: an input has no value,
    or is none of the shader's."""
    variables = {v.name: v for v in array_elements(varyings.values())}
    count = max((len(v) for v in inputs.values()), default=1)
    for name in inputs:
        if name not in variables:
            raise CaseError(f"{draw.fragment} reads no {name!r}", remedy=suggest(name, variables))
    complete = {}
    for name, variable in variables.items():
        if name in inputs:
            value = inputs[name]
        elif draw.domain is None:
            raise CaseError(
                f"{draw.fragment} also reads {name!r} ({variable.type})",
                remedy=f"give it a value: at={{…, {name!r}: …}}",
            )
        else:
            ramp = draw.domain[name]
            origin, dx, dy = (np.asarray(v, np.float64) for v in (ramp.origin, ramp.dx, ramp.dy))
            value = np.atleast_1d(origin + 0.5 * dx + 0.5 * dy)[None]
        shaped = np.broadcast_to(value, (count, *shape_of(variable.type)))
        complete[name] = np.ascontiguousarray(shaped.astype(numpy_type(variable.type)))
    return complete


def select_part(values: Mapping[str, Array], piece: VaryingPart) -> Array:
    """The part of the inputs that goes into one attribute: a vector, or a matrix's column."""
    whole = values[piece.name]
    return np.ascontiguousarray(whole[..., int(piece.path[1:-1])]) if piece.path else whole


def _ramps(draw: Draw, inputs: Mapping[str, Variable]) -> Mapping[str, Ramp]:
    """The draw's domain; the default one may go unread."""
    domain = draw.domain or {}
    return {} if domain == UNIT_SQUARE and not inputs.keys() & domain.keys() else domain


def compare(
    what: str,
    draw: Draw,
    given: Iterable[str],
    declared: Mapping[str, Variable | Member | Block],
    *,
    other: Mapping[str, Mapping[str, Variable]] | None = None,
    surplus: str | None = None,
    place: str | None = None,
) -> None:
    """Compare what a draw gives, in `place`, with what its program declares; `what` is what these
    are called. Raises CaseError: something is missing or surplus."""
    program = " + ".join(draw.shaders)
    for name in given:
        if name in declared:
            continue
        for kind, names in (other or {}).items():
            if name in names:
                raise CaseError(f"{program}: {name!r} is a {kind}, given as a {what}")
        raise CaseError(
            f"{program}: there is no {what} {name!r}", remedy=surplus or suggest(name, declared)
        )
    missing = [name for name in declared if name not in given]
    if missing:
        listed = ", ".join(name + _format_type(declared[name], " ({})") for name in missing)
        raise CaseError(
            f"{program}: nothing is given for {what} {listed}",
            remedy=f"add it to the draw's {place or what + 's'}",
        )


def _format_type(declared: Variable | Member | Block, form: str = "{}") -> str:
    """Return a declared type, or "" for a block, which has none."""
    if isinstance(declared, Block):
        return ""
    array = "" if declared.array is None else f"[{declared.array}]"
    return form.format(f"{declared.type}{array}")


_PLACE = attrgetter("offset", "size", "array_stride", "matrix_stride")


def uniform_blocks(interface: Interface) -> dict[str, Block]:
    return {name: block for name, block in interface.blocks.items() if block.kind == "uniform"}


def member_name(block: Block, member: str) -> str:
    """A member's name as OpenGL's interface has it: with the block's name before it where the
    block has an instance name (OpenGL 4.5, §7.3.1), alone where it has none."""
    return f"{block.name}.{member}" if block.instance else member


def block_members(interface: Interface) -> dict[str, Variable]:
    """Each member of each uniform block, under the name that OpenGL has for it."""
    members = (
        (member_name(block, member.name), member)
        for block in uniform_blocks(interface).values()
        for member in block.members.values()
    )
    return {n: Variable(name=n, type=m.type, array=m.array, used=True) for n, m in members}


def _refuse_member(draw: Draw, interface: Interface, name: str) -> None:
    """Raise CaseError where a name that is given as a uniform is that of a block's member."""
    for block in uniform_blocks(interface).values():
        if name in (block.name, block.instance):
            raise CaseError(
                f"{' + '.join(draw.shaders)}: {name!r} is a uniform block, given as a uniform",
                remedy=f"blocks={{{block.name!r}: UniformBuffer(values={{…}})}}",
            )
        for member in block.members:
            if name in (member, f"{block.name}.{member}", f"{block.instance}.{member}"):
                raise CaseError(
                    f"{' + '.join(draw.shaders)}: {name!r} is a member of the uniform block "
                    f"{block.name}, given as a uniform",
                    remedy=f"blocks={{{block.name!r}: UniformBuffer(values={{{member!r}: …}})}}",
                )


def _block_values(draw: Draw, interface: Interface) -> dict[str, Any]:
    """The values that a draw gives for its blocks' members, by the names of `block_members`. Raises
    CaseError: a block or member is missing or unknown; UnsupportedError: an array of blocks."""
    blocks = uniform_blocks(interface)
    compare("uniform block", draw, draw.blocks, blocks, place="blocks")
    values: dict[str, Any] = {}
    for name, block in blocks.items():
        if block.array is not None:
            raise UnsupportedError(
                f"{' + '.join(draw.shaders)}: {name} is an array of uniform blocks",
                remedy="declare each block separately, or make its members arrays",
            )
        own = draw.blocks[name].values
        place = f"blocks[{name!r}].values"
        compare(f"{name} member", draw, own, block.members, place=place)
        values.update({member_name(block, member): value for member, value in own.items()})
    return values


class SharedLayouts:
    """The layouts of buffers that several programs share."""

    def __init__(self) -> None:
        self._first: dict[int, tuple[UniformBuffer, Block]] = {}

    def check(self, source: UniformBuffer, block: Block) -> None:
        """Raise CaseError where a buffer serves another block already, laid out differently."""
        _, first = self._first.setdefault(id(source), (source, block))
        ours, theirs = (
            {name: _PLACE(member) for name, member in one.members.items()} for one in (block, first)
        )
        for name in (*ours, *theirs):
            if ours.get(name) != theirs.get(name):
                raise CaseError(
                    f"one UniformBuffer serves the blocks {first.name} and {block.name}, "
                    f"but {name} does not lie at the same place in both",
                    remedy="declare both blocks alike, or give each a separate UniformBuffer",
                )


def pack_block(block: Block, uniforms: Mapping[str, Array]) -> bytes:
    """A block's bytes, all gaps zero; `uniforms` are its members' values as shaders get them."""
    data = bytearray(block.size)
    for member in block.members.values():
        values = uniforms[member_name(block, member.name)]
        whole = values if member.array is not None else values[None]
        view_member(member, data, len(whole))[...] = whole
    return bytes(data)


def view_member(member: Member, data: bytearray, count: int) -> Array:
    """A member's elements in a block's bytes: (count, components) or (count, rows, columns)."""
    kind = np.dtype(numpy_type(member.type))
    shape = (count, *shape_of(member.type))
    steps: tuple[int, ...] = (kind.itemsize,)
    if len(shape) == 3:  # a matrix is an array of its columns, or of its rows
        steps = (kind.itemsize, member.matrix_stride)
        steps = steps[::-1] if member.row_major else steps
    strides = (member.record_stride or member.array_stride, *steps)
    return np.ndarray(shape, kind, data, member.offset, strides)
