"""One lookup in a texture, whatever is known of the place: where a band reaches over more texels
than `shaderlab.glslmath.sampling` takes, the answer is any texel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band, Integer, Rules, TriBool
from shaderlab.compiler.spirv import Decoration, Op
from shaderlab.errors import FormulaError
from shaderlab.glslmath import sampling
from shaderlab.glslmath.sampling import Sampler
from shaderlab.glslmath.sampling.functions import COORDINATES, compute_level, sample
from shaderlab.glslmath.sampling.reading import (
    ROUNDING,
    WEIGHT,
    Span,
    component as bounds_of,
    fetch,
    level_values,
    map_span,
    to_span,
)
from shaderlab.model.frame import Array, Texels

from .operations import Handler, derivative
from .program import Instruction, Type
from .values import Flags, PathState, component, compose, format_place, select, undefined

if TYPE_CHECKING:
    from .running import Run

_CODE = 1.0 / 255.0
# Half a code off (Direct3D 11.3, functional specification, 3.2.3.7), where the curve is steepest.
_SRGB = 0.5 * _CODE * 2.4 / 1.055
_NARROW = 1.0 - 4.0 * WEIGHT  # of a place or a level, in texels or levels


@dataclass(frozen=True)
class Lookup:
    """A sampled texture, the coordinates (then the value to compare), the level of detail or None,
    where that is unknown, and the offset in texels."""

    sampler: Sampler
    place: Any
    level: Span | None
    unknown: Any
    offset: tuple[int, int]


def sample_texture(run: Run, lookup: Lookup, mask: Flags) -> Any:
    """The texture function's value for the invocations of a mask; others may be anywhere."""
    lookup, give = _decode(lookup)
    rules = lookup.sampler.rules
    if rules is None:
        return run.arithmetic.rounded(_sample_rows(lookup, mask))
    ignored = np.zeros(1, np.bool_) if mask.all() else ~mask
    wide = ignored | _find_wide(lookup)
    found = run.arithmetic.rounded(_sample_here(run, lookup, wide))
    if not isinstance(found, Band):
        return found
    if give:
        found = Band.between(found.lo - give, found.hi + give, rules)
    unsure = wide & ~ignored
    if unsure.any():
        found = select(TriBool(unsure[:, None], ~unsure[:, None]), _any_texel(lookup, rules), found)
    if lookup.unknown is not None and lookup.unknown.any():
        found = found.derive(found.lo, found.hi, anything=lookup.unknown[:, None])
    return found


def _decode(lookup: Lookup) -> tuple[Lookup, float]:
    """The lookup in linear texels, and what OpenGL leaves open about them besides: how precisely
    texels of 8 bits are filtered (llvmpipe does that in 8 bits, too), and sRGB decoded."""
    texels = lookup.sampler.texels
    if texels.values.dtype != np.uint8:
        return lookup, 0.0
    give = _CODE if any("linear" in word for word in texels.filter) else 0.0
    if not texels.format.startswith("srgb"):
        return lookup, give
    values, *smaller = map(_to_linear, (texels.values, *texels.smaller))
    linear = replace(texels, values=values, smaller=tuple(smaller), format="rgba32f")
    return replace(lookup, sampler=replace(lookup.sampler, texels=linear)), give + _SRGB


def _to_linear(codes: Any) -> Any:
    """sRGB codes as linear values; alpha is linear (OpenGL 4.5, §8.24)."""
    c = codes / 255.0
    decoded = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    decoded[..., 3:] = c[..., 3:]
    return decoded.astype(np.float32)


def _sample_rows(lookup: Lookup, mask: Flags) -> Any:
    """The sample of numbers, looked up for the invocations of a mask alone."""
    place, level = lookup.place, lookup.level
    rows = np.flatnonzero(mask)
    if len(place) < len(mask) or len(rows) == len(mask):
        return sample(lookup.sampler, place, level, lookup.offset)
    if level is not None:
        level = map_span(lambda end: end[rows] if len(end) > 1 else end, level)
    found = sample(lookup.sampler, place[rows], level, lookup.offset)
    return found[np.maximum(np.cumsum(mask) - 1, 0)]


