"""What a program reads from outside, and what its author says about it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from shaderlab.compiler.reflection import is_used, leaves, used_paths
from shaderlab.compiler.spirv import Op, StorageClass, type_name, unwrap
from shaderlab.errors import NotInterpretedError, UsageError
from shaderlab.model.frame import Array, Bindings, Fragments, Samples, Texels

from .interpreter import Program
from .interpreter.interpret import interface_name
from .interpreter.program import INPUTS
from .interpreter.values import NUMBERS, number_invocations

_RANGE = re.compile(r"//.*?\brange:\s*(\S+)\s*\.\.\s*(\S+)")
_UNIT = re.compile(r"//.*?\brange:\s*unit\b")
_DECLARED = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^]]*\]\s*)?(?:=[^;]*)?[;,]")
_ENDLESS = 4  # elements of an array whose length is known at run time only


@dataclass(frozen=True)
class Input:
    """One number, vector, matrix or texture that a program may read.

    Attributes:
        name: as the interpreter takes it: "lights[0].color".
        type: GLSL's name of it: "vec3", "sampler2D".
        uniform: whether all invocations of a draw have the same.
        workgroup: of what numbers a compute stage's invocations, the size of their workgroup.
    """

    name: str
    type: str
    uniform: bool
    workgroup: tuple[int, int, int] | None = None

    @property
    def whole(self) -> bool:
        """Whether its numbers are integers."""
        return self.type.startswith(("int", "ivec", "uint", "uvec"))


def inputs_of(program: Program) -> dict[str, Input]:
    """What a program's functions read, by name, in the order of declaration."""
    module = program.module
    paths = used_paths(module)
    found = {}
    for id_, (pointee, storage) in module.variables.items():
        if storage not in INPUTS:
            continue
        name = interface_name(program, id_)
        for leaf in leaves(module, pointee, name):
            if not is_used(paths.get(id_, ()), leaf.path):
                continue
            type_, uniform = type_name(module, leaf.type), storage != StorageClass.Input
            for each in _elements(unwrap(module, leaf.type)[0], leaf.name):
                size = program.local_size if each in NUMBERS else None
                found[each] = Input(each, type_, uniform, size)
    return found


def _elements(lengths: tuple[int, ...], name: str) -> Iterator[str]:
    if not lengths:
        yield name
        return
    for i in range(lengths[0] or _ENDLESS):
        yield from _elements(lengths[1:], f"{name}[{i}]")


