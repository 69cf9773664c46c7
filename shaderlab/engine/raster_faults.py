"""What a driver's rasterisation does and its own vertices do not allow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.programs.stages import may_keep_out
from shaderlab.model.frame import Array, Fragments, Samples
from shaderlab.model.observations import Fault, Pixel

from .rasterised import EDGE, Covered, interpolated


def of_coverage(
    draw: PreparedDraw,
    index: int,
    captured: Fragments | None,
    what: Covered,
    pixels: Sequence[Pixel],
    nobody: Array,
) -> Iterator[Fault]:
    """A pixel that a draw covers and can't, or leaves out and can't.

    Args:
        draw, index: the draw, and its number in its pass.
        captured: where it is seen, if that is known.
        what: what its triangles cover.
        pixels: where to look.
        nobody: the pixels among them where no draw of the pass is seen.
    """
    state = draw.draw.state
    optional = (
        state.depth or state.stencil or state.alpha_to_coverage
        or may_keep_out(draw.text("fragment") or "")
    )  # fmt: skip
    for row, (x, y) in enumerate(pixels):
        seen = captured is not None and captured.covered[y, x]
        if seen and not what.possible[row]:
            text = f"draw {index} covers pixel ({x}, {y}), which none of its triangles does"
            yield Fault(kind="coverage", text=text, pixel=(x, y))
        elif what.inside[row] and nobody[row] and not optional:
            text = f"draw {index} leaves out pixel ({x}, {y}), which lies in a triangle of it"
            yield Fault(kind="coverage", text=text, pixel=(x, y))


def of_interpolation(
    draw: PreparedDraw,
    samples: Samples,
    captured: Fragments,
    what: Covered,
    pixels: Sequence[Pixel],
) -> Iterator[Fault]:
    """An input, or a depth, that is not what lies between the corners of its triangle."""
    outputs = samples.outputs
    position = outputs["gl_Position"]
    given = {
        name: (captured.inputs[name], outputs[name], variable.interpolation)
        for name, variable in draw.interface.varyings.items()
        if name in outputs and captured.inputs.get(name, position).ndim == 3
    }
    if draw.draw.state.polygon_offset is None:
        depths = _window_depth(position, draw.draw.state.depth_range)
        given["gl_FragCoord.z"] = (captured.frag_coord[..., 2:3], depths, "noperspective")
    for name, (got_all, of_vertices, how) in given.items():
        for row, (x, y) in enumerate(pixels):
            if not captured.covered[y, x] or what.triangle[row, 0] < 0:
                continue
            got = got_all[y, x].astype(np.float64)
            wanted, give = interpolated(of_vertices, position, what, row, how)
            if not (np.abs(got - wanted) <= give).all():
                text = (
                    f"{name} is ({', '.join(f'{v:.6g}' for v in got)}) at pixel ({x}, {y}), "
                    f"where its vertices give ({', '.join(f'{v:.6g}' for v in wanted)})"
                )
                yield Fault(kind="interpolation", text=text, pixel=(x, y))


def of_points(
    draw: PreparedDraw,
    samples: Samples,
    captured: Fragments,
    pixels: Sequence[Pixel],
    size: tuple[int, int],
) -> Iterator[Fault]:
    """A gl_PointCoord that no point of the draw gives. Source: OpenGL 4.5 core profile
    specification, equations 14.2 and 14.3."""
    found, state = captured.inputs.get("gl_PointCoord"), draw.draw.state
    if found is None or state.viewport or state.cell:
        return
    position = samples.outputs["gl_Position"].astype(np.float64)
    widths: Array | float = 1.0
    if isinstance(state.point_size, int | float):
        widths = float(state.point_size)
    elif "gl_PointSize" in samples.outputs:
        widths = samples.outputs["gl_PointSize"]
    with np.errstate(all="ignore"):
        centres = (position[:, :2] / position[:, 3:] + 1.0) / 2.0 * size
    centres = np.where(position[:, 3:] > 0.0, centres, np.inf)
    for x, y in pixels:
        if not captured.covered[y, x]:
            continue
        off = (np.array([x, y]) + 0.5 - centres) * (1.0, -1.0)
        apart = np.abs((found[y, x].astype(np.float64) - 0.5) * widths - off).max(axis=1)
        if not apart.min() <= EDGE:
            text = (
                f"gl_PointCoord at pixel ({x}, {y}) is {apart.min():.3g} pixels from what any "
                "point of the draw gives"
            )
            yield Fault(kind="interpolation", text=text, pixel=(x, y))


def _window_depth(position: Array, depth_range: tuple[float, float]) -> Array:
    """Window depths of clip coordinates, (count, 1)."""
    near, far = depth_range
    with np.errstate(all="ignore"):
        found: Array = position[:, 2:3].astype(np.float64) / position[:, 3:]
    return found * (far - near) / 2.0 + (near + far) / 2.0
