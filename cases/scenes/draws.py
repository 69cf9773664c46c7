"""Draws of meshes, with a depth test or without, and passes of them in either order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from shaderlab import Cell, Depth, Draw, Mesh, Pass, State, both_ways


def drawn(
    shaders: str | tuple[str, ...],
    solid: Any,
    uniforms: Mapping[str, Any] | None = None,
    *,
    only: tuple[str, ...] = (),
    textures: Mapping[str, Any] | None = None,
    cell: Cell | None = None,
    **state: Any,
) -> Draw:
    """A mesh, drawn over what is there unless `state` says otherwise.

    Args:
        shaders: vertex and fragment shader, or with a geometry shader between them; one name
            stands for both, `a` for `a.vert`, `a.frag`.
        solid: a mesh, or a geometry of `shaderlab.assets`.
        uniforms, textures: as `Draw` takes them.
        only: the attributes that the shaders read, if not all.
        cell: the part of the target to draw into.
        state: what else `State` takes.

    >>> corners = Mesh(attributes={"aPos": [[0, 0, 0]] * 3})
    >>> one = drawn("ch10_buffers/rosette", corners)
    >>> one.fragment, one.state.depth
    ('ch10_buffers/rosette.frag', None)
    """
    mesh = solid if isinstance(solid, Mesh) else Mesh(**solid)
    stages = (f"{shaders}.vert", f"{shaders}.frag") if isinstance(shaders, str) else shaders
    vertex, *between, fragment = stages
    return Draw(
        vertex=vertex,
        geometry=between[0] if between else None,
        fragment=fragment,
        mesh=mesh.only(*only) if only else mesh,
        uniforms=uniforms or {},
        textures=textures or {},
        state=State(cell=cell, **state),
    )


def tested(
    shaders: str | tuple[str, ...], solid: Any, uniforms: Mapping[str, Any], **more: Any
) -> Draw:
    """A mesh, depth tested unless `more` says otherwise, which is what else `drawn` takes.

    >>> corners = Mesh(attributes={"aPos": [[0, 0, 0]] * 3})
    >>> tested("ch04_spaces/ten_cubes", corners, {}).state.depth
    Depth(func='less', write=True)
    """
    return drawn(shaders, solid, uniforms, **{"depth": Depth(), **more})


def twins(description: Pass, output: str = "FragColor") -> tuple[Pass, Pass]:
    """`both_ways`, the backwards one with this output alone: depth decides on all of them together.

    >>> ball = tested("ball", Mesh(attributes={"aPos": [[0, 0, 0]] * 3}), {})
    >>> backwards, same = twins(Pass(name="scene", draws=[ball]))
    >>> backwards.name, dict(backwards.target.colors), same.target.colors
    ('scene-backwards', {'FragColor': 'rgba32f'}, None)
    """
    backwards, same = both_ways(description)
    format = (same.target.colors or {}).get(output, "rgba32f")
    target = replace(same.target, colors={output: format})
    return replace(backwards, target=target), same
