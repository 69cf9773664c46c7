"""Texture functions with offsets, projections, derivatives and gathers, on known texels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shaderlab.bands import Band, Rules
from shaderlab.errors import FormulaError
from shaderlab.glslmath import sampling as s
from shaderlab.model.frame import Texels

# Texel (x, y) of 4 × 4 is x + 10·y; of the smaller levels 100 and 200.
NUMBERS = (np.arange(4.0)[None, :] + 10.0 * np.arange(4.0)[:, None])[..., None].astype(np.float32)
SMALLER = (np.full((2, 2, 1), 100.0, np.float32), np.full((1, 1, 1), 200.0, np.float32))


def sampler(word: str = "nearest", banded: bool = False, **more: Any) -> s.Sampler:
    filters = ("nearest_mipmap_nearest", word) if "smaller" in more else (word, word)
    texels = Texels(NUMBERS, filters, ("repeat", "repeat"), (0.0,) * 4, **more)
    return s.Sampler(texels, Rules() if banded else None)


def centre(x: int, y: int) -> np.ndarray:
    return np.array([[(x + 0.5) / 4.0, (y + 0.5) / 4.0]])


def red(found: Any) -> list[float]:
    return list(np.asarray(getattr(found, "lo", found))[..., 0].ravel())


def test_offsets_are_in_texels_and_wrap() -> None:
    image = sampler()
    assert red(s.textureOffset(image, centre(1, 1), (1, 2))) == [32.0]
    assert red(s.textureOffset(image, centre(3, 0), (1, 0))) == [0.0]
    assert red(s.texelFetchOffset(image, np.array([[1, 1]]), 0, (1, -1))) == [2.0]
    with pytest.raises(FormulaError, match="outside"):
        s.texelFetchOffset(image, np.array([[3, 3]]), 0, (1, 0))


def test_projections_divide_by_the_last_coordinate() -> None:
    image, place = sampler(), np.append(centre(2, 1) * 3.0, [[3.0]], axis=-1)
    assert red(s.textureProj(image, place)) == [12.0]
    assert red(s.textureProjOffset(image, place, (-1, 0))) == [11.0]
    four = np.concatenate([place[:, :2], [[7.0]], place[:, 2:]], axis=-1)
    assert red(s.textureProj(image, four)) == [12.0]
    assert red(s.textureProj(sampler(banded=True), Band.exact(four))) == [12.0]
    with pytest.raises(FormulaError, match="takes 4 coordinates, or 3"):
        s.textureProj(image, centre(0, 0))


def test_derivatives_choose_the_level() -> None:
    image = sampler(smaller=SMALLER)
    for pixels, expected in ((1.0, 11.0), (2.0, 100.0), (4.0, 200.0)):
        step = np.array([[pixels / 4.0, 0.0]])
        zero = np.zeros((1, 2))
        assert red(s.textureGrad(image, centre(1, 1), step, zero)) == [expected]
        assert red(s.textureProjGrad(image, np.append(centre(1, 1), [[1.0]], -1), zero, step)) == [
            expected
        ]
    assert red(s.textureGradOffset(image, centre(1, 1), zero, zero, (1, 1))) == [22.0]


def test_a_queried_level_is_that_of_the_neighbours() -> None:
    places = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]])
    found = s.textureQueryLod(sampler(smaller=SMALLER), places / 2.0, places)
    np.testing.assert_array_equal(found, [[1.0, 1.0]] * 4)
    image = sampler(smaller=SMALLER, banded=True)
    band = s.textureQueryLod(image, Band.exact(places / 2.0), places)
    assert band.contains(found).all() and not band.contains(found + 1.5).any()


def test_gathers_go_counterclockwise_from_the_upper_left() -> None:
    place = (centre(1, 1) + centre(2, 2)) / 2.0
    for image in (sampler(), sampler(banded=True)):
        found = s.textureGather(image, place)
        assert list(np.ravel(getattr(found, "lo", found))) == [21.0, 22.0, 12.0, 11.0]
        moved = s.textureGatherOffset(image, place, (1, 0))
        assert list(np.ravel(getattr(moved, "lo", moved))) == [22.0, 23.0, 13.0, 12.0]
        four = s.textureGatherOffsets(image, place, ((0, 0), (1, 0), (0, 1), (1, 1)))
        assert list(np.ravel(getattr(four, "lo", four))) == [11.0, 12.0, 21.0, 22.0]


def test_a_gather_between_two_footprints_may_be_either() -> None:
    band = s.textureGather(sampler(banded=True), centre(1, 1))
    assert band.contains([[21.0, 22.0, 12.0, 11.0]]).all()
    assert band.contains([[10.0, 11.0, 1.0, 0.0]]).all()
    assert not band.contains([[31.0, 32.0, 22.0, 21.0]]).any()


def test_samples_are_counted() -> None:
    values = np.zeros((8, 2, 2, 4), np.float32)
    many = Texels(values, ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4, kind="2DMS")
    multisampled = s.Sampler(many)
    assert s.textureSamples(multisampled).lo.tolist() == [8]
    with pytest.raises(FormulaError, match="has no samples"):
        s.textureSamples(sampler())