def _sample_here(run: Run, lookup: Lookup, elsewhere: Flags) -> Any:
    """The sample, taken in the middle for the invocations that are left out."""
    place, level = lookup.place, lookup.level
    if elsewhere.any():
        out = elsewhere[:, None]
        middle = run.arithmetic.exact(np.full((1, place.shape[-1]), 0.25))
        place = select(TriBool(out, ~out), middle, place)
        if level is not None:
            zeroed = np.where(elsewhere, 0.0, level[0])
            same = level[0] is level[1]
            level = (zeroed, zeroed if same else np.where(elsewhere, 0.0, level[1]))
    return sample(lookup.sampler, place, level, lookup.offset)


def _find_wide(lookup: Lookup) -> Flags:
    """Which places or levels are known to less than a texel or a level."""
    low, high = to_span(lookup.place)
    texels = lookup.sampler.texels
    with np.errstate(all="ignore"):
        if texels.kind == "Cube":
            # A component of a unit vector moves the place on a face by half of its size, or more.
            size = level_values(lookup.sampler, 0).shape[1]
            largest = np.maximum(np.abs(low), np.abs(high))[..., :3].max(axis=-1)
            moved = (high - low)[..., :3].max(axis=-1) / largest * size
            wide = ~(moved < _NARROW)
        else:
            depth, height, width, _ = level_values(lookup.sampler, 0).shape
            size = (width, height, depth) if texels.kind == "3D" else (width, height)
            moved = (high - low)[..., : len(size)] * np.array(size)
            wide = ~(moved < _NARROW).all(axis=-1)
        if texels.compare is not None:
            wide = wide | ~np.isfinite(low).all(axis=-1) | ~np.isfinite(high).all(axis=-1)
        if lookup.level is not None:
            # Levels beyond the first and the last one are those.
            ends = (np.clip(end, *texels.lod) for end in lookup.level)
            first, last = (np.clip(end, 0.0, len(texels.smaller)) for end in ends)
            wide = wide | ~(last - first < _NARROW)
    return np.asarray(wide)


def _any_texel(lookup: Lookup, rules: Rules) -> Band:
    """Any mix of the texture's texels, (1, 4); of a shadow sampler any answer, (1, 1)."""
    sampler = lookup.sampler
    if sampler.texels.compare is not None:
        return Band.between([[0.0]], [[1.0]], rules)
    border = np.asarray(sampler.texels.border, np.float64)
    lows, highs = [border], [border]
    for level in range(1 + len(sampler.texels.smaller)):
        layers, height, width, _ = level_values(sampler, level).shape
        layer, y, x = (axis.ravel() for axis in np.indices((layers, height, width)))
        low, high = fetch(sampler, level, x, y, layer)
        lows.append(low.min(axis=0))
        highs.append(high.max(axis=0))
    low, high = np.minimum.reduce(lows), np.maximum.reduce(highs)
    give = ROUNDING * np.maximum(np.abs(low), np.abs(high))
    return Band.between((low - give)[None], (high + give)[None], rules)


_BIAS, _LOD, _GRAD, _CONST_OFFSET, _OFFSET, _OFFSETS, _SAMPLE = (1 << i for i in range(7))
_SIZES = {_BIAS: 1, _LOD: 1, _GRAD: 2, _CONST_OFFSET: 1, _OFFSET: 1, _OFFSETS: 1, _SAMPLE: 1}
_FRAGMENT = "fragment"


def _image_operands(run: Run, words: tuple[int, ...]) -> dict[int, list[Any]]:
    """The optional operands, by the bit that announces them."""
    if not words:
        return {}
    bits, ids = words[0], list(words[1:])
    found = {}
    for bit, size in _SIZES.items():
        if bits & bit:
            found[bit] = run.values(tuple(ids[:size]))
            ids = ids[size:]
    if ids:
        raise FormulaError(f"a texture function with SPIR-V's image operands {bits:#x}")
    return found


ROWS = {"1D": "2D", "1DArray": "2DArray", "Buffer": "2D"}  # read as planes that are 1 texel high
_COORDINATES = {**COORDINATES, "1D": 1, "1DArray": 2, "CubeArray": 4}


