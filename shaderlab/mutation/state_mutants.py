"""Mistakes in a case's fixed-function state: another depth or stencil function, another operation,
mask, blend factor or equation, another winding, a face culled or not, a rectangle that is a pixel
off, a depth range or an offset the other way round, a test forgotten."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any

from shaderlab.model.case import Case, Scene
from shaderlab.model.frame import PassDraw
from shaderlab.model.state import State, Stencil
from shaderlab.mutation.mutants import STATE, Effect, Mutant, sample_alike, select_scenes

MOST_ALIKE = 4
"""Of many draws with the same change, so many are tried."""

_FUNCTION = {
    "never": ("always",), "always": ("never",),
    "less": ("lequal", "greater"), "lequal": ("less", "gequal"),
    "greater": ("gequal", "less"), "gequal": ("greater", "lequal"),
    "equal": ("notequal", "lequal"), "notequal": ("equal", "always"),
}  # fmt: skip
_OPERATION = {
    "keep": ("replace", "incr"), "zero": ("keep",), "replace": ("keep", "incr"),
    "incr": ("keep", "decr", "incr_wrap"), "decr": ("keep", "incr", "decr_wrap"),
    "incr_wrap": ("incr", "keep"), "decr_wrap": ("decr", "keep"), "invert": ("keep", "zero"),
}  # fmt: skip
_EQUATION = {
    "add": ("subtract", "max"), "subtract": ("add", "reverse_subtract"),
    "reverse_subtract": ("add", "subtract"), "min": ("max", "add"), "max": ("min", "add"),
}  # fmt: skip
_FACTORS = ("source", "destination", "source_alpha", "destination_alpha")
_FACE = {"front": ("back", None), "back": ("front", None), "front_and_back": (None,)}


@dataclass(frozen=True, kw_only=True)
class StateMutant(Mutant):
    """One field of one `State` with another value, in all draws and variants that have this state.

    `path` names the field, as "depth.func"; for a whole test that is switched off it is "depth".
    `old` and `new` are its values, `draws` the passes and places of the draws.
    """

    draws: tuple[PassDraw, ...]
    path: str
    old: Any
    new: Any

    def effect(self, scene: Scene) -> Effect | None:
        passes, changed = [], set()
        for description in scene.passes:
            draws = list(description.draws)
            for index, draw in enumerate(draws):
                named = (description.name, index) in self.draws
                if named and _get(draw.state, self.path) == self.old:
                    draws[index] = replace(draw, state=_set(draw.state, self.path, self.new))
                    changed.add(description.name)
            passes.append(replace(description, draws=tuple(draws)))
        if not changed:
            return None
        return Effect(replace(scene, passes=tuple(passes)), frozenset(changed))


def mutate_state(case: Case, seed: int = 0, variants: Collection[str] = ()) -> list[StateMutant]:
    """Return the case's state mutants, or those in some of its variants.

    A `State` that several draws share counts once, as when a pass is drawn large as well, or
    backwards. Where many draws of a pass have a change alike, a few of them stand for all.
    """
    alike: dict[tuple[Any, ...], list[StateMutant]] = {}
    for state, draws in _states(case, variants):
        name, index = draws[0]
        where = f"{name}[{index}]" + (f" and {len(draws) - 1} more" if draws[1:] else "")
        for path, old, new in _changes(state):
            if old != new:
                mutant = StateMutant(
                    file=case.file,
                    line=0,
                    operator=STATE,
                    before=f"{where} {path}={_format(old)}",
                    after=_format(new),
                    draws=draws,
                    path=path,
                    old=old,
                    new=new,
                )
                same = alike.setdefault((name, path, old, new), [])
                if mutant not in same:
                    same.append(mutant)
    some = sample_alike(alike, MOST_ALIKE, seed)
    return [m for same in some for m in sorted(same, key=lambda m: m.draws[0][1])]


def _states(case: Case, variants: Collection[str]) -> list[tuple[State, tuple[PassDraw, ...]]]:
    """The states of a case, each with the draws that have this very one."""
    found: dict[int, tuple[State, dict[PassDraw, None]]] = {}
    for scene in select_scenes(case, variants):
        for description in scene.passes:
            for index, draw in enumerate(description.draws):
                _, draws = found.setdefault(id(draw.state), (draw.state, {}))
                draws[description.name, index] = None
    return [(state, tuple(draws)) for state, draws in found.values()]


def _changes(state: State) -> Iterator[tuple[str, Any, Any]]:
    if state.depth is not None:
        yield "depth", state.depth, None
        yield "depth.write", state.depth.write, not state.depth.write
        yield from _from_table("depth.func", state.depth.func, _FUNCTION)
    for path, stencil in (("stencil", state.stencil), ("stencil_back", state.stencil_back)):
        if stencil is not None:
            yield from _stencil_changes(path, stencil, alone=state.stencil_back is None)
    if state.blend is not None:
        blend = state.blend
        yield "blend", blend, None
        for name in _FACTORS:
            for other in _other_factors(getattr(blend, name)):
                yield f"blend.{name}", getattr(blend, name), other
        for name in ("equation", "equation_alpha"):
            if getattr(blend, name) is not None:
                yield from _from_table(f"blend.{name}", getattr(blend, name), _EQUATION)
        if any("constant" in (getattr(blend, name) or "") for name in _FACTORS):
            yield "blend.constant", blend.constant, tuple(reversed(blend.constant))
    if state.cull is not None:
        yield from _from_table("cull", state.cull, _FACE)
    if state.cull is not None or state.stencil_back is not None:
        yield "front_face", state.front_face, "cw" if state.front_face == "ccw" else "ccw"
    if state.srgb:
        yield "srgb", True, False
    if state.color_mask != (True,) * 4:
        for index in range(4):
            mask = tuple(not c if i == index else c for i, c in enumerate(state.color_mask))
            yield "color_mask", state.color_mask, mask
    yield from _rasterizing_changes(state)


def _stencil_changes(path: str, stencil: Stencil, *, alone: bool) -> Iterator[tuple[str, Any, Any]]:
    if alone or path == "stencil_back":
        yield path, stencil, None
    yield from _from_table(f"{path}.func", stencil.func, _FUNCTION)
    for name in ("fail", "depth_fail", "depth_pass"):
        yield from _from_table(f"{path}.{name}", getattr(stencil, name), _OPERATION)
    yield f"{path}.reference", stencil.reference, (stencil.reference + 1) & 0xFF
    for name in ("mask", "write_mask"):
        value = getattr(stencil, name)
        yield f"{path}.{name}", value, 0
        yield f"{path}.{name}", value, value ^ 1


def _rasterizing_changes(state: State) -> Iterator[tuple[str, Any, Any]]:
    """Where triangles land, and which samples they cover: forgotten, shifted, swapped."""
    for name in ("viewport", "scissor"):
        box = getattr(state, name)
        if box is not None:
            x, y, width, height = box
            yield name, box, None
            for other in ((x + 1, y, width, height), (x, y + 1, width, height),
                          (x, y, width + 1, height), (x, y, width, height + 1)):  # fmt: skip
                yield name, box, other
    near, far = state.depth_range
    if (near, far) != (0.0, 1.0):
        yield "depth_range", (near, far), (0.0, 1.0)
        yield "depth_range", (near, far), (far, near)
    if state.polygon_offset is not None:
        factor, units = state.polygon_offset
        yield "polygon_offset", (factor, units), None
        for offset in ((-factor, -units), (0.0, units), (factor, 0.0)):
            yield "polygon_offset", (factor, units), offset
    if state.point_size == "program":
        yield "point_size", "program", 1.0
    elif isinstance(state.point_size, int | float):
        for size in (1.0, state.point_size + 1.0):
            yield "point_size", state.point_size, size
    if not state.multisample:
        yield "multisample", False, True
    if state.sample_shading is not None:
        yield "sample_shading", state.sample_shading, None
    if state.alpha_to_coverage:
        yield "alpha_to_coverage", True, False


def _from_table(path: str, before: Any, table: dict[Any, tuple[Any, ...]]) -> Iterator[Any]:
    for after in table[before]:
        yield path, before, after


def _other_factors(factor: str | None) -> tuple[str, ...]:
    """What a blend factor is mistaken for: its complement, the other side's, one, zero."""
    if factor is None:
        return ()
    found = {"zero", "one"}
    if factor.startswith("one_minus_"):
        found.add(factor.removeprefix("one_minus_"))
    elif factor not in ("zero", "one", "src_alpha_saturate"):
        found.add(f"one_minus_{factor}")
    for one, other in (("src_", "dst_"), ("alpha", "color")):
        for old, new in ((one, other), (other, one)):
            if old in factor and "saturate" not in factor:
                found.add(factor.replace(old, new))
    return tuple(sorted(found - {factor}))


def _get(state: State, path: str) -> Any:
    value: Any = state
    for word in path.split("."):
        value = getattr(value, word) if value is not None else None
    return value


def _set(state: State, path: str, value: Any) -> State:
    first, _, rest = path.partition(".")
    if not rest:
        return replace(state, **{first: value})
    return replace(state, **{first: replace(getattr(state, first), **{rest: value})})


def _format(value: Any) -> str:
    if value is None or isinstance(value, bool | float | int | str | tuple):
        return repr(value)
    return "on"
