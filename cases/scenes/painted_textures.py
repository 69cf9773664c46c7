"""Textures of the course, painted by arithmetic: the same on every machine, without files.

Each is a float32 array (height, width, channels) of values in 0…1, row 0 the bottom one.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

# Digits of five rows, three columns each, the top row first.
_ROWS = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71717", "4": "55711", "5": "74717",
    "6": "74757", "7": "71122", "8": "75757", "9": "75717",
}  # fmt: skip


def uv_grid(size: int = 256, cells: int = 8) -> Array:
    """A grid whose fields show their column and row; red grows with s, green with t. RGBA.

    Field "27" is column 2, row 7; "00" holds the first texel. At most ten fields a side; each
    needs 16 texels for its figures to be legible.

    >>> uv_grid(32, 2)[0, 0].astype(float).round(2).tolist()
    [0.15, 0.15, 0.55, 1.0]
    """
    if not 1 <= cells <= 10 or size % cells:
        raise ValueError(f"uv_grid: {cells} fields do not divide {size} texels")
    t, s = np.mgrid[0:size, 0:size] / size
    column, row = np.floor(s * cells).astype(int), np.floor(t * cells).astype(int)
    odd = (column + row) % 2
    red = 0.15 + 0.75 * column / max(cells - 1, 1)
    green = 0.15 + 0.75 * row / max(cells - 1, 1)
    image = np.stack([red, green, np.full_like(red, 0.55), np.ones_like(red)], -1)
    image[..., :3] *= np.where(odd == 1, 0.78, 1.0)[..., None]
    side = size // cells
    dot = side // 9
    if dot < 1:
        return image.astype(np.float32)
    for y in range(cells):
        for x in range(cells):
            ink = 1.0 if image[y * side, x * side, :3].mean() < 0.5 else 0.08
            for place, digit in enumerate((x, y)):
                left = x * side + (1 + 4 * place) * dot
                _write(image, str(digit), left, y * side + 2 * dot, dot, ink)
    return image.astype(np.float32)


def crate(size: int = 256, seed: int = 7) -> Array:
    """A wooden box: planks upright inside a frame, a plank across, nails in the corners. RGBA."""
    t, s = _coordinates(size)
    upright = _boards(s, t, boards=6, seed=seed)
    border = 0.13
    edge = np.minimum(np.minimum(s, 1.0 - s), np.minimum(t, 1.0 - t))
    sideways = np.minimum(t, 1.0 - t) < np.minimum(s, 1.0 - s)
    rim = np.where(
        sideways, _boards(t, s, boards=7, seed=seed + 1), _boards(s, t, boards=7, seed=seed + 2)
    )
    # Across from corner to corner: distance to the diagonal s = t, in texture units.
    off = np.abs(s - t) / np.sqrt(2.0)
    brace = _boards(s - t + 2.0, s + t, boards=4, seed=seed + 3)
    shade = np.where(off < 0.075, 1.08 * brace, 0.80 * upright)
    shade *= 1.0 - 0.45 * _bump(off - 0.085, 0.012)
    shade = np.where(edge < border, 1.15 * rim, shade * (1.0 - 0.5 * _bump(edge - border, 0.02)))
    shade *= np.where(edge < 0.012, 0.6, 1.0)
    mitre = np.abs(np.minimum(s, 1.0 - s) - np.minimum(t, 1.0 - t))
    shade *= np.where((edge < border) & (mitre < 0.006), 0.62, 1.0)
    wood = shade[..., None] * np.array([0.66, 0.45, 0.25])
    for x in (0.065, 0.935):
        for y in (0.065, 0.935):
            nail = np.hypot(s - x, t - y)
            glint = 0.30 + 0.45 * _bump(np.hypot(s - x + 0.006, t - y - 0.006), 0.008)
            wood = np.where((nail < 0.018)[..., None], glint[..., None] * np.ones(3), wood)
    return _rgba(wood)


def brick_wall(size: int = 256, rows: int = 8, seed: int = 3) -> Array:
    """A brick wall in running bond, four bricks to a course, each of a slightly different tone.

    RGBA. It tiles seamlessly in both directions if `rows` is even.
    """
    course, brick, joint = _courses(size, rows)
    random = np.random.default_rng(seed)
    tone = random.uniform(0.72, 1.12, (rows, rows // 2))[course, brick]
    hue = random.uniform(-0.04, 0.04, (rows, rows // 2))[course, brick]
    face = np.clip(joint / 0.09 - 0.6, 0.0, 1.0)[..., None]
    grain = 1.0 + 0.10 * (_noise(size, 48, seed) - 0.5) + 0.10 * (_noise(size, 12, seed + 1) - 0.5)
    clay = np.stack([0.62 + hue, 0.29 + 0.6 * hue, 0.21 + 0.3 * hue], -1)
    clay = clay * (tone * grain)[..., None]
    mortar = np.array([0.60, 0.58, 0.54]) * (0.9 * grain)[..., None]
    return _rgba(face * clay + (1.0 - face) * mortar)


def brick_normals(size: int = 256, rows: int = 8, seed: int = 3, depth: float = 0.012) -> Array:
    """The normal map of `brick_wall` with the same size, rows and seed: 0.5 n + 0.5, RGBA.

    n is in the texture's own frame, x along u, y along v, z out of the wall. `depth` is how deep
    the joints lie, in widths of the texture.

    >>> bricks = brick_normals(64)[..., :3] * 2.0 - 1.0
    >>> bool(np.allclose(np.linalg.norm(bricks, axis=-1), 1.0, atol=1e-6))
    True
    """
    _, _, joint = _courses(size, rows)
    edge = np.clip(joint / 0.16 - 0.2, 0.0, 1.0)
    height = depth * edge * edge * (3.0 - 2.0 * edge)
    height = height + 0.10 * depth * (_noise(size, 48, seed) + 2.0 * _noise(size, 12, seed + 1))
    # Central differences, across the seam as well.
    slopes = [(np.roll(height, -1, axis) - np.roll(height, 1, axis)) * size / 2 for axis in (1, 0)]
    normal = np.stack([-slopes[0], -slopes[1], np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return _rgba(0.5 * normal + 0.5)


def emblem(size: int = 256) -> Array:
    """A golden sun with twelve rays on deep blue. RGBA, alpha 1 on the sun and 0 around it."""
    t, s = _coordinates(size)
    x, y = 2.0 * s - 1.0, 2.0 * t - 1.0
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    ray = 0.56 + 0.30 * np.abs(np.cos(6.0 * angle)) ** 3
    soft = 3.0 / size
    disc = np.clip((0.46 - radius) / soft + 0.5, 0.0, 1.0)
    rays = np.clip((ray - radius) / soft + 0.5, 0.0, 1.0)
    rays *= np.clip((radius - 0.52) / soft + 0.5, 0.0, 1.0)
    alpha = np.maximum(disc, rays)[..., None]
    gold = np.stack([1.0 - 0.1 * radius, 0.80 - 0.35 * radius, 0.22 - 0.15 * radius], -1)
    night = np.stack([0.05 + 0.03 * t, 0.09 + 0.08 * t, 0.22 + 0.18 * t], -1)
    image = alpha * gold + (1.0 - alpha) * night
    return np.concatenate([np.clip(image, 0.0, 1.0), alpha], -1).astype(np.float32)


def plaster(size: int = 256, seed: int = 9) -> Array:
    """Old plaster, chalky and stained; alpha is 1 where it still holds and 0 where it has come off.

    RGBA; it tiles seamlessly in both directions.
    """
    stains = (
        _noise(size, 5, seed) + 0.5 * _noise(size, 13, seed + 1) + 0.25 * _noise(size, 41, seed)
    )
    left = np.clip((stains - 0.78) / 0.05 + 0.5, 0.0, 1.0)
    tone = 0.80 + 0.10 * _noise(size, 7, seed + 2) + 0.06 * (_noise(size, 90, seed + 3) - 0.5)
    tone = tone * (1.0 - 0.25 * _bump(left - 0.5, 0.4))
    chalk = tone[..., None] * np.array([0.98, 0.93, 0.83])
    return np.concatenate([np.clip(chalk, 0.0, 1.0), left[..., None]], -1).astype(np.float32)


def _coordinates(size: int) -> tuple[Array, Array]:
    """(t, s) of every texel's centre, in 0…1."""
    t, s = np.mgrid[0:size, 0:size]
    return (t + 0.5) / size, (s + 0.5) / size


