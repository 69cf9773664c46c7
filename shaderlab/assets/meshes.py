"""Indexed triangle meshes: positions, unit normals and texture coordinates.

All are right-handed with y up. Seen from outside, every triangle's corners run counter-clockwise,
so the default front face of OpenGL is the outer one. Attributes are named as the shaders name
them: `aPos` (n, 3), `aNormal` (n, 3) of length 1, `aTexCoords` (n, 2); all float32.
"""

from functools import cache
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


class Geometry(TypedDict):
    """What `Mesh(**geometry)` takes: attributes by name, and indices, three a triangle."""

    attributes: dict[str, Array]
    indices: Array


def quad(size: float = 1.0) -> Geometry:
    """A square in the xy plane around the origin that faces +z; texture (0, 0) lower left.

    >>> quad()["indices"].tolist()
    [0, 1, 2, 0, 2, 3]
    """
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    positions = np.column_stack([corners * size, np.zeros(4)])
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    return make_geometry(positions, normals, [0, 1, 2, 0, 2, 3], aTexCoords=corners + 0.5)


def plane(size: float = 2.0, repeat: float = 1.0) -> Geometry:
    """A square floor in the xz plane around the origin that faces +y.

    Texture coordinates run from 0 to `repeat`, s along +x and t along −z.
    """
    flat = quad(size)["attributes"]
    x, y, _ = flat["aPos"].T
    positions = np.column_stack([x, np.zeros(4), -y])
    normals = np.tile([0.0, 1.0, 0.0], (4, 1))
    return make_geometry(
        positions, normals, [0, 1, 2, 0, 2, 3], aTexCoords=flat["aTexCoords"] * repeat
    )


def cube(size: float = 1.0) -> Geometry:
    """A box around the origin: 24 vertices, so that each face has its own normals and texture.

    >>> len(cube()["attributes"]["aPos"]), len(cube()["indices"])
    (24, 36)
    """
    positions, normals, texture, indices = _unit_cube()
    return make_geometry(positions * size, normals, indices, aTexCoords=texture)


@cache
def _unit_cube() -> tuple[Array, Array, Array, Array]:
    """The parts of `cube`, made once: larger solids are built of hundreds of boxes."""
    face = quad(1.0)["attributes"]
    x, y, _ = face["aPos"].T
    positions, normals = [], []
    # Each face by its two axes to the right and up as seen from outside; out = right × up.
    for right, upward in (
        ((0, 0, -1), (0, 1, 0)),  # +x
        ((0, 0, 1), (0, 1, 0)),  # −x
        ((1, 0, 0), (0, 0, -1)),  # +y
        ((1, 0, 0), (0, 0, 1)),  # −y
        ((1, 0, 0), (0, 1, 0)),  # +z
        ((-1, 0, 0), (0, 1, 0)),  # −z
    ):
        out = np.cross(right, upward).astype(float)
        positions.append(np.outer(x, right) + np.outer(y, upward) + 0.5 * out)
        normals.append(np.tile(out, (4, 1)))
    indices = np.concatenate([np.array([0, 1, 2, 0, 2, 3]) + 4 * k for k in range(6)])
    texture = np.tile(face["aTexCoords"], (6, 1))
    return np.concatenate(positions), np.concatenate(normals), texture, indices


def sphere(radius: float = 1.0, segments: int = 48, rings: int = 24) -> Geometry:
    """A globe around the origin: `segments` slices of longitude, `rings` of latitude.

    Texture s runs eastward from 0 to 1 (the seam is doubled), t from the south to the north pole.
    """
    _at_least("sphere", segments=(segments, 3), rings=(rings, 2))
    s, t = _grid(segments, rings)
    longitude, latitude = 2.0 * np.pi * s, np.pi * (t - 0.5)
    across = np.cos(latitude)
    x, z = across * np.sin(longitude), across * np.cos(longitude)
    normals = np.column_stack([x, np.sin(latitude), z])
    triangles = _grid_triangles(segments, rings).reshape(rings, segments, 2, 3)
    # At a pole one triangle of each cell has two corners in the same place: leave it out.
    south, north = triangles[0, :, 1], triangles[-1, :, 0]
    middle = triangles[1:-1].reshape(-1, 3)
    indices = np.concatenate([south, middle, north]).ravel()
    return make_geometry(normals * radius, normals, indices, aTexCoords=np.column_stack([s, t]))


