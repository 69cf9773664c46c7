"""How meshes lie in memory: places and bytes by layout, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from shaderlab import Draw, Mesh
from shaderlab.errors import CaseError
from shaderlab.model.mesh import Placement

POSITIONS = np.arange(9, dtype=np.float32).reshape(3, 3)
COLORS = 100.0 + np.arange(9, dtype=np.float32).reshape(3, 3)
TEXTURE = 200.0 + np.arange(6, dtype=np.float32).reshape(3, 2)
ATTRIBUTES = {"aPos": POSITIONS, "aColor": COLORS, "aTexCoord": TEXTURE}


def floats(mesh: Mesh) -> list[np.ndarray]:
    """Each buffer's bytes as numbers."""
    return [np.frombuffer(b"".join(p for _, p in parts), np.float32) for parts in mesh.parts()]


def test_separate_attributes_have_a_buffer_each() -> None:
    mesh = Mesh(attributes=ATTRIBUTES)
    assert mesh.placements() == {
        "aPos": Placement(0, 0, 12), "aColor": Placement(1, 0, 12), "aTexCoord": Placement(2, 0, 8),
    }  # fmt: skip
    assert [len(values) for values in floats(mesh)] == [9, 9, 6]


def test_interleaved_attributes_share_one_buffer_vertex_by_vertex() -> None:
    mesh = Mesh(attributes=ATTRIBUTES, layout="interleaved")
    assert mesh.placements() == {
        "aPos": Placement(0, 0, 32), "aColor": Placement(0, 12, 32),
        "aTexCoord": Placement(0, 24, 32),
    }  # fmt: skip
    (values,) = floats(mesh)
    assert values.reshape(3, 8)[1].tolist() == [3, 4, 5, 103, 104, 105, 202, 203]


def test_batched_attributes_follow_each_other() -> None:
    mesh = Mesh(attributes=ATTRIBUTES, layout="batched")
    assert mesh.placements() == {
        "aPos": Placement(0, 0, 12), "aColor": Placement(0, 36, 12),
        "aTexCoord": Placement(0, 72, 8),
    }  # fmt: skip
    assert [offset for offset, _ in mesh.parts()[0]] == [0, 36, 72]
    assert floats(mesh)[0].tolist() == [*POSITIONS.ravel(), *COLORS.ravel(), *TEXTURE.ravel()]


def test_attributes_of_instances_lie_in_buffers_of_their_own() -> None:
    mesh = Mesh(
        attributes=ATTRIBUTES,
        instance_attributes={"aOffset": np.zeros((5, 2)), "aSize": np.ones(5)},
        layout="interleaved",
    )
    places = mesh.placements()
    assert (places["aOffset"], places["aSize"]) == (Placement(1, 0, 12, 1), Placement(1, 8, 12, 1))
    assert (mesh.vertices, mesh.instances) == (3, 5)


def test_a_matrix_attribute_is_written_column_by_column() -> None:
    matrices = np.arange(32.0).reshape(2, 4, 4)
    mesh = Mesh(attributes=ATTRIBUTES, instance_attributes={"model": matrices})
    assert mesh.placements()["model"] == Placement(3, 0, 64, 1)
    assert floats(mesh)[3][:4].tolist() == matrices[0, :, 0].tolist()


def test_only_keeps_the_kinds_apart() -> None:
    mesh = Mesh(attributes=ATTRIBUTES, instance_attributes={"aOffset": np.zeros((5, 2))})
    assert list(mesh.only("aOffset", "aPos").inputs) == ["aPos", "aOffset"]
    with pytest.raises(CaseError, match="aOfset"):
        mesh.only("aPos", "aOfset")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"layout": "interleave"}, "layout"),
        ({"usage": "static"}, "usage"),
        ({"upload": "mapped"}, "upload"),
        ({"instance_attributes": {"aPos": POSITIONS}}, "of vertices and of instances"),
        ({"instance_attributes": {"a": np.zeros(3), "b": np.zeros(4)}}, "number of instances"),
        ({"attributes": {"a": np.zeros((2, 2, 2, 2))}}, "rows, columns"),
        ({"attributes": {"a": np.zeros((2, 5))}}, "1…4"),
    ],
)  # fmt: skip
def test_bad_meshes_are_refused(change: dict[str, object], said: str) -> None:
    with pytest.raises(CaseError, match=said):
        Mesh(**{"attributes": ATTRIBUTES, **change})  # type: ignore[arg-type]


def test_as_many_instances_are_drawn_as_have_attributes() -> None:
    mesh = Mesh(attributes=ATTRIBUTES, instance_attributes={"aOffset": np.zeros((5, 2))})
    with pytest.raises(CaseError, match="5 instances, 1 are drawn") as refused:
        Draw(vertex="a.vert", fragment="a.frag", mesh=mesh)
    assert "instances=5" in str(refused.value)