def _courses(size: int, rows: int) -> tuple[Array, Array, Array]:
    """Every texel's course, its brick in that, and its distance to the nearest joint."""
    t, s = _coordinates(size)
    course = np.floor(t * rows).astype(int)
    along = s * rows / 2.0 + 0.5 * (course % 2)
    brick = np.floor(along).astype(int) % (rows // 2)
    u, v = along - np.floor(along), t * rows - course
    return course, brick, np.minimum(np.minimum(u, 1.0 - u) * 2.0, np.minimum(v, 1.0 - v))


def _boards(along: Array, grain: Array, *, boards: int, seed: int) -> Array:
    """Brightness of parallel boards: a tone each, dark gaps, and rings that follow `grain`."""
    random = np.random.default_rng(seed)
    number = np.floor(along * boards).astype(int)
    within = along * boards - number
    tones = random.uniform(0.84, 1.08, 64)
    phases = random.uniform(0.0, 9.0, 64)
    bend = 1.4 * np.sin(5.0 * grain + phases[number % 64])
    rings = 0.5 + 0.5 * np.sin(22.0 * within + bend + 2.0 * np.sin(1.7 * grain + within * 5.0))
    gap = np.clip(np.minimum(within, 1.0 - within) / 0.05, 0.45, 1.0)
    return np.asarray(tones[number % 64] * (0.86 + 0.16 * rings) * gap)


def _noise(size: int, cells: int, seed: int) -> Array:
    """Smooth value noise in 0…1 that repeats at the edges."""
    lattice = np.random.default_rng(seed).random((cells, cells))
    place = (np.arange(size) + 0.5) / size * cells
    low = np.floor(place).astype(int)
    part = place - low
    part = part * part * (3.0 - 2.0 * part)
    high, low = (low + 1) % cells, low % cells
    rows = lattice[low] * (1.0 - part)[:, None] + lattice[high] * part[:, None]
    return np.asarray(rows[:, low] * (1.0 - part) + rows[:, high] * part)


def _bump(distance: Array, width: float) -> Array:
    """1 at distance 0, falling smoothly to 0 a few widths away."""
    return np.asarray(np.exp(-((distance / width) ** 2)))


def _rgba(image: Array) -> Array:
    opaque = np.ones((*image.shape[:2], 1))
    return np.concatenate([np.clip(image, 0.0, 1.0), opaque], -1).astype(np.float32)


def _write(image: Array, digit: str, left: int, bottom: int, dot: int, ink: float) -> None:
    """One digit, 3 × 5 dots, its lower left corner at a texel."""
    for row, bits in enumerate(reversed(_ROWS[digit])):
        for column in range(3):
            if int(bits) >> (2 - column) & 1:
                y, x = bottom + row * dot, left + column * dot
                image[y : y + dot, x : x + dot, :3] = ink