def ellipsoid(
    axes: tuple[float, float, float] = (1.0, 0.6, 0.8), segments: int = 48, rings: int = 24
) -> Geometry:
    """The points with (x/a)² + (y/b)² + (z/c)² = 1, as a globe stretched by its half axes a, b, c.

    Normals are the gradient of that sum, not the stretched globe's own: (x/a², y/b², z/c²), made
    unit length. Texture coordinates are the globe's.

    >>> ellipsoid((2.0, 1.0, 3.0))["attributes"]["aPos"].max(axis=0).tolist()
    [2.0, 1.0, 3.0]
    """
    if min(axes) <= 0.0:
        raise ValueError(f"ellipsoid: half axes must be above 0, not {axes}")
    globe = sphere(1.0, segments, rings)
    unit = globe["attributes"]["aNormal"].astype(float)
    texture = globe["attributes"]["aTexCoords"]
    return make_geometry(unit * axes, unit / axes, globe["indices"], aTexCoords=texture)


def torus(radius: float = 0.7, tube: float = 0.3, segments: int = 64, sides: int = 32) -> Geometry:
    """A ring around the y axis: `radius` from the centre to the middle of a tube of radius `tube`.

    Texture s runs around the ring, t around the tube, both from 0 to 1 (the seams are doubled).
    """
    _at_least("torus", segments=(segments, 3), sides=(sides, 3))
    s, t = _grid(segments, sides)
    around, across = 2.0 * np.pi * s, 2.0 * np.pi * t
    outward = np.column_stack([np.sin(around), np.zeros_like(around), np.cos(around)])
    normals = outward * np.cos(across)[:, None]
    normals[:, 1] = np.sin(across)
    positions = outward * radius + normals * tube
    indices = _grid_triangles(segments, sides).ravel()
    return make_geometry(positions, normals, indices, aTexCoords=np.column_stack([s, t]))


def moved(geometry: Geometry, matrix: Array) -> Geometry:
    """The mesh transformed by a 4 × 4 matrix (rows first, float64) that does not mirror.

    Normals are transformed by the inverse transpose and normalised. Raises ValueError: the matrix
    mirrors or flattens, so the winding would no longer hold."""
    linear = np.asarray(matrix, float)[:3, :3]
    if np.linalg.det(linear) <= 0.0:
        raise ValueError("moved: the matrix must keep the orientation (determinant > 0)")
    others = dict(geometry["attributes"])
    positions = others.pop("aPos").astype(float) @ linear.T + np.asarray(matrix, float)[:3, 3]
    normals = others.pop("aNormal").astype(float) @ np.linalg.inv(linear)
    return make_geometry(positions, normals, geometry["indices"], **others)


def joined(*geometries: Geometry) -> Geometry:
    """Several meshes of the same attributes as one, drawn in this order.

    >>> len(joined(cube(), cube())["indices"])
    72
    """
    starts = np.cumsum([0, *(len(g["attributes"]["aPos"]) for g in geometries)])
    indices = [g["indices"] + start for g, start in zip(geometries, starts, strict=False)]
    return {
        "attributes": {
            name: np.concatenate([g["attributes"][name] for g in geometries])
            for name in geometries[0]["attributes"]
        },
        "indices": np.concatenate(indices).astype(np.uint32),
    }


def _grid(columns: int, rows: int) -> tuple[Array, Array]:
    """(s, t) of a grid's (columns + 1)·(rows + 1) vertices, row by row, each from 0 to 1."""
    t, s = np.mgrid[0 : rows + 1, 0 : columns + 1].astype(float)
    return (s / columns).ravel(), (t / rows).ravel()


def _grid_triangles(columns: int, rows: int) -> Array:
    row, column = np.mgrid[0:rows, 0:columns]
    a = (row * (columns + 1) + column).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=1)


def make_geometry(positions: Any, normals: Any, indices: Any, **others: Any) -> Geometry:
    """A mesh of these arrays; normals need not be of unit length."""
    normals = np.asarray(normals, float)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    attributes = {"aPos": positions, "aNormal": normals, **others}
    return {
        "attributes": {name: np.asarray(a, np.float32) for name, a in attributes.items()},
        "indices": np.asarray(indices, np.uint32),
    }


def _at_least(owner: str, **bounds: tuple[int, int]) -> None:
    for name, (number, least) in bounds.items():
        if number < least:
            raise ValueError(f"{owner}: {name} must be at least {least}, not {number}")
