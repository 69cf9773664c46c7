"""What an input is, as far as its name, its type and its author tell: which values make sense."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from shaderlab.errors import UsageError
from shaderlab.model.frame import Array

from .interface import Input

Kind = Literal["number", "unit", "rotation", "affine", "projection", "texture"]


@dataclass(frozen=True)
class Role:
    """Which values an input is given.

    Attributes:
        kind: numbers between `low` and `high`, vectors of length 1, matrices that turn, those that
            turn, scale and move, those of a perspective, or textures.
        source: who says so: "given" by --range, "declared" in a comment, "learned" of captures,
            or "assumed".
        above: the name of an input than which this one is not less.
    """

    kind: Kind
    low: float = 0.0
    high: float = 1.0
    source: Literal["given", "declared", "assumed", "learned"] = "assumed"
    above: str = ""

    def condition(self, name: str) -> str:
        """What holds of the input's values, as a formula."""
        words = {
            "unit": f"|{name}| = 1",
            "rotation": f"{name} is a rotation",
            "affine": f"{name} turns, scales and moves",
            "projection": f"{name} is a perspective projection",
            "texture": f"{name} within 0..1",
        }
        low = f"{self.low:g} <= " if np.isfinite(self.low) else ""
        high = f" <= {self.high:g}" if np.isfinite(self.high) else ""
        return words.get(self.kind, f"{low}{name}{high}")

    def __str__(self) -> str:
        words = {"unit": "of length 1", "projection": "a perspective projection",
                 "affine": "turns, scales and moves", "rotation": "a rotation",
                 "texture": "any texels within 0..1"}  # fmt: skip
        text = words.get(self.kind, f"{self.low:g}..{self.high:g}")
        return f"{text}, >= {self.above}" if self.above else text

    @property
    def freed(self) -> Role | None:
        """The role without its assumption; None where somebody said it, or nothing is assumed."""
        if self.source in ("given", "declared") or self.kind in ("projection", "texture"):
            return None
        if self.source == "learned":
            free = Role("number", -np.inf, np.inf, "given")
            return free if self.kind == "unit" or self.low == 0.0 else None
        if self.kind in ("unit", "rotation", "affine"):
            return Role("number", -2.0, 2.0)
        wide = self.high - self.low
        return Role("number", self.low - wide, self.high + wide)


# By a word of the name: the last one that is here counts.
_RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("position", "positions", "pos", "eye", "target", "origin"), (-4.0, 4.0)),
    **dict.fromkeys(("world", "offset", "center"), (-4.0, 4.0)),
    **dict.fromkeys(("color", "colour", "albedo", "ambient", "diffuse", "specular"), (0.0, 1.0)),
    **dict.fromkeys(("alpha", "opacity", "metallic", "ao", "mask", "strength"), (0.0, 1.0)),
    "roughness": (0.05, 1.0),
    **dict.fromkeys(("uv", "coord", "coords", "st"), (-0.5, 1.5)),
    "shininess": (1.0, 128.0),
    "cut": (0.5, 1.0),
    "gamma": (1.5, 3.0),
    "exposure": (0.1, 4.0),
    "near": (0.1, 1.0),
    "far": (5.0, 100.0),
    "distance": (0.1, 20.0),
    "time": (0.0, 20.0),
    **dict.fromkeys(("angle", "yaw", "pitch", "roll", "phase"), (-3.2, 3.2)),
    **dict.fromkeys(("radius", "scale", "aspect", "focal"), (0.1, 4.0)),
    **dict.fromkeys(("resolution", "viewport", "size"), (16.0, 1024.0)),
    "constant": (0.5, 1.5),
}  # fmt: skip
_PLACES = frozenset(
    {"position", "positions", "pos", "eye", "target", "origin", "world", "center", "uv", "coord",
     "coords", "st"}
)  # fmt: skip
_UNIT = frozenset(
    {"normal", "dir", "direction", "halfway", "tangent", "bitangent", "axis", "up", "forward"}
)
_ORDERS = (
    ("cutoff", "outercutoff"), ("far", "near"), ("max", "min"), ("high", "low"), ("end", "start"),
    ("edge1", "edge0"), ("most", "least"),
)  # fmt: skip
WORKGROUPS = 4
"""Workgroups of a compute stage in each direction."""
_BUILT_IN = {
    "gl_NumWorkGroups": (WORKGROUPS, WORKGROUPS),
    "gl_FrontFacing": (0.0, 1.0), "gl_PointCoord": (0.0, 1.0), "gl_PrimitiveID": (0.0, 64.0),
    "gl_InstanceID": (0.0, 8.0), "gl_InstanceIndex": (0.0, 8.0), "gl_SampleID": (0.0, 3.0),
}  # fmt: skip


