"""Blending, filtering, coverage and per-fragment tests against OpenImageIO, NumPy and counting."""

from __future__ import annotations

import itertools
import math
from typing import Any

import colour
import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given, strategies as st

from shaderlab.glslmath.sampling import Sampler
from shaderlab.model.frame import Texels
from shaderlab.reference import (
    blending,
    coverage,
    depth_stencil,
    filtering,
    post_processing,
    rasterisation,
    transforms,
)
from tests.independent.against import against

shares = st.floats(0.0, 1.0)
coordinates = st.floats(0.3, 7.7).map(lambda x: round(x, 3))
corners_of = st.tuples(coordinates, coordinates)


def buffer(values: Any) -> Any:
    """An image of OpenImageIO with these values (height, width, channels)."""
    made = oiio.ImageBuf(oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], "float"))
    made.set_pixels(oiio.ROI(), np.ascontiguousarray(values, np.float32))
    return made


def pixels(image: Any) -> Any:
    return np.asarray(image.get_pixels("float"))


# T. Porter, T. Duff, 1984: what is seen where both cover, where the source alone does, and where
# the destination alone does ("s", "d" or nothing), and their factors as OpenGL names them.
OPERATORS = {
    ("s", "s", "d"): ("one", "one_minus_src_alpha"),
    ("d", "s", "d"): ("one_minus_dst_alpha", "one"),
    ("s", "", ""): ("dst_alpha", "zero"),
    ("d", "", ""): ("zero", "src_alpha"),
    ("", "s", ""): ("one_minus_dst_alpha", "zero"),
    ("", "", "d"): ("zero", "one_minus_src_alpha"),
    ("s", "", "d"): ("dst_alpha", "one_minus_src_alpha"),
    ("d", "s", ""): ("one_minus_dst_alpha", "src_alpha"),
    ("", "s", "d"): ("one_minus_dst_alpha", "one_minus_src_alpha"),
    ("s", "s", ""): ("one", "zero"),
    ("d", "", "d"): ("zero", "one"),
    ("", "", ""): ("zero", "zero"),
}


@against("Porter and Duff's operators: areas that cover a pixel, counted", blending.blended)
@pytest.mark.parametrize("shown", list(OPERATORS))
@given(shares, shares)
def test_blending_counts_areas(shown: Any, source: float, destination: float) -> None:
    colors = {"s": np.array([0.9, 0.2, 0.4, 1.0]), "d": np.array([0.1, 0.8, 0.6, 1.0])}
    colors[""] = np.zeros(4)
    areas = (source * destination, source * (1 - destination), (1 - source) * destination)
    expected = sum(area * colors[what] for area, what in zip(areas, shown, strict=True))
    got = blending.blended(
        "add", OPERATORS[shown], source * colors["s"], destination * colors["d"], (0.0,) * 4
    )
    np.testing.assert_allclose(got, expected, atol=1e-12)


@against("a table of equations and factors evaluated by Python's own numbers", blending.blended)
@given(st.tuples(shares, shares, shares, shares), st.tuples(shares, shares, shares, shares))
def test_blending_by_channel(s: Any, d: Any) -> None:
    c = (0.5, 0.25, 0.75, 0.125)
    for i in range(4):
        saturate = 1.0 if i == 3 else min(s[3], 1.0 - d[3])
        cases = {
            ("add", "src_color", "one_minus_dst_color"): s[i] * s[i] + d[i] * (1 - d[i]),
            ("add", "one_minus_src_color", "dst_color"): s[i] * (1 - s[i]) + d[i] * d[i],
            ("subtract", "constant_color", "one_minus_constant_color"):
                s[i] * c[i] - d[i] * (1 - c[i]),
            ("reverse_subtract", "constant_alpha", "one_minus_constant_alpha"):
                d[i] * (1 - c[3]) - s[i] * c[3],
            ("add", "src_alpha_saturate", "zero"): s[i] * saturate,
            ("min", "zero", "zero"): sorted((s[i], d[i]))[0],
            ("max", "zero", "zero"): sorted((s[i], d[i]))[1],
        }  # fmt: skip
        for (equation, *factors), expected in cases.items():
            got = blending.blended(equation, tuple(factors), s, d, c)[i]  # type: ignore[arg-type]
            assert got == pytest.approx(expected, abs=1e-12)


