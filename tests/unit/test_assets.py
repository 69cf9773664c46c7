"""Meshes are closed where they should be and face outward; textures have the stated layout."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cases.scenes import painted_textures
from shaderlab import assets
from shaderlab.assets import Geometry
from shaderlab.model.mesh import Mesh
from shaderlab.reference.transforms import rotate, scale, translate

MESHES: dict[str, Callable[[], Geometry]] = {
    "quad": assets.quad,
    "plane": assets.plane,
    "cube": assets.cube,
    "sphere": assets.sphere,
    "sphere, coarse": lambda: assets.sphere(2.0, segments=3, rings=2),
    "torus": assets.torus,
    "torus, coarse": lambda: assets.torus(segments=3, sides=3),
    "moved": lambda: assets.moved(
        assets.torus(), translate((1, 2, 3)) @ rotate(1.0, (1, 2, 3)) @ scale((1.0, 0.5, 2.0))
    ),
    "joined": lambda: assets.joined(assets.cube(), assets.sphere(), assets.plane()),
}
SOLIDS = ["cube", "sphere", "sphere, coarse", "torus", "torus, coarse", "moved"]


def corners(geometry: Geometry) -> Any:
    """Each triangle's three positions, (triangles, 3, 3)."""
    return geometry["attributes"]["aPos"].astype(float)[geometry["indices"].reshape(-1, 3)]


def areas(geometry: Geometry) -> Any:
    """Each triangle's normal, of length twice its area, by its winding."""
    a, b, c = np.moveaxis(corners(geometry), 1, 0)
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("name", MESHES)
def test_a_mesh_is_what_a_draw_takes(name: str) -> None:
    geometry = MESHES[name]()
    mesh = Mesh(**geometry)
    shapes = {k: v.shape[1] for k, v in mesh.attributes.items()}
    assert shapes == {"aPos": 3, "aNormal": 3, "aTexCoords": 2}
    assert all(v.dtype == np.float32 for v in geometry["attributes"].values())
    assert len(geometry["indices"]) % 3 == 0
    assert set(geometry["indices"].tolist()) <= set(range(mesh.vertices))


@pytest.mark.parametrize("name", MESHES)
def test_normals_have_length_one(name: str) -> None:
    normals = MESHES[name]()["attributes"]["aNormal"].astype(float)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("name", MESHES)
def test_triangles_run_counter_clockwise_around_their_normals(name: str) -> None:
    geometry = MESHES[name]()
    wound = areas(geometry)
    assert np.linalg.norm(wound, axis=1).min() > 1e-9, "a triangle has no area"
    normals = geometry["attributes"]["aNormal"][geometry["indices"].reshape(-1, 3)]
    assert (np.einsum("tk,tck->tc", wound, normals) > 0.0).all()


@pytest.mark.parametrize("name", MESHES)
def test_texture_coordinates_lie_in_the_unit_square(name: str) -> None:
    coordinates = MESHES[name]()["attributes"]["aTexCoords"]
    assert coordinates.min() == 0.0
    assert coordinates.max() == 1.0


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed(name: str) -> None:
    """Every edge belongs to two triangles, which run along it in opposite directions."""
    rounded = np.round(corners(MESHES[name]()), 5) + 0.0
    edges = Counter(
        (tuple(triangle[i]), tuple(triangle[(i + 1) % 3])) for triangle in rounded for i in range(3)
    )
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)


def volume(geometry: Geometry) -> float:
    """Enclosed volume, positive where the triangles face outward (divergence theorem)."""
    a, b, c = np.moveaxis(corners(geometry), 1, 0)
    return float(np.einsum("tk,tk->", a, np.cross(b, c)) / 6.0)


def test_volumes() -> None:
    assert volume(assets.cube(2.0)) == pytest.approx(8.0)
    ball = volume(assets.sphere(1.5, segments=128, rings=64))
    assert ball == pytest.approx(4.0 / 3.0 * np.pi * 1.5**3, rel=2e-3)
    ring = volume(assets.torus(0.7, 0.3, segments=128, sides=64))
    assert ring == pytest.approx(2.0 * np.pi**2 * 0.7 * 0.3**2, rel=3e-3)


def test_counts() -> None:
    sphere = assets.sphere(segments=8, rings=4)
    assert len(sphere["attributes"]["aPos"]) == 9 * 5
    assert len(sphere["indices"]) == 3 * (2 * 8 * 4 - 2 * 8)
    assert len(assets.torus(segments=8, sides=4)["indices"]) == 3 * 2 * 8 * 4
    both = assets.joined(assets.quad(), assets.cube())
    assert both["indices"].tolist()[6:] == [i + 4 for i in assets.cube()["indices"].tolist()]


def test_plane_faces_up_and_sphere_points_out() -> None:
    assert np.array_equal(assets.plane()["attributes"]["aNormal"], [[0, 1, 0]] * 4)
    attributes = assets.sphere(3.0)["attributes"]
    np.testing.assert_allclose(attributes["aPos"], 3.0 * attributes["aNormal"], atol=1e-6)


def test_a_mirror_would_turn_the_winding() -> None:
    with pytest.raises(ValueError, match="orientation"):
        assets.moved(assets.cube(), scale((-1.0, 1.0, 1.0)))


@pytest.mark.parametrize(
    "call",
    [
        lambda: assets.sphere(segments=2),
        lambda: assets.sphere(rings=1),
        lambda: assets.torus(sides=2),
        lambda: assets.checker(size=10, cells=4),
    ],
)
def test_impossible_sizes(call: Callable[[], Any]) -> None:
    with pytest.raises(ValueError):
        call()


@pytest.mark.parametrize(
    "make",
    [assets.checker, painted_textures.crate, painted_textures.brick_wall, painted_textures.emblem],
)
def test_textures(make: Callable[[], Any]) -> None:
    image = make()
    assert image.dtype == np.float32
    assert image.shape[0] == image.shape[1]
    assert image.shape[2] == 4
    assert np.isfinite(image).all()
    assert image.min() >= 0.0
    assert image.max() <= 1.0
    assert image[..., :3].std() > 0.05, "a picture of nothing"
    np.testing.assert_array_equal(image, make(), "made differently the second time")


def test_row_zero_is_the_bottom_row() -> None:
    field = assets.checker(size=8, cells=2, dark=(0.0,), light=(1.0,))
    assert field[0, 0, 0] == 0.0, "the lower left field is dark"
    assert field[0, 7, 0] == 1.0
    assert field[7, 7, 0] == 0.0


def test_the_wall_tiles() -> None:
    """Across the edge the wall goes on as smoothly as anywhere within."""
    wall = painted_textures.brick_wall().astype(float)[..., :3]
    for axis in (0, 1):
        within = np.abs(np.diff(wall, axis=axis)).mean(axis=(1 - axis, 2))
        around = np.abs(np.take(wall, 0, axis) - np.take(wall, -1, axis)).mean()
        assert around <= within.max()


def test_the_emblem_has_a_silhouette() -> None:
    alpha = painted_textures.emblem()[..., 3]
    assert alpha[128, 128] == 1.0
    assert alpha[0, 0] == 0.0


def test_solid() -> None:
    assert assets.solid((1.0, 0.0, 0.25)).tolist() == [[[1.0, 0.0, 0.25]]]