def _sample(*, compared: bool = False, projected: bool = False) -> Handler:
    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        texels: Texels = run.value(at.operands[0])
        p = run.value(at.operands[1])
        size = _COORDINATES[texels.kind]
        place = p if p.shape[-1] == size else p[..., :size]
        last = [run.value(at.operands[2])] if compared else []
        if projected:
            place, *last = (
                run.arithmetic.call("divide", v, component(p, size)) for v in (place, *last)
            )
        rest = _image_operands(run, at.operands[2 + compared :])
        layer = component(place, 3) if texels.kind == "CubeArray" else None
        if texels.kind in ROWS:
            x, *layers = (component(place, i) for i in range(size))
            place = _join([x, run.arithmetic.literal(0.5), *layers])
            texels = replace(texels, kind=ROWS[texels.kind])
        elif layer is not None:
            place = place[..., :3]

        def look(texels: Texels) -> Any:
            sampler = Sampler(texels, run.arithmetic.rules)
            level, unknown = _level(run, sampler, place, rest)
            lookup = Lookup(sampler, _join([place, *last]), level, unknown, _offset(rest))
            return sample_texture(run, lookup, state.mask)

        return look(texels) if layer is None else _look_up_cubes(look, texels, layer)

    return handler


def _look_up_cubes(look: Callable[[Texels], Any], texels: Texels, layer: Any) -> Any:
    """What is looked up in the cube of an array that is nearest to a number."""
    cubes = np.split(texels.values, len(texels.values) // 6)
    last = len(cubes) - 1
    low, high = (np.clip(np.floor(end + 0.5), 0, last) for end in to_span(layer))
    found = None
    for i, values in enumerate(cubes):
        own = look(replace(texels, kind="Cube", values=values))
        here = TriBool((low == i) & (high == i), (high < i) | (low > i))
        found = own if found is None else select(here, own, found)
    return found


def _join(parts: list[Any]) -> Any:
    """Floats one after the other, as a vector."""
    return compose(Type("vector", Type("float")), parts)


def _level(
    run: Run, sampler: Sampler, place: Any, rest: Mapping[int, list[Any]]
) -> tuple[Span | None, Any]:
    """The level of detail, None where nothing depends on it; and where it is unknown."""
    texels = sampler.texels
    if _LOD in rest:
        return bounds_of(to_span(rest[_LOD][0]), 0), None
    if texels.filter[0] == texels.filter[1]:
        return None, None
    if _GRAD in rest:
        dx, dy = rest[_GRAD]
    elif run.program.stage != _FRAGMENT:
        nothing = np.zeros(1)
        return (nothing, nothing), None
    else:
        plane = place[..., :2] if texels.kind == "2DArray" else place
        dx, dy = (derivative(run, name, plane) for name in ("dFdx", "dFdy"))
    if texels.kind == "Cube" and sampler.rules is None:
        dx, dy = (_move_on_face(place, d) for d in (dx, dy))
        sampler = Sampler(replace(texels, kind="2D"))
    low, high = compute_level(sampler, dx, dy)
    unknown = np.isnan(low) | np.isnan(high)
    for d in (dx, dy):
        if isinstance(d, Band):
            unknown = unknown | d.vacuous.any(axis=-1)
    if _BIAS in rest:
        bias = bounds_of(to_span(rest[_BIAS][0]), 0)
        low, high = low + bias[0], high + bias[1]
    same = low is high
    low = np.where(unknown, 0.0, low)
    return (low, low if same else np.where(unknown, 0.0, high)), unknown


def _move_on_face(place: Array, moved: Array) -> Array:
    """How far directions move on their cube's face, which is 1 wide, as they change by `moved`."""
    *minor, axis = np.moveaxis(np.argsort(np.abs(place), axis=-1), -1, 0)
    p, d = (
        np.broadcast_to(v, np.broadcast_shapes(place.shape, moved.shape)) for v in (place, moved)
    )
    major, turn = (np.take_along_axis(v, axis[..., None], -1) for v in (p, d))
    across: Array = 0.5 * (d * major - p * turn) / (major * major)
    return np.asarray(np.take_along_axis(across, np.stack(minor, axis=-1), -1))


def _offset(rest: Mapping[int, list[Any]]) -> tuple[int, int]:
    for bit in (_CONST_OFFSET, _OFFSET):
        if bit in rest:
            whole: Integer = rest[bit][0]
            if whole.shape[0] != 1:
                raise FormulaError("a texture function with an offset that differs")
            return int(whole.lo[0, 0]), int(whole.lo[0, 1:2].sum())  # a row's has one number
    return 0, 0


def fetch_place(run: Run, at: Instruction) -> tuple[Texels, Array, Array, Integer, Array]:
    """What a texelFetch reads: the texture, the ends of its coordinates, the level or the sample,
    and what the coordinates lie below in each of these."""
    texels: Texels = run.value(at.operands[0])
    place: Integer = run.value(at.operands[1])
    rest = _image_operands(run, at.operands[2:])
    number: Integer = rest.get(_SAMPLE, rest.get(_LOD, [Integer([[0]])]))[0]
    low, high = place.lo, place.hi
    if texels.kind in ROWS:
        low, high = (np.insert(end, 1, 0, axis=-1) for end in (low, high))
        texels = replace(texels, kind=ROWS[texels.kind])
    offset = np.zeros(low.shape[-1], np.int64)
    offset[:2] = _offset(rest)
    levels = [0] * len(texels.values) if texels.kind == "2DMS" else range(1 + len(texels.smaller))
    sizes = np.stack([sampling.textureSize(Sampler(texels), level).lo for level in levels])
    return texels, low + offset, high + offset, number, sizes


def _fetch(run: Run, at: Instruction, state: PathState) -> Any:
    texels, low, high, number, sizes = fetch_place(run, at)
    levels = np.clip(number.lo[:, 0], 0, len(sizes) - 1)
    inside = np.clip(low, 0, sizes[levels] - 1)
    absent = (number.lo[:, 0] != levels) | (number.hi[:, 0] != levels)
    if len(absent) < run.count and absent.all():
        raise FormulaError(f"texelFetch of level {number.lo[0, 0]}, which is not there")
    outside = absent | (low != high).any(axis=-1) | (inside != low).any(axis=-1)
    found: Any = None
    sampler = Sampler(texels, run.arithmetic.rules)
    for level in np.unique(levels):
        own = sampling.texelFetch(sampler, np.minimum(inside, sizes[level] - 1), level)
        found = own if found is None else select(TriBool.of((levels == level)[:, None]), own, found)
    if not (outside & state.mask).any():
        return run.arithmetic.rounded(found)
    # What lies outside is undefined; a robust device returns 0.
    if isinstance(found, Band):
        return found.derive(found.lo, found.hi, anything=outside[:, None])
    if isinstance(found, Integer):
        return found.derive(found.lo, anything=outside[:, None])
    return run.arithmetic.rounded(np.where(outside[:, None], 0.0, found))


def _read_image(run: Run, at: Instruction, state: PathState) -> Any:
    """A texel of an image that nothing was stored in: what others store is not known here."""
    if run.for_ranges:
        return undefined(run.program.types[at.type], run.arithmetic)
    name = _image_name(run, at)
    if name in run.stale or any((one[0] & state.mask).any() for one in run.texels.get(name, ())):
        raise FormulaError(f"imageLoad of {name}, in which texels are stored before,")
    image, place = run.values(at.operands[:2])
    return run.arithmetic.rounded(sampling.imageLoad(Sampler(image, run.arithmetic.rules), place))


def _write_image(run: Run, at: Instruction, state: PathState) -> None:
    """Keep an invocation's store beside its others, wherever it lies."""
    name, (place, value) = _image_name(run, at), run.values(at.operands[1:3])
    value = value[..., : run.value(at.operands[0]).values.shape[-1]]
    run.trace_stored(at, name, value, state)
    kept, mask = run.texels.setdefault(name, []), state.mask
    here = TriBool.of(mask[:, None])
    number = next((n for n in range(len(kept), 0, -1) if (kept[n - 1][0] & mask).any()), 0)
    if number == len(kept):
        zero: Any = np.zeros((1, value.shape[-1]))
        zero = value.derive(zero) if isinstance(value, Integer) else run.arithmetic.exact(zero)
        kept.append((np.zeros_like(mask), place.derive(0 * place.lo), zero))
    before, *old = kept[number]
    place, value = (select(here, *pair) for pair in zip((place, value), old, strict=True))
    kept[number] = before | mask, place, value


def _image_name(run: Run, at: Instruction) -> str:
    """The image that an instruction reads or writes, as GLSL writes it."""
    pointer = run.value(run.program.definitions[at.operands[0]].operands[0])
    type_, _ = run.program.variables[pointer.variable]
    return format_place(run.program.name(pointer.variable), type_, pointer.path)


def is_read_only(run: Run, at: Instruction) -> bool:
    """Whether an instruction reads an image to which nothing is stored."""
    pointer = run.value(run.program.definitions[at.operands[0]].operands[0])
    return run.program.module.decorated(pointer.variable, Decoration.NonWritable) is not None


def _gather(*, compared: bool) -> Handler:
    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        texels: Texels = run.value(at.operands[0])
        p, last = run.values(at.operands[1:3])
        rest = _image_operands(run, at.operands[3:])
        if not state.mask.all() and p.shape[0] > 1:
            middle = run.arithmetic.exact(np.full((1, p.shape[-1]), 0.25))
            p = select(TriBool.of(state.mask[:, None]), p, middle)
        sampler = Sampler(texels, run.arithmetic.rules)
        part = 0 if compared else int(last.lo.flat[0])
        place = _join([p[..., :2], last]) if compared else p
        if _OFFSETS in rest:
            offsets = [tuple(map(int, part.lo[0])) for part in rest[_OFFSETS][0]]
            found = sampling.textureGatherOffsets(sampler, place, offsets, part)  # type: ignore[arg-type]
        else:
            found = sampling.textureGatherOffset(sampler, place, _offset(rest), part)
        return run.arithmetic.rounded(found)

    return handler


def _size(run: Run, at: Instruction, state: PathState) -> Any:
    texels: Texels = run.value(at.operands[0])
    level = run.value(at.operands[1]).lo if len(at.operands) > 1 else np.zeros((1, 1), np.int64)
    most, sampler = len(texels.smaller), Sampler(texels, run.arithmetic.rules)
    sizes = np.stack([sampling.textureSize(sampler, n).lo for n in range(most + 1)])
    if texels.kind in ("1DArray", "CubeArray"):
        layers = len(texels.values) // (6 if texels.kind == "CubeArray" else 1)
        sizes = np.insert(sizes, 2, layers, axis=-1)
    if texels.kind in ROWS:
        sizes = np.delete(sizes, 1, axis=-1)
    found = Integer(sizes[np.clip(level, 0, most)[:, 0]], rules=run.arithmetic.rules)
    # That of a level which is not there is undefined (OpenGL 4.6, 11.1.3.4).
    outside = (level < 0) | (level > most)
    return (
        found.derive(found.lo, anything=outside) if (outside & state.mask[:, None]).any() else found
    )


def _levels(run: Run, at: Instruction, state: PathState) -> Any:
    count = sampling.textureQueryLevels(Sampler(run.value(at.operands[0])))
    return Integer([[count]], rules=run.arithmetic.rules)


def _samples(run: Run, at: Instruction, state: PathState) -> Any:
    found = sampling.textureSamples(Sampler(run.value(at.operands[0])))
    return Integer(np.reshape(found.lo, (1, 1)), rules=run.arithmetic.rules)


def _query_lod(run: Run, at: Instruction, state: PathState) -> Any:
    texels, place = run.values(at.operands)
    if run.places is None:
        raise FormulaError("textureQueryLod without gl_FragCoord of each pixel")
    sampler = Sampler(texels, run.arithmetic.rules)
    return run.arithmetic.rounded(sampling.textureQueryLod(sampler, place, run.places))


def _image(run: Run, at: Instruction, state: PathState) -> Any:
    """A sampler's image, or an image with a sampler: the texture is all there is here."""
    return run.value(at.operands[0])


LOOKUPS: Mapping[int, Handler] = {
    **{
        Op[f"ImageSample{proj}{dref}{level}Lod"]: _sample(compared=bool(dref), projected=bool(proj))
        for proj in ("", "Proj")
        for dref in ("", "Dref")
        for level in ("Implicit", "Explicit")
    },
    Op.ImageFetch: _fetch,
    Op.ImageGather: _gather(compared=False),
    Op.ImageDrefGather: _gather(compared=True),
    Op.ImageQuerySizeLod: _size,
    Op.ImageQuerySize: _size,
    Op.ImageQueryLod: _query_lod,
    Op.ImageQueryLevels: _levels,
    Op.ImageQuerySamples: _samples,
}


def _look_up(handler: Handler) -> Handler:
    """A handler that for ranges looks nothing up: who watches the run knows what may be there."""

    def any_value(run: Run, at: Instruction, state: PathState) -> Any:
        if run.for_ranges:
            return undefined(run.program.types[at.type], run.arithmetic)
        return handler(run, at, state)

    return any_value


TEXTURES: Mapping[int, Handler] = {
    Op.SampledImage: _image,
    Op.Image: _image,
    Op.ImageRead: _read_image,
    Op.ImageWrite: _write_image,
    **{op: _look_up(handler) for op, handler in LOOKUPS.items()},
}