def roles_of(
    inputs: Iterable[Input], declared: Mapping[str, str], given: Mapping[str, str]
) -> dict[str, Role]:
    """The role of each input, by name.

    Args:
        inputs: what the programs read.
        declared: "a..b", "a:b" or "unit" by a variable's own name, as its author says.
        given: the same by whole name, of all elements of an array or of one; goes before.

    Raises:
        UsageError: what is given is no range.
    """
    inputs = list(inputs)
    found = {}
    for one in inputs:
        plain = re.sub(r"\[\d+\]", "", one.name)
        said = given.get(one.name, given.get(plain, ""))
        comment = declared.get(plain.rpartition(".")[2], "")
        if said or comment:
            role = _said(said or comment, one.name)
            found[one.name] = replace(role, source="given" if said else "declared")
        else:
            found[one.name] = _assumed(one)
    for one in inputs:
        lower = lower_one(one.name, found)
        if lower and found[one.name].kind == found[lower].kind == "number":
            found[one.name] = replace(found[one.name], above=lower)
    return found


def _said(text: str, name: str) -> Role:
    if text == "unit":
        return Role("unit")
    parts = re.split(r"\.\.|:", text)
    try:
        low, high = map(float, parts)
    except ValueError:
        low, high = 1.0, 0.0
    if not -1e38 < low <= high < 1e38:
        raise UsageError(f"{name}: {text!r} is no range", remedy="write a..b, a:b or unit")
    return Role("number", low, high)


def _assumed(one: Input) -> Role:
    words = words_of(one.name)
    if "sampler" in one.type:
        return Role("texture")
    if one.workgroup is not None:
        local = max(one.workgroup) if one.type == "uvec3" else math.prod(one.workgroup)
        groups = 1 if "Local" in one.name else WORKGROUPS
        return Role("number", 0.0, groups * (1 if "Group" in one.name else local) - 1.0)
    if one.name in _BUILT_IN:
        return Role("number", *_BUILT_IN[one.name])
    if "mat" in one.type:
        turns = one.type != "mat4" or {"rotation", "normal", "turn"} & set(words)
        return Role("projection" if "projection" in words else "rotation" if turns else "affine")
    if one.type in ("vec2", "vec3") and is_direction(one.name):
        return Role("unit")
    if one.type in ("bool", "bvec2", "bvec3", "bvec4"):
        return Role("number")
    if not one.type.startswith(("float", "vec")):
        return Role("number", 0.0, 4.0)
    for word in reversed(words):
        if word in _RANGES:
            return Role("number", *_RANGES[word])
    return Role("number") if one.type == "float" else Role("number", -2.0, 2.0)


def words_of(name: str) -> list[str]:
    """The words of a name.

    >>> words_of("light.outerCutOff"), words_of("aTexCoords"), words_of("u_near")
    (['light', 'outer', 'cut', 'off'], ['a', 'tex', 'coords'], ['u', 'near'])
    """
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def is_direction(name: str) -> bool:
    """Whether a name is one of a vector whose length is 1, as a rule."""
    return bool(_UNIT & set(words_of(name)[-2:]))


def is_place(name: str) -> bool:
    """Whether a name is one of a place, as a rule: two of them are seldom the same one."""
    return bool(_PLACES & set(words_of(name)))


def lower_one(name: str, names: Iterable[str]) -> str:
    """The input that is named as the lower one of a pair in which this one is the higher."""
    start, own = _split(name)
    for high, low in _ORDERS:
        if high in own:
            wanted = own.replace(high, low)
            for other in names:
                if _split(other) == (start, wanted):
                    return other
    return ""


def _split(name: str) -> tuple[str, str]:
    start, dot, own = name.rpartition(".")
    return start + dot, own.lower()


def keep_in_order(each: dict[str, Array], roles: Mapping[str, Role]) -> None:
    """Exchange values of inputs where the higher one of a pair is below the lower one."""
    for name, role in roles.items():
        if role.above in each and name in each and each[name].shape == each[role.above].shape:
            low, high = each[role.above], each[name]
            each[role.above], each[name] = np.minimum(low, high), np.maximum(low, high)


def unknown_names(given: Sequence[str], inputs: Iterable[str]) -> list[str]:
    """Which of the given names are no input's."""
    known = {*inputs, *(re.sub(r"\[\d+\]", "", name) for name in inputs)}
    return [name for name in given if name not in known]
