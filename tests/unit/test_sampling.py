"""Texture functions in references: printed figures, an independent sampler, bands that hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from shaderlab.bands import Band, Rules
from shaderlab.errors import CaseError, FormulaError
from shaderlab.glslmath.sampling import (
    Sampler,
    cube_face,
    texelFetch,
    texture,
    textureLod,
    textureOffset,
    textureQueryLevels,
    textureSize,
)
from shaderlab.model.frame import Texels
from shaderlab.model.textures import (
    CubeTexture,
    Output,
    Texture,
    Texture3D,
    TextureArray,
    level_sizes,
)
from shaderlab.reference import filtering

RNG = np.random.default_rng(5)


def texels(values: Any, word: str = "nearest", wrap: str = "repeat", **more: Any) -> Texels:
    border = more.pop("border", (0.0,) * 4)
    filters = more.pop("filter", (word, word))
    wraps = (wrap,) * (3 if more.get("kind") == "3D" else 2)
    return Texels(np.asarray(values, np.float32), filters, wraps, border, **more)


def both(image: Texels, p: Any, *lod: Any) -> tuple[Any, Band]:
    """The sample in float64 and as a band of the same float32 coordinates."""
    exact = [np.asarray(v, np.float32).astype(np.float64) for v in (p, *lod)]
    function: Any = textureLod if lod else texture
    got = function(Sampler(image), *exact)
    band = function(Sampler(image, Rules()), *(Band.exact(v) for v in exact))
    assert band.contains(got).all()
    return got, band


def test_the_printed_border_figures() -> None:
    values = np.array([[[10.0], [20.0], [30.0], [40.0]]], np.float32)
    row = Texels(values, ("linear",) * 2, ("clamp_to_border", "repeat"), (1.0,) * 4)
    got = texture(Sampler(row), np.array([[-0.05, 0.5], [1.05, 0.5]]))
    np.testing.assert_allclose(got[:, 0], (3.7, 12.7), atol=1e-12)
    _, band = both(row, [[-0.05, 0.5], [1.05, 0.5]])
    # A weight may be a 256th off: 9 and 39 between the texels that are mixed.
    assert (band.hi - band.lo)[:, 0] == pytest.approx((2 * 9 / 256, 2 * 39 / 256), rel=1e-3)


@pytest.mark.parametrize(
    ("wrap", "u", "texel"),
    [
        ("repeat", -0.25, 0.75), ("repeat", 1.25, 0.25), ("mirrored_repeat", 1.25, 0.75),
        ("mirrored_repeat", -0.25, 0.25), ("clamp_to_edge", 1.25, 1.0),
        ("clamp_to_edge", -9.0, 0.0),
    ],
)  # fmt: skip
def test_the_printed_wraps(wrap: str, u: float, texel: float) -> None:
    ramp = texels(np.linspace(0.0, 1.0, 101)[None, :, None], wrap=wrap)
    assert texture(Sampler(ramp), np.array([u, 0.5]))[0] == pytest.approx(texel, abs=0.011)


def test_linear_is_the_specifications_equation() -> None:
    image = RNG.random((3, 5, 4))
    uv = RNG.uniform(-1.5, 2.5, (200, 2))
    x, y = (filtering.first_texel(uv[:, k], n).astype(int) for k, n in enumerate((5.0, 3.0)))
    across, up = (filtering.weight(uv[:, k : k + 1], n) for k, n in enumerate((5.0, 3.0)))

    def at(i: int, j: int) -> Any:
        return image.astype(np.float32)[(y + j) % 3, (x + i) % 5].astype(float)

    wanted = filtering.bilinear(at(0, 0), at(1, 0), at(0, 1), at(1, 1), across, up)
    got = texture(Sampler(texels(image, "linear")), uv)
    np.testing.assert_allclose(got, wanted, atol=1e-12)


@pytest.mark.parametrize("wrap", ["repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border"])
def test_bands_hold_what_weights_of_eight_bits_give(wrap: str) -> None:
    image = texels(RNG.random((4, 4, 4)), "linear", wrap, border=(2.0,) * 4)
    uv = RNG.uniform(-1.0, 2.0, (500, 2)).astype(np.float32)
    _, band = both(image, uv)
    for rounding in (np.floor, np.rint, np.ceil):
        # Fixed point: the place in texels is kept to 8 bits of fraction.
        kept = rounding((uv * 4.0 - 0.5) * 256.0) / 256.0
        assert band.contains(texture(Sampler(image), (kept + 0.5) / 4.0)).all()
    assert not band.contains(texture(Sampler(image), uv.astype(float) + 0.01)).all()
    assert float(np.median(band.hi - band.lo)) < 0.01


def in_codes(values: Any) -> Any:
    return np.rint(values * 256.0) / 256.0


def mixed_in_codes(corners: Any, shares: Any) -> Any:
    """2 × 2 (× 2) texels mixed as an NVIDIA H200 does: shares are codes of eight bits, and so is
    each product of them; what is divided keeps its sum. The first axis of `corners` goes first."""
    total: Any = 0.0
    for corner in np.ndindex(*corners.shape[: len(shares)]):
        weight = np.ones_like(shares[0])
        for second, share in zip(corner, shares, strict=True):
            part = in_codes(weight * share)
            weight = part if second else weight - part
        total = total + weight[:, None] * corners[corner]
    return total


def test_bands_hold_products_of_weights_in_codes() -> None:
    values = RNG.random((2, 2, 4)).astype(np.float32)
    uv = RNG.uniform(0.25, 0.75, (3000, 2)).astype(np.float32)
    _, band = both(texels(values, "linear", "clamp_to_edge"), uv)
    shares = in_codes(uv[:, ::-1].astype(float).T * 2.0 - 0.5)
    assert band.contains(mixed_in_codes(values, shares)).all()
    assert not band.contains(mixed_in_codes(values, shares + 2.0 / 256.0)).all()


@pytest.mark.parametrize("first", range(3))
def test_bands_hold_products_of_three_weights_in_codes(first: int) -> None:
    values = RNG.random((2, 2, 2, 4)).astype(np.float32)
    p = RNG.uniform(0.25, 0.75, (3000, 3)).astype(np.float32)
    _, band = both(texels(values, "linear", "clamp_to_edge", kind="3D"), p)
    shares = in_codes(p[:, ::-1].astype(float).T * 2.0 - 0.5)
    order = [(first + k) % 3 for k in range(3)]
    assert band.contains(mixed_in_codes(values.transpose(*order, 3), shares[order])).all()
    assert not band.contains(mixed_in_codes(values, shares + 4.0 / 256.0)).all()


def test_bands_hold_products_of_weights_with_that_of_a_level() -> None:
    values, smaller = (RNG.random((n, n, 4)).astype(np.float32) for n in (2, 1))
    uv = RNG.uniform(0.25, 0.75, (3000, 2)).astype(np.float32)
    lod = RNG.uniform(0.1, 0.9, (3000, 1)).astype(np.float32)
    filters = ("linear_mipmap_linear", "linear")
    image = texels(values, wrap="clamp_to_edge", filter=filters, smaller=(smaller,))
    _, band = both(image, uv, lod)
    level = np.floor(lod[:, 0].astype(float) * 256.0) / 256.0
    shares = [level, *in_codes(uv[:, ::-1].astype(float).T * 2.0 - 0.5)]
    corners = np.stack([values, np.broadcast_to(smaller, values.shape)])
    assert band.contains(mixed_in_codes(corners, shares)).all()
    assert not band.contains(mixed_in_codes(corners, [level + 4.0 / 256.0, *shares[1:]])).all()


@pytest.mark.parametrize("wrap", ["repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border"])
def test_eight_texels_are_mixed_in_three_dimensions(wrap: str) -> None:
    values = RNG.random((2, 3, 5, 4)).astype(np.float32)
    image = texels(values, "linear", wrap, border=(2.0,) * 4, kind="3D")
    p = RNG.uniform(-1.0, 2.0, (300, 3)).astype(np.float32)
    # As many copies as the places reach, so that an index needs no wrapping.
    modes = {"repeat": "wrap", "mirrored_repeat": "symmetric", "clamp_to_edge": "edge"}
    padding = [(2 * n, 2 * n) for n in (2, 3, 5)] + [(0, 0)]
    if wrap == "clamp_to_border":
        around = np.pad(values, padding, constant_values=2.0)
    else:
        around = np.pad(values, padding, mode=modes[wrap])  # type: ignore[call-overload]

    def mixed(p: Any, kept: Any = lambda place: place) -> Any:
        place = kept(p[:, ::-1].astype(float) * (2, 3, 5) - 0.5)
        first = np.floor(place).astype(int)
        found = np.zeros((len(p), 4))
        for corner in np.ndindex(2, 2, 2):
            weight = np.where(corner, place - first, 1.0 - (place - first)).prod(axis=1)
            found += weight[:, None] * around[tuple((first + corner + (4, 6, 10)).T)]
        return found

    got, band = both(image, p)
    np.testing.assert_allclose(got, mixed(p), atol=1e-12)
    for rounding in (np.floor, np.rint, np.ceil):
        assert band.contains(mixed(p, lambda place, r=rounding: r(place * 256.0) / 256.0)).all()
    assert not band.contains(mixed(p + np.array([0.0, 0.0, 0.02]))).all()
    assert float(np.median(band.hi - band.lo)) < 0.02


def test_layers_between_which_nothing_is_mixed() -> None:
    image = texels(np.arange(3.0)[:, None, None, None], kind="3D", wrap="mirrored_repeat")
    got, _ = both(image, [[0.5, 0.5, r] for r in (0.1, 0.5, 0.9, 1.1, 1.9)])
    assert got[:, 0].tolist() == [0.0, 1.0, 2.0, 2.0, 0.0]
    edge = texture(Sampler(image, Rules()), Band.between([0.5, 0.5, 0.33], [0.5, 0.5, 0.34]))
    assert (edge.lo[..., 0], edge.hi[..., 0]) == (0.0, 1.0)
    assert texelFetch(Sampler(image), np.array([0, 0, 2]))[0] == 2.0
    assert textureSize(Sampler(image)).lo.tolist() == [1, 1, 3]


def test_mipmap_levels() -> None:
    smaller = tuple(np.full((k, k, 1), float(n), np.float32) for n, k in ((1, 4), (2, 2), (3, 1)))
    image = texels(
        np.zeros((8, 8, 1)), filter=("nearest_mipmap_linear", "nearest"), smaller=smaller
    )
    lod = np.array([[-2.0], [0.0], [0.25], [1.5], [2.75], [9.0]])
    got, _ = both(image, np.full((6, 2), 0.4), lod)
    assert got[:, 0].tolist() == [0.0, 0.0, 0.25, 1.5, 2.75, 3.0]
    image = texels(
        np.zeros((8, 8, 1)), filter=("linear_mipmap_nearest", "nearest"), smaller=smaller
    )
    got, band = both(image, np.full((6, 2), 0.4), lod)
    assert got[:, 0].tolist() == [0.0, 0.0, 0.0, 1.0, 3.0, 3.0]
    assert band.hi[3, 0] >= 2.0, "one half may be rounded either way"
    assert textureQueryLevels(Sampler(image)) == 4
    assert textureSize(Sampler(image), 1).lo.tolist() == [4, 4]
    assert texelFetch(Sampler(image), np.array([[1, 1]]), 2)[0, 0] == 2.0
    with pytest.raises(FormulaError, match="depends on the mipmap level"):
        texture(Sampler(image), np.full((6, 2), 0.4))


# OpenGL 4.5, table 8.19, row by row: the major axis, and what s and t are made of.
TABLE = [
    ((1, 0, 0), lambda r: (-r[2], -r[1])), ((-1, 0, 0), lambda r: (r[2], -r[1])),
    ((0, 1, 0), lambda r: (r[0], r[2])), ((0, -1, 0), lambda r: (r[0], -r[2])),
    ((0, 0, 1), lambda r: (r[0], -r[1])), ((0, 0, -1), lambda r: (-r[0], -r[1])),
]  # fmt: skip


@pytest.mark.parametrize("number", range(6))
def test_cube_faces(number: int) -> None:
    axis, made = TABLE[number]
    for _ in range(50):
        r = np.array(axis) * 1.0 + np.where(np.array(axis) == 0, RNG.uniform(-1, 1, 3), 0.0)
        for scale in (1.0, 0.01, 900.0):
            face, s, t = cube_face(scale * r)
            assert int(face) == number
            np.testing.assert_allclose((2 * s - 1, 2 * t - 1), made(r), atol=1e-12)


@pytest.mark.parametrize("seamless", [True, False])
@pytest.mark.parametrize("word", ["nearest", "linear"])
def test_cubes_over_bands(word: str, seamless: bool) -> None:
    faces = RNG.random((6, 4, 4, 4))
    image = texels(faces, word, "clamp_to_edge", kind="Cube", seamless=seamless)
    directions = np.concatenate([RNG.normal(size=(2000, 3)), np.sign(RNG.normal(size=(20, 3)))])
    got, band = both(image, directions)
    assert got.shape == (2020, 4)
    one = texels(np.ones((6, 4, 4, 4)), word, "clamp_to_edge", kind="Cube", seamless=seamless)
    got, band = both(one, directions)
    assert np.allclose(got, 1.0) and float((band.hi - band.lo).max()) < 1e-5


def test_a_direction_on_an_edge_may_meet_both_faces() -> None:
    faces = np.repeat(np.arange(6.0), 4).reshape(6, 2, 2, 1)
    image = texels(faces, wrap="clamp_to_edge", kind="Cube")
    _, band = both(image, [[1.0, 0.0, 1.0]])
    assert (band.lo[0, 0], band.hi[0, 0]) == (0.0, 4.0)


def test_layers_are_rounded_and_clamped() -> None:
    image = texels(np.arange(3.0).repeat(4).reshape(3, 2, 2, 1), kind="2DArray")
    layer = np.array([[-3.0], [0.4], [0.6], [1.4], [7.0]])
    got, _ = both(image, np.concatenate([np.full((5, 2), 0.3), layer], axis=1))
    assert got[:, 0].tolist() == [0.0, 0.0, 1.0, 1.0, 2.0]
    assert textureSize(Sampler(image)).lo.tolist() == [2, 2, 3]


@pytest.mark.parametrize("compare", ["never", "less", "equal", "lequal", "greater", "notequal",
                                     "gequal", "always"])  # fmt: skip
def test_shadow_comparisons(compare: str) -> None:
    image = texels([[[0.25], [0.5]]], compare=compare, format="depth32f")
    points = [[0.2, 0.5, z] for z in (0.0, 0.25, 0.5)]
    got, _ = both(image, points)
    wanted = {
        "never": (0, 0, 0), "less": (1, 0, 0), "equal": (0, 1, 0), "lequal": (1, 1, 0),
        "greater": (0, 0, 1), "notequal": (1, 0, 1), "gequal": (0, 1, 1), "always": (1, 1, 1),
    }  # fmt: skip
    assert tuple(got[:, 0]) == wanted[compare]


def test_linear_shadows_are_the_share_of_four_texels() -> None:
    image = texels([[[0.2], [0.6]], [[0.2], [0.6]]], "linear", "clamp_to_edge", compare="less",
                   format="depth32f")  # fmt: skip
    got, band = both(image, [[0.375, 0.5, 0.4], [0.5, 0.5, 0.4], [0.5, 0.5, 0.9]])
    assert got[:, 0].tolist() == [0.25, 0.5, 0.0]
    assert (band.lo[:, 0].tolist(), band.hi[:, 0].tolist()) == ([0.0] * 3, [1.0, 1.0, 0.0])


def test_a_depth_that_may_be_either_side_of_its_texel_is_lit_and_unlit() -> None:
    code = np.float32(7.0 / 65535.0)
    image = texels([[[code]]], compare="less", format="depth16")
    _, band = both(image, [[0.5, 0.5, code]])
    assert (band.lo[0, 0], band.hi[0, 0]) == (0.0, 1.0)


def test_codes_are_divided_by_their_largest() -> None:
    image = Texels(np.array([[[51]]], np.uint8), ("nearest",) * 2, ("repeat",) * 2, (0.0,) * 4,
                   format="r8")  # fmt: skip
    assert texture(Sampler(image), np.array([0.5, 0.5])).tolist() == [0.2, 0.0, 0.0, 1.0]
    band = texture(Sampler(image, Rules()), Band.exact([0.5, 0.5]))
    assert 0.0 < band.hi[0] - band.lo[0] < 1e-6


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: texture(Sampler(texels(np.zeros((1, 1, 1)))), np.zeros(3)), "takes 2 coordinates"),
        (
            lambda: texelFetch(Sampler(texels(np.zeros((1, 1, 1)))), np.array([0, 1])),
            "outside 1 × 1",
        ),
        (
            lambda: texelFetch(Sampler(texels(np.zeros((1, 1, 1)))), np.array([0, 0]), 1),
            "no level 1",
        ),
        (
            lambda: texture(Sampler(texels(np.zeros((1, 1, 1, 1)), kind="2DMS")), np.zeros(2)),
            "texelF",
        ),
        (
            lambda: texture(
                Sampler(texels(np.zeros((4, 4, 1))), Rules()), Band.between([0.1, 0.1], [0.9, 0.9])
            ),
            "more than two texels",
        ),
        (
            lambda: textureOffset(
                Sampler(texels(np.zeros((1, 1, 1, 1)), kind="3D")), np.zeros(3), (1, 0)
            ),
            "offsets of a sampler3D",
        ),
    ],
)
def test_what_can_not_be_sampled(make: Any, says: str) -> None:
    with pytest.raises(FormulaError, match=says):
        make()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Texture(image=np.zeros((1, 1, 4)), filter=("linear_mipmap_linear", "linear")),
         "incomplete"),
        (lambda: Output("a.b", filter=("linear_mipmap_linear", "linear")), "incomplete"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), filter=("linear", "linear_mipmap_linear")),
         "magnifying"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), format="r32ui", filter=("linear", "linear")),
         "no integers"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), compare="less"), "is not a depth"),
        (lambda: Texture(image=np.zeros((1, 1, 1)), format="depth16", compare="lower"), "low"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), lod=(3.0, 1.0)), "from 3.0 down to 1.0"),
        (lambda: CubeTexture(faces=[np.zeros((1, 1, 4))] * 5), "5 faces"),
        (lambda: TextureArray(layers=[]), "no layers"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), upload="copy"), "upload"),
        (lambda: Texture(image=np.zeros((1, 1, 4)), wrap=("repeat",) * 3), "3 words, not 2"),
        (lambda: Texture3D(layers=[np.zeros((1, 1, 4))], wrap=("repeat",) * 2), "2 words, not 3"),
        (lambda: Texture3D(layers=[np.zeros((1, 1, 4))], mipmaps=True), "no mipmaps"),
        (lambda: Texture3D(layers=[np.zeros((1, 1, 4))], filter=("linear", "nearest")), "mipmaps"),
        (lambda: Texture3D(layers=[np.zeros((1, 1, 1))], format="depth24"), "no depth24"),
    ],
)  # fmt: skip
def test_what_can_not_be_a_texture(make: Any, says: str) -> None:
    with pytest.raises(CaseError, match=says):
        make()


def test_256_has_nine_levels() -> None:
    sizes = level_sizes(256, 256)
    assert len(sizes) == 9 and sum(w * h for w, h in sizes) == 87381
