"""Why two drivers differ: what each was seen to do at the same pixels, held side by side."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from shaderlab.model.observations import Observation
from shaderlab.model.records import Disagreement

# Drivers that have one compiler and one device, and differ in what those get.
_PATHS = {
    frozenset(("llvmpipe", "llvmpipe-spirv")):
        "the same compiler made other instructions of SPIR-V than of text",
    frozenset(("swiftshader", "webgl2")):
        "the same device got the module, and what ANGLE made of the ESSL that was made of it",
}  # fmt: skip


def attributed(
    found: Disagreement, one: Observation | None, two: Observation | None
) -> Disagreement:
    """The disagreement with its cause. A driver that does what its own inputs do not allow is to
    blame, and leaves a band; else what differs first between the inputs of both is the cause.

    Args:
        found: one output on two drivers.
        one, two: the output as each of them was seen to draw it, None where that was not possible.
    """
    if one is None or two is None:
        return replace(found, why="it could not be drawn once more")
    faults = {
        driver: seen.fault
        for driver, seen in zip(found.drivers, (one, two), strict=True)
        if seen.fault is not None
    }
    if faults:
        outside = tuple(d for d in found.drivers if d in found.outside or d in faults)
        cause = next(iter(faults.values())).kind
        why = "; ".join(f"{d}: {f.text}" for d, f in faults.items())
        return replace(found, verdict="outside", outside=outside, cause=cause, why=why)
    cause, why = next(_differences(found, one, two))
    return replace(found, cause=cause, why=why)


def _differences(
    found: Disagreement, one: Observation, two: Observation
) -> Iterator[tuple[str, str]]:
    """What may make two drivers differ that both do what their inputs allow, the first cause
    first."""
    refused = [*one.refused, *two.refused]
    if refused and not any(draw >= 0 for draw in (*one.seen, *two.seen)):
        yield "", f"not looked at: {refused[0]}"
    same_vertices = all(two.vertices.get(n, own) == own for n, own in one.vertices.items())
    rows = range(min(len(one.seen), len(two.seen)))
    visible = [row for row in rows if one.seen[row] != two.seen[row]]
    edges = [row for row in visible if one.at_edge[row] or two.at_edge[row]]
    if visible and not same_vertices:
        yield "vertex stage", "its vertices differ within their band, and so does what they cover"
    if edges:
        yield "rasterisation", "an edge passes through a pixel's centre: it may be covered or not"
    if visible:
        yield "visibility", "another draw is seen: a test of depth or stencil, or a discard"
    name, distance = _most_apart(one, two)
    if name and name in one.reads:
        yield "earlier pass", f"it reads {name}, which differs"
    if name:
        where = "the vertex stage" if not same_vertices else "interpolation between the vertices"
        cause = "interpolation" if same_vertices else "vertex stage"
        yield cause, f"{name} differs by {distance:.4g} ULP at most: {where}, within its band"
    if one.reads:
        yield "earlier pass", f"it reads {', '.join(one.reads)}, which may differ"
    if one.after:
        yield "fixed function", f"what the shader gets is the same; then comes {one.after}"
    path = _PATHS.get(frozenset(found.drivers))
    if path is not None:
        yield "translation", path
    if one.samples_textures:
        yield "texels", "the shader gets the same: filtered texels, or arithmetic within its band"
    yield "arithmetic", "the shader gets the same: rounding of its arithmetic, within its band"


def _most_apart(one: Observation, two: Observation) -> tuple[str, float]:
    """The input that differs most where the same draw is seen, "" for none."""
    worst: tuple[str, float] = ("", 0.0)
    for draw, other, mine, theirs in zip(one.seen, two.seen, one.inputs, two.inputs, strict=False):
        if draw != other:
            continue
        for name, distance in _distances(mine, theirs):
            if distance > worst[1]:
                worst = name, distance
    return worst


def _distances(
    mine: Mapping[str, tuple[float, ...]], theirs: Mapping[str, tuple[float, ...]]
) -> Iterator[tuple[str, float]]:
    for name, values in mine.items():
        for a, b in zip(values, theirs.get(name, ()), strict=False):
            if a != b and not (math.isnan(a) and math.isnan(b)):
                unit = math.ulp(max(abs(a), abs(b), 2.0**-126)) * 2.0**29  # of 24 bits, not 53
                yield name, abs(a - b) / unit