@against("OpenImageIO's over, which takes colours times alpha", blending.over)
@given(st.tuples(shares, shares, shares), shares, st.tuples(shares, shares, shares))
def test_over(color: Any, alpha: float, behind: Any) -> None:
    source = np.array([[[*(alpha * np.array(color)), alpha]]])
    theirs = oiio.ImageBufAlgo.over(buffer(source), buffer(np.array([[[*behind, 1.0]]])))
    ours = blending.over(np.array([*color, alpha]), np.array([*behind, 1.0]))
    np.testing.assert_allclose(ours[:3], pixels(theirs)[0, 0, :3], atol=1e-6)


OPERATIONS = {
    "keep": lambda s, r: s, "zero": lambda s, r: np.uint8(0), "replace": lambda s, r: r,
    "invert": lambda s, r: np.invert(s),
    "incr_wrap": lambda s, r: np.add(s, np.uint8(1)),
    "decr_wrap": lambda s, r: np.subtract(s, np.uint8(1)),
    "incr": lambda s, r: np.uint8(np.clip(int(s) + 1, 0, 255)),
    "decr": lambda s, r: np.uint8(np.clip(int(s) - 1, 0, 255)),
}  # fmt: skip
COMPARED = {"never": (), "less": (-1,), "equal": (0,), "lequal": (-1, 0), "greater": (1,),
            "notequal": (-1, 1), "gequal": (0, 1), "always": (-1, 0, 1)}  # fmt: skip


@against("NumPy's 8-bit integers, which wrap as the buffer does", depth_stencil.stencil_after)
@against("the sign of the difference, looked up", depth_stencil.stencil_passes,
         depth_stencil.depth_passes, depth_stencil.depth_after)  # fmt: skip
def test_stencil_and_depth() -> None:
    assert set(OPERATIONS) == set(depth_stencil.OPERATIONS)
    assert set(COMPARED) == set(depth_stencil.FUNCTIONS)
    values = (0, 1, 90, 254, 255)
    with np.errstate(over="ignore"):
        for word, stored, reference in itertools.product(OPERATIONS, values, values):
            new = OPERATIONS[word](np.uint8(stored), np.uint8(reference))
            assert depth_stencil.stencil_after(word, stored, reference) == new
            bits = "".join(
                format(a, "08b")[i] if format(0x3C, "08b")[i] == "1" else format(b, "08b")[i]
                for i in range(8) for a, b in [(int(new), stored)]
            )  # fmt: skip
            assert depth_stencil.stencil_after(word, stored, reference, 0x3C) == int(bits, 2)
    for word, reference, stored, mask in itertools.product(COMPARED, values, values, (0, 3, 255)):
        passes = np.sign((reference & mask) - (stored & mask)) in COMPARED[word]
        assert depth_stencil.stencil_passes(word, reference, stored, mask) == passes
    for word, incoming in itertools.product(COMPARED, (0.25, 0.5, 0.75)):
        passes = np.sign(incoming - 0.5) in COMPARED[word]
        assert depth_stencil.depth_passes(word, incoming, 0.5) == passes
        for write in (True, False):
            after = depth_stencil.depth_after(word, write, incoming, 0.5)
            assert after == (incoming if passes and write else 0.5)
    assert depth_stencil.depth_after(None, True, 0.25, 0.5) == 0.5


WRAPS = {"repeat": ("periodic", "wrap"), "mirrored_repeat": ("mirror", "symmetric"),
         "clamp_to_edge": ("clamp", "edge"), "clamp_to_border": ("black", "constant")}  # fmt: skip


@against("OpenImageIO's bilinear look-up with each wrap mode", filtering.linear_sample,
         filtering.bilinear, filtering.first_texel, filtering.weight)  # fmt: skip
@pytest.mark.parametrize("mode", list(WRAPS))
def test_linear_filtering(mode: str) -> None:
    rng = np.random.default_rng(3)
    values = rng.random((5, 7, 4)).astype(np.float32)
    image, places = buffer(values), rng.uniform(-1.5, 2.5, (200, 2))
    texels = Texels(values, ("linear", "linear"), (mode, mode), (0.0,) * 4)
    got = filtering.linear_sample(Sampler(texels), places)
    theirs = [image.interppixel_NDC(float(u), float(v), wrap=WRAPS[mode][0]) for u, v in places]
    np.testing.assert_allclose(got, theirs, atol=2e-5)


