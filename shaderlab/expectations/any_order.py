"""any_order: a depth test makes the order of drawing irrelevant, and so it can be checked.

A scene is drawn twice, the second time in reverse: its last draw first or, with a single draw, its
last triangle first. Unless depth alone decides which surface a pixel shows, the images differ.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shaderlab.expectations.exact import Exact, exact
from shaderlab.model import Draw, Output, Pass
from shaderlab.model.checked import checked_arguments

_SUFFIX = "-backwards"


@checked_arguments
def both_ways(description: Pass) -> tuple[Pass, Pass]:
    """The pass with its draws in reverse order, named `…-backwards`, and the pass itself.

    >>> from shaderlab.model import Mesh, Target
    >>> triangle = Mesh(attributes={"aPos": np.zeros((3, 3))})
    >>> draws = [Draw(vertex=f"{k}.vert", fragment="a.frag", mesh=triangle) for k in (1, 2)]
    >>> backwards, same = both_ways(Pass(name="scene", target=Target(), draws=draws))
    >>> backwards.name, [draw.vertex for draw in backwards.draws]
    ('scene-backwards', ['2.vert', '1.vert'])
    """
    draws = tuple(reversed(description.draws))
    if len(draws) == 1:
        draws = (_backwards(draws[0]),)
    return replace(description, name=description.name + _SUFFIX, draws=draws), description


@checked_arguments
def any_order(output: str) -> Exact:
    """An output, named with its pass, does not depend on the order of drawing.

    >>> same = any_order("scene.FragColor")
    >>> same.output, same.equals.pass_name, same.equals.name
    ('scene.FragColor', 'scene-backwards', 'FragColor')
    """
    pass_name, _, name = output.partition(".")
    other = Output(f"{pass_name}{_SUFFIX}.{name}")
    return exact(output, other, name=f"{output}: any order of drawing", pictured=False)


def _backwards(draw: Draw) -> Draw:
    """The draw with its mesh's triangles from last to first, each as it was."""
    mesh = draw.mesh
    if mesh is None or mesh.primitive != "triangles" or mesh.indices is None:
        return draw
    triangles = np.asarray(mesh.indices).reshape(-1, 3)
    return replace(draw, mesh=replace(mesh, indices=triangles[::-1].ravel()))
