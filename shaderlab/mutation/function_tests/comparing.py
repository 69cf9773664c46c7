"""Whether two texts of a file give the same, on inputs of every kind."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.compiler.sources import Source
from shaderlab.errors import ShaderlabError
from shaderlab.functions.declarations import Type
from shaderlab.functions.domains import Domain, bools, floats, hints_of, ints
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.library import Function, Library
from shaderlab.functions.signatures import Signature
from shaderlab.model.frame import Array

if TYPE_CHECKING:
    from shaderlab.workers.lab_worker import LabWorker

SAMPLES = 4096
"""Samples of each round."""
_REACHES = (1.0, 8.0, 1000.0)
"""How far from 0 the numbers of a round go."""


@dataclass(frozen=True)
class Difference:
    """Whether a difference was found, None where that can't be asked, and in words."""

    differs: bool | None
    said: str


def difference(worker: LabWorker, source: Source, text: str, names: Collection[str]) -> Difference:
    """Compare these functions of a source and of another text for it, bit by bit.

    A function that reads other samplers than a `sampler2D` can't be asked at random arguments.
    """
    other = replace(source, text=text, stripped=None)
    count, unasked = 0, []
    with use_worker(worker):
        before, after = (Library(one, "", {}) for one in (source, other))
        for name in sorted(names):
            for signature in before[name].signatures:
                if not all(map(_is_sampled, _inputs(signature).values())):
                    unasked.append(name)
                    continue
                types = ", ".join(str(p.type) for p in signature.parameters)
                pair = before[name][types], after[name][types]
                for arguments in _arguments(signature, source.text + text):
                    count += SAMPLES
                    if not _same(*pair, arguments):
                        return Difference(True, f"{name} gives other values elsewhere")
    if unasked:
        return Difference(None, f"{', '.join(dict.fromkeys(unasked))} is not asked at other values")
    return Difference(False, f"in {count} inputs of {', '.join(sorted(names))}")


def _inputs(signature: Signature) -> dict[str, Type]:
    return {one.name: one.type for one in (*signature.given, *signature.globals)}


def _is_sampled(kind: Type) -> bool:
    if kind.members:
        return all(_is_sampled(its) for _, its in kind.members)
    return bool(kind.kind) or kind.name == "sampler2D"


def _arguments(signature: Signature, text: str) -> Iterator[dict[str, Any]]:
    rng, hints = np.random.default_rng(0), hints_of(text)
    # What is in a struct with samplers has one value for a call.
    for reach in _REACHES:
        yield {
            name: _sample(kind, reach, () if kind.opaque else (SAMPLES,), rng, hints)
            for name, kind in _inputs(signature).items()
        }


def _sample(
    kind: Type, reach: float, batch: tuple[int, ...], rng: np.random.Generator, hints: Array
) -> Any:
    """Random values of a type, for each element of a batch; an image for a sampler."""
    if kind.dims and not kind.kind:
        return [_sample(kind.element, reach, batch, rng, hints) for _ in range(kind.dims[0])]
    if kind.members:
        return {name: _sample(its, reach, batch, rng, hints) for name, its in kind.members}
    if kind.opaque:
        return rng.random((4, 4, 4), np.float32)
    found = _domain(kind, reach).sample(rng, (*(batch or (8,)), *kind.shape), hints)
    return found if batch else found[-1]


def _domain(kind: Type, reach: float) -> Domain:
    if kind.kind == "bool":
        return bools()
    if kind.kind == "float":
        return floats(-reach, reach)
    return ints(0 if kind.kind == "uint" else -int(reach), int(reach))


def _same(before: Function, after: Function, arguments: dict[str, Array]) -> bool:
    try:
        pair = [_parts(function(**arguments)) for function in (before, after)]
    except ShaderlabError:
        return False  # only one of them gives a value at all
    return all(
        np.array_equal(np.ma.getmaskarray(a), np.ma.getmaskarray(b))
        and np.array_equal(np.ma.filled(a, 0), np.ma.filled(b, 0), equal_nan=a.dtype.kind == "f")
        for a, b in zip(*pair, strict=True)
    )


def _parts(result: Any) -> list[Array]:
    """The arrays of a result: one, or each that is written; of structs, those of its members."""
    if isinstance(result, dict):
        return [part for value in result.values() for part in _parts(value)]
    if isinstance(result, list | tuple):
        return [part for value in result for part in _parts(value)]
    return [result if isinstance(result, np.ma.MaskedArray) else np.asarray(result)]