@against("numpy.pad, which repeats, mirrors and extends", filtering.wrapped_texel)
@pytest.mark.parametrize("mode", list(WRAPS))
def test_wrapping(mode: str) -> None:
    size, around = 5, 12
    padded = np.pad(np.arange(size), around, mode=WRAPS[mode][1])  # type: ignore[call-overload]
    if mode == "clamp_to_border":
        padded[:around] = padded[-around:] = -1
    found = filtering.wrapped_texel(np.arange(-around, size + around), size, mode)
    assert found.tolist() == padded.tolist()


@against("numpy.repeat: a texel is what a magnified texture shows", filtering.nearest_texel)
@against("OpenImageIO's resize to half the size with a box", filtering.box)
@against("halving until nothing is left, by hand", filtering.level_count, filtering.texel_count)
def test_nearest_and_mipmaps() -> None:
    shown = np.repeat(np.arange(6), 100)
    centres = (np.arange(600) + 0.5) / 600
    assert filtering.nearest_texel(centres, 6.0).tolist() == shown.tolist()
    fine = np.random.default_rng(4).random((8, 8, 3)).astype(np.float32)
    half = oiio.ImageBufAlgo.resize(
        buffer(fine), filtername="box", roi=oiio.ROI(0, 4, 0, 4, 0, 1, 0, 3)
    )
    got = filtering.box(fine[::2, ::2], fine[::2, 1::2], fine[1::2, ::2], fine[1::2, 1::2])
    np.testing.assert_allclose(got, pixels(half), atol=1e-6)
    for width, height in ((1, 1), (256, 256), (5, 2), (7, 100)):
        sizes = [(width, height)]
        while sizes[-1] != (1, 1):
            sizes.append(tuple(max(n // 2, 1) for n in sizes[-1]))  # type: ignore[arg-type]
        assert filtering.level_count(width, height) == len(sizes)
        assert filtering.texel_count(width, height) == sum(w * h for w, h in sizes)


@against("OpenImageIO's convolve, inside of the edges", post_processing.convolved,
         post_processing.filtered)  # fmt: skip
@against("OpenImageIO's invert", post_processing.inverse)
@against("numpy.mean", post_processing.average)
@against("colour-science's luminance of BT.709 primaries, whose weights have more digits",
         post_processing.luminance)  # fmt: skip
def test_post_processing() -> None:
    rng = np.random.default_rng(5)
    image = rng.random((6, 9, 3)).astype(np.float32)
    weights = rng.random((3, 3)).astype(np.float32)
    kernel = oiio.ImageBuf(oiio.ImageSpec(oiio.ROI(-1, 2, -1, 2, 0, 1, 0, 1), "float"))
    kernel.set_pixels(oiio.ROI(-1, 2, -1, 2, 0, 1, 0, 1), weights[::-1, :, None].copy())
    theirs = pixels(oiio.ImageBufAlgo.convolve(buffer(image), kernel, False))
    ours = post_processing.convolved(image, weights.ravel())
    np.testing.assert_allclose(ours[1:-1, 1:-1], theirs[1:-1, 1:-1], atol=1e-5)
    neighbours = [image[1 + dy : 5 + dy, 1 + dx : 8 + dx] for dy in (1, 0, -1) for dx in (-1, 0, 1)]
    found = post_processing.filtered(neighbours, weights.ravel())
    np.testing.assert_allclose(found, theirs[1:-1, 1:-1], atol=1e-5)
    np.testing.assert_allclose(
        post_processing.inverse(image), pixels(oiio.ImageBufAlgo.invert(buffer(image))), atol=1e-6
    )
    np.testing.assert_allclose(post_processing.average(image)[..., 0], image.mean(-1), atol=1e-6)
    space = colour.RGB_COLOURSPACES["ITU-R BT.709"]
    theirs = colour.RGB_luminance(image, space.primaries, space.whitepoint)
    np.testing.assert_allclose(post_processing.luminance(image)[..., 0], theirs, atol=3e-4)


def inside(place: Any, corners: Any) -> bool:
    """Whether a point sees all of a polygon's corners go round by 360°."""
    turns = [math.atan2(y - place[1], x - place[0]) for x, y in corners]
    steps = [(b - a + math.pi) % (2.0 * math.pi) - math.pi
             for a, b in zip(turns, turns[1:] + turns[:1], strict=True)]  # fmt: skip
    return abs(sum(steps)) > math.pi


@against("64 × 64 samples of each pixel, counted by winding numbers", coverage.area_in_pixel,
         coverage.area_coverage)  # fmt: skip
@against("the winding number around the polygon's corners", coverage.on_inner_side)
@against("the sum of the areas of a fan of triangles (Heron's formula)", transforms.signed_area)
def test_areas() -> None:
    polygon = [(0.3, 0.4), (3.6, 0.9), (2.9, 3.2), (0.8, 2.7)]
    found = coverage.area_coverage([polygon], (4, 4))
    steps = (np.arange(64) + 0.5) / 64
    for x, y in itertools.product(range(4), range(4)):
        sampled = np.mean([inside((x + a, y + b), polygon) for a in steps[::4] for b in steps[::4]])
        assert found[y, x] == pytest.approx(sampled, abs=0.04)
        assert coverage.area_in_pixel(polygon, x, y) == pytest.approx(found[y, x])
    edges = list(zip(polygon, [*polygon[1:], polygon[0]], strict=True))
    for place in ((1.5, 1.5), (3.5, 3.0), (0.1, 0.1), (2.0, 0.2)):
        left = [float(coverage.on_inner_side(np.array(place), a, b).item()) for a, b in edges]
        assert (min(left) == 1.0) == inside(place, polygon)

    def heron(a: Any, b: Any, c: Any) -> float:
        sides = [math.dist(a, b), math.dist(b, c), math.dist(c, a)]
        half = sum(sides) / 2.0
        return math.sqrt(half * math.prod(half - side for side in sides))

    whole = heron(*polygon[:3]) + heron(polygon[0], *polygon[2:])
    assert transforms.signed_area(polygon) == pytest.approx(whole)
    assert transforms.signed_area(polygon[::-1]) == pytest.approx(-whole)
    assert found.sum() == pytest.approx(whole)


@against("numpy.linalg.solve of the corners' equations", rasterisation.barycentric)
@given(st.tuples(corners_of, corners_of, corners_of), corners_of)
def test_barycentric(triangle: Any, place: Any) -> None:
    matrix = np.array([[x for x, _ in triangle], [y for _, y in triangle], [1.0] * 3])
    if abs(np.linalg.det(matrix)) < 0.5:
        return
    solved = np.linalg.solve(matrix, [*place, 1.0])
    got = rasterisation.barycentric(np.array(place), np.array(triangle))
    np.testing.assert_allclose(got, solved, atol=1e-8)


@against("each pixel's nearest triangle so far, by winding numbers and a plane through the corners",
         rasterisation.samples_passed, rasterisation.samples_seen)  # fmt: skip
def test_samples_passed_and_seen() -> None:
    size = 16

    def triangle(places: Any, z: Any) -> Any:
        ndc = np.array(places) / (size / 2.0) - 1.0
        return np.array([[x, y, depth, 1.0] for (x, y), depth in zip(ndc, z, strict=True)])

    first = [(1.2, 1.7), (14.3, 3.1), (5.6, 13.9)]
    second = [(2.4, 12.2), (3.3, 2.6), (14.7, 8.4)]
    depths = ((-0.2, 0.3, 0.1), (0.2, -0.3, 0.25))
    counts, stored, owner = [], np.full((size, size), 1.0), np.full((size, size), -1)
    for places, z in zip((first, second), depths, strict=True):
        plane = np.linalg.solve([[x, y, 1.0] for x, y in places], z)
        passed = 0
        for x, y in itertools.product(range(size), range(size)):
            new = float(plane @ (x + 0.5, y + 0.5, 1.0))
            if inside((x + 0.5, y + 0.5), places) and new < stored[y, x]:
                stored[y, x], owner[y, x], passed = new, len(counts), passed + 1
        counts.append(passed)
    draws = [triangle(places, z)[None] for places, z in zip((first, second), depths, strict=True)]
    passed_and_seen = (
        rasterisation.samples_passed(draws, (size, size)),
        rasterisation.samples_seen(draws, (size, size)),
    )
    in_sight = [int(np.count_nonzero(owner == number)) for number in range(2)]
    assert in_sight[0] < counts[0] and in_sight[1] == counts[1]
    for expected, bounds in zip((counts, in_sight), passed_and_seen, strict=True):
        for count, (least, most) in zip(expected, bounds, strict=True):
            assert least <= count <= most and most - least < 0.35 * count
