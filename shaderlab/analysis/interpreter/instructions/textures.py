"""Textures: sampled, fetched, gathered, asked for their size; by `shaderlab.glslmath.sampling`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.bands import Band, Integer, Truth
from shaderlab.errors import FormulaError
from shaderlab.glslmath import sampling
from shaderlab.glslmath.sampling import Sampler
from shaderlab.glslmath.sampling.functions import COORDINATES
from shaderlab.glslmath.sampling.lookups import level_of
from shaderlab.glslmath.sampling.spans import Span, component as bounds_of, span_of
from shaderlab.model.frame import Texels

from ..memory import World
from ..program import Instruction
from ..types import Type
from ..values import component, composed, select
from .derivatives import derivative
from .handler import Handler
from .lookup import Lookup, answer

if TYPE_CHECKING:
    from ..running import Run

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


def _sample(*, compared: bool = False, projected: bool = False) -> Handler:
    def handler(run: Run, at: Instruction, world: World) -> Any:
        texels: Texels = run.value(at.operands[0])
        p = run.value(at.operands[1])
        size = COORDINATES[texels.kind]
        place = p if p.shape[-1] == size else p[..., :size]
        last = [run.value(at.operands[2])] if compared else []
        if projected:
            place, *last = (
                run.arithmetic.call("divide", v, component(p, size)) for v in (place, *last)
            )
        rest = _image_operands(run, at.operands[2 + compared :])
        sampler = Sampler(texels, run.arithmetic.rules)
        level, unknown = _level(run, sampler, place, rest)
        lookup = Lookup(sampler, _joined([place, *last]), level, unknown, _offset(rest))
        return answer(run, lookup, world.mask)

    return handler


def _joined(parts: list[Any]) -> Any:
    """Floats one after the other, as a vector."""
    return composed(Type("vector", Type("float")), parts)


def _level(
    run: Run, sampler: Sampler, place: Any, rest: Mapping[int, list[Any]]
) -> tuple[Span | None, Any]:
    """The level of detail, None where nothing depends on it; and where it is unknown."""
    texels = sampler.texels
    if _LOD in rest:
        return bounds_of(span_of(rest[_LOD][0]), 0), None
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
    low, high = level_of(sampler, dx, dy)
    unknown = np.isnan(low) | np.isnan(high)
    for d in (dx, dy):
        if isinstance(d, Band):
            unknown = unknown | d.vacuous.any(axis=-1)
    if _BIAS in rest:
        bias = bounds_of(span_of(rest[_BIAS][0]), 0)
        low, high = low + bias[0], high + bias[1]
    same = low is high
    low = np.where(unknown, 0.0, low)
    return (low, low if same else np.where(unknown, 0.0, high)), unknown


def _offset(rest: Mapping[int, list[Any]]) -> tuple[int, int]:
    for bit in (_CONST_OFFSET, _OFFSET):
        if bit in rest:
            whole: Integer = rest[bit][0]
            if whole.shape[0] != 1:
                raise FormulaError("a texture function with an offset that differs")
            return int(whole.lo[0, 0]), int(whole.lo[0, 1])
    return 0, 0


def _fetch(run: Run, at: Instruction, world: World) -> Any:
    texels: Texels = run.value(at.operands[0])
    place: Integer = run.value(at.operands[1])
    rest = _image_operands(run, at.operands[2:])
    number = rest.get(_SAMPLE, rest.get(_LOD, [Integer(0)]))[0]
    if not number.known or (number.lo != number.lo.flat[0]).any():
        raise FormulaError("texelFetch of a level that differs")
    level = 0 if texels.kind == "2DMS" else int(number.lo.flat[0])
    if not 0 <= level <= len(texels.smaller):
        raise FormulaError(f"texelFetch of level {level}, which is not there")
    offset = np.zeros(place.shape[-1], np.int64)
    offset[:2] = _offset(rest)
    low, high = place.lo + offset, place.hi + offset
    most = sampling.textureSize(Sampler(texels), level).lo - 1
    wide = (low != high).any(axis=-1)
    outside = ((low < 0) | (low > most)).any(axis=-1) | wide
    inside = np.clip(low, 0, most)
    sampler = Sampler(texels, run.arithmetic.rules)
    found = sampling.texelFetch(sampler, inside, number.lo.flat[0])
    if not (outside & world.mask).any():
        return run.arithmetic.rounded(found)
    # What lies outside is undefined; a robust device gives 0.
    if isinstance(found, Band):
        return found.made(found.lo, found.hi, anything=outside[:, None])
    if isinstance(found, Integer):
        return found.made(found.lo, anything=outside[:, None])
    return run.arithmetic.rounded(np.where(outside[:, None], 0.0, found))


def _gather(*, compared: bool) -> Handler:
    def handler(run: Run, at: Instruction, world: World) -> Any:
        texels: Texels = run.value(at.operands[0])
        p, last = run.values(at.operands[1:3])
        rest = _image_operands(run, at.operands[3:])
        if not world.mask.all() and p.shape[0] > 1:
            middle = run.arithmetic.exact(np.full((1, p.shape[-1]), 0.25))
            p = select(Truth.known(world.mask[:, None]), p, middle)
        sampler = Sampler(texels, run.arithmetic.rules)
        part = 0 if compared else int(last.lo.flat[0])
        place = _joined([p[..., :2], last]) if compared else p
        if _OFFSETS in rest:
            offsets = [tuple(map(int, part.lo[0])) for part in rest[_OFFSETS][0]]
            found = sampling.textureGatherOffsets(sampler, place, offsets, part)  # type: ignore[arg-type]
        else:
            found = sampling.textureGatherOffset(sampler, place, _offset(rest), part)
        return run.arithmetic.rounded(found)

    return handler


def _size(run: Run, at: Instruction, world: World) -> Any:
    texels: Texels = run.value(at.operands[0])
    level = int(run.value(at.operands[1]).lo.flat[0]) if len(at.operands) > 1 else 0
    if not 0 <= level <= len(texels.smaller):
        raise FormulaError(f"textureSize of level {level}, which is not there")
    found = sampling.textureSize(Sampler(texels, run.arithmetic.rules), level)
    return Integer(found.lo[None], rules=run.arithmetic.rules)


def _levels(run: Run, at: Instruction, world: World) -> Any:
    count = sampling.textureQueryLevels(Sampler(run.value(at.operands[0])))
    return Integer([[count]], rules=run.arithmetic.rules)


def _samples(run: Run, at: Instruction, world: World) -> Any:
    found = sampling.textureSamples(Sampler(run.value(at.operands[0])))
    return Integer(np.reshape(found.lo, (1, 1)), rules=run.arithmetic.rules)


def _query_lod(run: Run, at: Instruction, world: World) -> Any:
    texels, place = run.values(at.operands)
    if run.places is None:
        raise FormulaError("textureQueryLod without gl_FragCoord of each pixel")
    sampler = Sampler(texels, run.arithmetic.rules)
    return run.arithmetic.rounded(sampling.textureQueryLod(sampler, place, run.places))


def _image(run: Run, at: Instruction, world: World) -> Any:
    """A sampler's image, or an image with a sampler: the texture is all there is here."""
    return run.value(at.operands[0])


TEXTURES: Mapping[int, Handler] = {
    86: _image,
    87: _sample(),
    88: _sample(),
    89: _sample(compared=True),
    90: _sample(compared=True),
    91: _sample(projected=True),
    92: _sample(projected=True),
    93: _sample(compared=True, projected=True),
    94: _sample(compared=True, projected=True),
    95: _fetch,
    96: _gather(compared=False),
    97: _gather(compared=True),
    100: _image,
    103: _size,
    104: _size,
    105: _query_lod,
    106: _levels,
    107: _samples,
}
