"""The inputs of a stage that is run on given values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from shaderlab.errors import CaseError, nearest
from shaderlab.frame import Array
from shaderlab.glsl.interface import Variable
from shaderlab.model import Draw
from shaderlab.programs import bind
from shaderlab.programs.formats import numpy_type, shape_of
from shaderlab.programs.prepare import PreparedDraw
from shaderlab.programs.varyings import Piece, elements


def exact_inputs(variables: Mapping[str, Variable], values: Mapping[str, Any]) -> dict[str, Array]:
    """Given input values as arrays (1, components), matrices (1, rows, columns), of the type that
    the shader gets."""
    known = {v.name: v for v in elements(variables.values())}
    return {
        name: bind.uniform_arrays(known[name], value)[0][None]
        for name, value in values.items()
        if name in known
    }


def complete_inputs(draw: PreparedDraw, inputs: Mapping[str, Array]) -> dict[str, Array]:
    """All fragment inputs of a draw, (count, components): those given, and for the others the
    value that the draw's domain has at the centre of the screen.

    Raises:
        CaseError: an input has no value, or is none of the shader's.
    """
    variables = {v.name: v for v in elements(draw.interface.varyings.values())}
    count = max((len(v) for v in inputs.values()), default=1)
    for name in inputs:
        if name not in variables:
            raise CaseError(
                f"{draw.draw.fragment} reads no {name!r}", remedy=nearest(name, variables)
            )
    complete = {}
    for name, variable in variables.items():
        value = inputs[name] if name in inputs else _at_centre(draw.draw, variable)
        shaped = np.broadcast_to(value, (count, *shape_of(variable.type)))
        complete[name] = np.ascontiguousarray(shaped.astype(numpy_type(variable.type)))
    return complete


def piece_of(values: Mapping[str, Array], piece: Piece) -> Array:
    """The part of the inputs that goes into one attribute: a vector, or a matrix's column."""
    whole = values[piece.name]
    return np.ascontiguousarray(whole[..., int(piece.path[1:-1])]) if piece.path else whole


def _at_centre(draw: Draw, variable: Variable) -> Array:
    if draw.domain is None:
        raise CaseError(
            f"{draw.fragment} also reads {variable.name!r} ({variable.type})",
            remedy=f"give it a value: at={{…, {variable.name!r}: …}}",
        )
    ramp = draw.domain[variable.name]
    origin, dx, dy = (np.asarray(v, np.float64) for v in (ramp.origin, ramp.dx, ramp.dy))
    return np.atleast_1d(origin + 0.5 * dx + 0.5 * dy)[None]