def declared_ranges(program: Program) -> dict[str, str]:
    """What `// range:` says of each name declared in its line: "0..50", "unit"."""
    found: dict[str, str] = {}
    text = "" if program.source is None else program.source.text
    for line in text.splitlines():
        if "range:" not in line:
            continue
        code, _, _ = line.partition("//")
        pair = _RANGE.search(line)
        says = "unit" if _UNIT.search(line) else f"{pair[1]}..{pair[2]}" if pair else ""
        if says:
            found.update((name, says) for name in _DECLARED.findall(code))
    return found


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
_UNIT_roles = frozenset(
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
    return bool(_UNIT_roles & set(words_of(name)[-2:]))


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


_DERIVATIVES = range(Op.DPdx, Op.FwidthCoarse + 1)


@dataclass(frozen=True, eq=False)
class Given:
    """What some invocations get.

    Attributes:
        each: what differs between them, by name, a row for each.
        bindings: what does not.
        count: how many there are.
    """

    each: Mapping[str, Array]
    bindings: Bindings
    count: int

    def rows_with(self, rows: Array, program: Program) -> Array:
        """Some rows, and where the program asks for derivatives those of their quads."""
        places = self.each.get("gl_FragCoord")
        if places is None or not asks_for_neighbours(program, self.bindings):
            return rows
        cells = cells_of(places)
        return np.flatnonzero(np.isin(cells, cells[rows]))

    def part(self, rows: Array) -> Given:
        """Some of the invocations."""
        each = {n: v if len(v) == 1 else v[rows] for n, v in self.each.items()}
        return Given(each, self.bindings, len(rows))


def cells_of(places: Array) -> Array:
    """A number for the quad of each gl_FragCoord."""
    cell = np.floor(places[:, :2] / 2.0).astype(np.int64)
    found: Array = cell[:, 1] * (1 << 20) + cell[:, 0]
    return found


def asks_for_neighbours(program: Program, bindings: Bindings) -> bool:
    """Whether invocations depend on their quads: by derivatives, or by mipmaps."""
    if any(texels.filter[0] != texels.filter[1] for texels in bindings.textures.values()):
        return True
    return any(one.op in _DERIVATIVES for one in program.definitions.values())


def merged(givens: Sequence[Given], program: Program, most: int) -> list[Given]:
    """What several draws gave, as few sets: those with the same textures become one, in which
    uniforms differ between invocations; of each draw as many, `most` in all. Draws whose
    invocations depend on their neighbours stay apart."""
    found: list[Given] = []
    groups: dict[int, list[Given]] = {}
    for given in givens:
        if asks_for_neighbours(program, given.bindings):
            found.append(given)
        else:
            groups.setdefault(_looks(given.bindings), []).append(given)
    for group in groups.values():
        share = max(most // len(group), 16)
        parts = [
            g.part(np.unique(np.linspace(0, g.count - 1, min(share, g.count)).astype(int)))
            for g in group
        ]
        found.append(parts[0] if len(parts) == 1 else joined(parts))
    return found


def _looks(bindings: Bindings) -> int:
    """A number that is the same for the same textures."""
    parts: list[object] = []
    for name, texels in sorted(bindings.textures.items()):
        parts += [name, texels.filter, texels.wrap, texels.compare, texels.kind, texels.format]
        parts += [level.tobytes() for level in (texels.values, *texels.smaller)]
    return hash(tuple(parts))


def joined(parts: Sequence[Given]) -> Given:
    """Sets with the same textures as one, in which uniforms differ between invocations."""
    count = sum(part.count for part in parts)
    each = {}
    names = [{**part.each, **part.bindings.uniforms} for part in parts]
    for name in names[0]:
        if not all(name in others for others in names):
            continue  # another stage's, which not all of these draws have
        rows = []
        for part in parts:
            values = part.each.get(name)
            if values is None:
                values = np.asarray(part.bindings.uniforms[name])[None]
            rows.append(np.broadcast_to(values, (part.count, *values.shape[1:])))
        each[name] = np.concatenate(rows)
    return Given(each, replace(parts[0].bindings, uniforms={}), count)


def given_fragments(captured: Fragments, bindings: Bindings, most: int) -> Given:
    """What a draw gave its fragment shader, those pixels too that it discards."""
    captured = captured.undiscarded or captured
    y, x = np.nonzero(captured.covered)
    rows = whole_quads(x, y, most)
    at = (y[rows], x[rows])
    each = {name: values[at] for name, values in captured.inputs.items()}
    return Given({**each, "gl_FragCoord": captured.frag_coord[at]}, bindings, len(rows))


def given_vertices(captured: Samples, bindings: Bindings, most: int) -> Given:
    """What a draw gave its vertex shader."""
    inputs = (captured.entering or captured).inputs
    # Copied, for a part keeps the whole of an array alive.
    each = {name: values[:most].copy() for name, values in inputs.items()}
    return Given(each, bindings, max((len(values) for values in each.values()), default=0))


def whole_quads(x: Array, y: Array, most: int | None, always: Sequence[int] = ()) -> Array:
    """The pixels of quads from all over a picture, and those of the pixels `always`; all where
    there are not too many."""
    if most is None or len(x) <= most:
        return np.arange(len(x))
    seen = np.zeros(((int(y.max()) >> 1) + 1, (int(x.max()) >> 1) + 1), np.bool_)
    seen[y >> 1, x >> 1] = True
    rows, columns = np.nonzero(seen)
    taken = scattered(len(rows), most // 4)
    seen[:] = False
    seen[rows[taken], columns[taken]] = True
    seen[y[list(always)] >> 1, x[list(always)] >> 1] = True
    return np.flatnonzero(seen[y >> 1, x >> 1])


def scattered(count: int, most: int) -> Array:
    """`most` of so many numbers from 0, one at random from each of as many equal stretches: in the
    order of a picture's pixels they follow no pattern of it. The same ones at each call."""
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, most + 1)
    found = edges[:-1] + np.random.default_rng(0).random(most) * np.diff(edges)
    numbers = np.minimum(found.astype(np.int64), count - 1)
    return numbers[np.diff(numbers, prepend=-1) > 0]


_SIDE = 8  # of a texture
_CORNERS = 0.08  # the share of numbers that are an end of their range, 0 or 1
_PIXELS = 64  # in a row


def drawn(inputs: Mapping[str, Input], roles: Mapping[str, Role], count: int, seed: int) -> Given:
    """Inputs for `count` invocations, uniforms as well, which differ between them here.

    Raises:
        NotInterpretedError: there is a texture of a kind that has no formula.
    """
    rng = np.random.default_rng([19, seed])
    each: dict[str, Array] = {}
    textures: dict[str, Texels] = {}
    size = None
    for name, one in inputs.items():
        role = roles[name]
        if one.workgroup:
            size = one.workgroup
        elif role.kind == "texture":
            textures[name] = _texture(one, rng)
        elif name in ("gl_VertexID", "gl_VertexIndex"):
            each[name] = np.arange(count, dtype=np.int64)[:, None]
        elif name == "gl_FragCoord":
            each[name] = _places(count, rng)
        elif "mat" in one.type:
            each[name] = _matrices(one.type, role, count, rng)
        else:
            each[name] = _numbers(one.type, role, count, rng)
    if size is not None:
        groups = rng.integers(0, WORKGROUPS, (count, 3))
        each |= number_invocations(size, groups, rng.integers(0, size, (count, 3)))
    keep_in_order(each, roles)
    if "gl_FragCoord" not in each:
        each["gl_FragCoord"] = _places(count, rng)  # of derivatives' neighbours
    return Given(each, Bindings(textures=textures), count)


def _numbers(type_: str, role: Role, count: int, rng: np.random.Generator) -> Array:
    size = int(type_[-1]) if type_[-1].isdigit() else 1
    if role.kind == "unit":
        v = rng.normal(size=(count, size))
        few = rng.random(count) < _CORNERS  # along an axis
        v[few] = np.sign(v[few]) * (np.abs(v[few]) == np.abs(v[few]).max(axis=1, keepdims=True))
        found: Array = (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)
        return found
    if type_.startswith(("int", "ivec", "uint", "uvec", "bool", "bvec")):
        whole = rng.integers(int(role.low), int(role.high) + 1, (count, size))
        if role.high - role.low > 2.0**16:  # of each magnitude as many
            whole = whole >> rng.integers(0, 32, (count, size))
            return whole % 2**32 if type_[0] == "u" else whole
        return whole if type_[0] == "i" else np.abs(whole) if type_[0] == "u" else whole > 0
    x = rng.uniform(role.low, role.high, (count, size))
    if role.low > 0.0 and role.high > 20.0 * role.low:  # of each magnitude as many
        x = np.exp(rng.uniform(np.log(role.low), np.log(role.high), (count, size)))
    ends = np.array([e for e in (role.low, role.high, 0.0, 1.0) if role.low <= e <= role.high])
    corner = rng.random((count, size)) < _CORNERS
    x = np.where(corner, rng.choice(ends, (count, size)), x)
    return np.asarray(np.clip(x.astype(np.float32), role.low, role.high), np.float32)


def _places(count: int, rng: np.random.Generator) -> Array:
    i = np.arange(count)
    x, y = i % _PIXELS + 0.5, i // _PIXELS + 0.5
    z, w = rng.uniform(0.0, 1.0, count), 1.0 / rng.uniform(0.5, 50.0, count)
    return np.stack([x, y, z, w], axis=1).astype(np.float32)


def _matrices(type_: str, role: Role, count: int, rng: np.random.Generator) -> Array:
    """Matrices as the interpreter has them, (count, rows, columns)."""
    columns, rows = (int(d) for d in (type_[3:].split("x") * 2)[:2])
    if role.kind == "number" or columns != rows:
        return rng.uniform(role.low, role.high, (count, rows, columns)).astype(np.float32)
    size = columns
    found = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    if role.kind == "projection" and size == 4:
        focal, aspect = rng.uniform(0.7, 2.5, count), rng.uniform(0.5, 2.0, count)
        near, far = rng.uniform(0.1, 1.0, count), rng.uniform(5.0, 100.0, count)
        found[:, 0, 0], found[:, 1, 1] = focal / aspect, focal
        found[:, 2, 2], found[:, 2, 3] = (far + near) / (near - far), 2 * far * near / (near - far)
        found[:, 3, 2], found[:, 3, 3] = -1.0, 0.0
        return found.astype(np.float32)
    turn = min(size, 3)
    q, _ = np.linalg.qr(rng.normal(size=(count, turn, turn)))
    q = q * np.sign(np.linalg.det(q))[:, None, None] if turn == 3 else q
    if role.kind == "affine":
        q = q * rng.uniform(0.4, 2.5, (count, 1, turn))
        found[:, :3, 3] = rng.uniform(-4.0, 4.0, (count, 3))
    found[:, :turn, :turn] = q
    return found.astype(np.float32)


_SHAPES: Mapping[str, Callable[[int], tuple[int, ...]]] = {
    "2D": lambda n: (n, n, 4),
    "2DArray": lambda n: (4, n, n, 4),
    "Cube": lambda n: (6, n, n, 4),
    "2DMS": lambda n: (4, n, n, 4),
}


def _texture(one: Input, rng: np.random.Generator) -> Texels:
    """A small texture; one of normals holds unit vectors, by 0.5 + 0.5 n."""
    kind = one.type.partition("sampler")[2]
    shadow = kind.endswith("Shadow")
    kind = kind.removesuffix("Shadow")
    if kind not in _SHAPES or not one.type.startswith("sampler"):
        raise NotInterpretedError(f"not interpreted: {one.type} {one.name}")
    values = rng.uniform(0.02, 1.0, _SHAPES[kind](_SIDE))
    if "normal" in words_of(one.name):
        n = rng.normal(size=(*values.shape[:-1], 3))
        n[..., 2] = np.abs(n[..., 2])
        values[..., :3] = 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)
    plain = ("nearest", "nearest") if kind == "2DMS" else ("linear", "linear")
    return Texels(
        values.astype(np.float32), plain, ("repeat", "repeat"), (0.0,) * 4,
        kind=kind, compare="lequal" if shadow else None,
    )  # fmt: skip


_NEAR = 1e-3  # how far from 1 the length of a unit vector is found
_AFFINE = np.array([0.0, 0.0, 0.0, 1.0])


def learned(captured: Sequence[Given]) -> dict[str, Role]:
    """What the captures' floats are, by name."""
    values: dict[str, list[Array]] = {}
    for given in captured:
        for name, rows in [*given.each.items(), *given.bindings.uniforms.items()]:
            array = np.asarray(rows)
            if array.dtype.kind == "f" and name != "gl_FragCoord":
                own = array if name in given.each else array[None]
                values.setdefault(name, []).append(own)
    found = {name: _role(name, arrays) for name, arrays in values.items()}
    for name, role in found.items():
        lower = lower_one(name, found)
        if lower and role.kind == found[lower].kind == "number":
            found[name] = replace(role, above=lower)
    return found


def _role(name: str, arrays: Sequence[Array]) -> Role:
    shape = arrays[0].shape[1:]
    flat = np.concatenate([a.reshape(-1, *shape[-1:]) for a in arrays])
    if len(shape) == 2 and shape[0] == shape[1] and shape[0] > 1:
        whole = np.concatenate(arrays).astype(np.float64)
        turn = whole[:, :3, :3]
        square = turn @ np.swapaxes(turn, 1, 2)
        if shape[0] < 4 or (whole[:, 3] == _AFFINE).all():
            turns = np.abs(square - np.eye(turn.shape[1])).max() < _NEAR
            moves = shape[0] == 4 and not (whole[:, :3, 3] == 0.0).all()
            return Role("rotation" if turns and not moves else "affine", source="learned")
        return Role("projection", source="learned")
    with np.errstate(all="ignore"):
        length = np.linalg.norm(flat.astype(np.float64), axis=-1)
        unit = shape[-1:] in ((2,), (3,)) and bool((np.abs(length - 1.0) < _NEAR).all())
        if unit and (is_direction(name) or (flat < 0.0).any()):
            return Role("unit", source="learned")
        low = 0.0 if flat.min(initial=0.0) >= 0.0 else -np.inf
        high = 1.0 if low == 0.0 and flat.max(initial=0.0) <= 1.0 else np.inf
    return Role("number", low, high, "learned")


def varied(given: Given, roles: Mapping[str, Role], seed: int) -> Given:
    """Other inputs of the same roles: uniforms differ between quads of pixels now, and texels have
    changed places."""
    rng = np.random.default_rng([29, seed])
    group = _groups(given)
    each = dict(given.each)
    for name, values in given.bindings.uniforms.items():
        array = np.asarray(values)
        if name in roles and name not in each:
            each[name] = np.repeat(array[None], given.count, axis=0)
    for name, role in roles.items():
        if name in each:
            each[name] = _varied(each[name], role, group, rng)
    keep_in_order(each, roles)
    if "gl_FragCoord" in each:
        each["gl_FragCoord"] = _moved(each["gl_FragCoord"], rng)
    textures = {name: _shuffled(texels, rng) for name, texels in given.bindings.textures.items()}
    return Given(each, replace(given.bindings, textures=textures), given.count)


def _groups(given: Given) -> Array:
    """A number for each invocation, the same in a quad of pixels."""
    places = given.each.get("gl_FragCoord")
    if places is None:
        return np.arange(given.count)
    found: Array = np.unique(cells_of(places), return_inverse=True)[1].ravel()
    return found


def _moved(places: Array, rng: np.random.Generator) -> Array:
    """The pixels elsewhere: at the lower left corner, or near it; quads stay whole."""
    found = places.copy()
    for axis in (0, 1):
        start = 2.0 * np.floor(found[:, axis].min() / 2.0)
        found[:, axis] += rng.choice([0.0, 2.0 * rng.integers(1, 32)]) - start
    return found


def _varied(values: Array, role: Role, group: Array, rng: np.random.Generator) -> Array:
    """Values of the same role, changed alike in each group."""
    count, shape = int(group.max(initial=0)) + 1, values.shape[1:]
    if len(values) == 1:
        values = np.repeat(values, len(group), axis=0)
    x = values.astype(np.float64)
    if role.kind in ("rotation", "affine", "projection") and len(shape) == 2:
        return _turned(x, role, group, count, rng)
    if role.kind == "unit":
        x = x + rng.normal(scale=0.4, size=(count, *shape))[group]
        return np.asarray(x / np.linalg.norm(x, axis=-1, keepdims=True), np.float32)
    size = max(float(np.nanmax(np.abs(x), initial=0.0)), 0.1)
    x = x * np.exp(rng.uniform(-0.7, 0.7, (count, *shape)))[group]
    low = 0.0 if role.low == 0.0 else -1.0
    moved = rng.uniform(low, 1.0, (count, *shape)) * 0.2 * size
    x = x + np.where(rng.random((count, *shape)) < 0.5, moved, 0.0)[group]
    if role.source != "learned":  # what was learned does not hold: signs are free
        x = np.where((rng.random((count, *shape)) < 0.3)[group], -x, x)
    return np.asarray(np.clip(x, role.low, role.high), np.float32)


def _turned(x: Array, role: Role, group: Array, count: int, rng: np.random.Generator) -> Array:
    size = x.shape[-1]
    if role.kind == "projection":
        return np.asarray(
            x * np.exp(rng.uniform(-0.3, 0.3, (count, size, size)))[group], np.float32
        )
    turn = min(size, 3)
    q, r = np.linalg.qr(np.eye(turn) + 0.3 * rng.normal(size=(count, turn, turn)))
    by = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    by[:, :turn, :turn] = q * np.sign(np.einsum("nii->ni", r))[:, None, :]
    if role.kind == "affine":
        by[:, :turn, :turn] *= np.exp(rng.uniform(-0.3, 0.3, (count, 1, turn)))
    if role.kind == "affine" and size == 4:
        by[:, :3, 3] = rng.uniform(-0.3, 0.3, (count, 3))
    return np.asarray(x @ by[group], np.float32)


def _shuffled(texels: Texels, rng: np.random.Generator) -> Texels:
    def mixed(values: Array) -> Array:
        flat = values.reshape(-1, values.shape[-1])
        return flat[rng.permutation(len(flat))].reshape(values.shape)

    smaller = tuple(mixed(level) for level in texels.smaller)
    return replace(texels, values=mixed(texels.values), smaller=smaller)
