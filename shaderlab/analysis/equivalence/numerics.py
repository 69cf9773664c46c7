"""How accurate two programs of the same mathematics are, by the widths of their bands."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.bands import Band
from shaderlab.errors import FormulaError, NotInterpretedError
from shaderlab.model.frame import Array

from ..interpreter import Bands, Program, interpret
from .given import Given
from .locating import Step, first

MOST = 512
"""Invocations whose bands are looked at."""
_SMALL = 2.0**-8  # of an output's largest value: below it, what counts is the ULP of this
_ULPS, _RATIO = 1.0, 1.25  # wider by more than both is less accurate


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How much accuracy a program loses against another one.

    Attributes:
        worse, better: ULP of the output's value that a band is wider or narrower, at most.
        row: the invocation where that is, of whichever is more.
        step: the first stored value whose band is wider there, or narrower; None if none is.
    """

    worse: float
    better: float
    row: int
    step: Step | None


def bands_of(program: Program, given: Given) -> Mapping[str, Any] | None:
    """A program's outputs as bands; None where it can't be run in them."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            return interpret(
                program, given.each, given.bindings, Bands(), count=given.count
            ).outputs
        except (NotInterpretedError, FormulaError):
            return None


def accuracy(
    programs: tuple[Program, Program], given: Given, bands: tuple[Any, Any], values: Array
) -> Accuracy | None:
    """How the accuracy of an output changes from one program to the other.

    Args:
        programs: the old and the new one.
        given: what they get.
        bands: the output of both.
        values: the output in float64, (count, components).

    Returns:
        None where the output has no bands, such as an integer's, or all of them are open.
    """
    if not all(isinstance(band, Band) for band in bands):
        return None
    size = min(bands[0].shape[-1], bands[1].shape[-1], values.shape[-1])
    values = values[:, :size]
    with np.errstate(all="ignore"):
        floor = _SMALL * np.nanmax(np.abs(values), axis=0, initial=0.0)
        ulp = np.spacing(np.maximum(np.abs(values), floor).astype(np.float32)).astype(np.float64)
        old, new = (_off(band, values, size) / ulp for band in bands)
        known = np.isfinite(old) & np.isfinite(new)
        if not known.any():
            return None
        wider = np.where(known & (new > _RATIO * old), new - old, 0.0).max(axis=-1)
        narrower = np.where(known & (old > _RATIO * new), old - new, 0.0).max(axis=-1)
    worse, better = (float(v.max()) if v.max() > _ULPS else 0.0 for v in (wider, narrower))
    row = int((wider if worse >= better else narrower).argmax())
    step = None
    if worse or better:
        differ = _wider if worse >= better else _narrower
        step, _, _ = first(programs, given, row, Bands(), differ)
    return Accuracy(worse, better, row, step)


def _off(band: Band, values: Array, size: int) -> Array:
    """How far a device may be from the value, (count, size)."""
    off: Array = np.maximum(band.hi[..., :size] - values, values - band.lo[..., :size])
    return off


def _wider(old: Any, new: Any) -> bool:
    if not (isinstance(old, Band) and isinstance(new, Band)) or old.shape[1:] != new.shape[1:]:
        return False
    with np.errstate(all="ignore"):
        before, after = old.hi - old.lo, new.hi - new.lo
        size = np.maximum(np.abs(new.lo), np.abs(new.hi)).astype(np.float32)
        return bool((after > _RATIO * before + 0.5 * np.spacing(size)).any())


def _narrower(old: Any, new: Any) -> bool:
    return _wider(new, old)
