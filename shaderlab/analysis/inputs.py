"""What a program reads, which values each input may have, and samples of those."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from shaderlab.compiler.reflection import is_used, leaves, used_paths
from shaderlab.compiler.spirv import Decoration, StorageClass, image_format, type_name, unwrap
from shaderlab.errors import NotInterpretedError, UsageError, suggest
from shaderlab.model.frame import Array, Bindings, Texels

from .batches import InputBatch, join_batches, quads_of
from .interpreter import Program
from .interpreter.interpret import interface_name
from .interpreter.program import INPUTS
from .interpreter.values import NUMBERS, Size, number_invocations

_RANGE = re.compile(r"//.*?\brange:\s*(unit\b|\S+\s*\.\.\s*\S+)")
# RetroArch's: a name, what it is called, the default, the least and the greatest value.
_NUMBER = r"\s+(-?(?:\d+\.?\d*|\.\d+))(?=\s)"
_PARAMETER = re.compile(
    rf'^[ \t]*#pragma parameter (\w+)\s+"[^"]*"\s+\S+{_NUMBER}{_NUMBER}', re.MULTILINE
)
_DECLARED = re.compile(r"([A-Za-z_]\w*)\s*(?:\[[^]]*\]\s*)?(?:=[^;]*)?[;,]")
_WHOLE = 2.0**31
_LAYOUT = re.compile(r"\blayout\s*\([^)]*\)")
ALIKE = 0.01
"""Constants that differ by less may be meant to be one."""
_MOST_ELEMENTS = 2048  # of a variable: each is given its own values
MOST_NUMBERS = 2**20
"""How many numbers the invocations of a batch are given in all: where arrays are large, there are
fewer invocations."""
_FEWEST = 128  # invocations: two rows of quads
_ENDLESS = 4  # elements of an array whose length is known at run time only


@dataclass(frozen=True)
class Input:
    """One number, vector, matrix or texture that a program may read, by its name as the interpreter
    takes it ("lights[0].color"), with GLSL's type ("vec3", "sampler2D"). It is `uniform` if all
    pixels of a quad have the same, as of flat inputs; `workgroup` is the size of that whose
    invocations it numbers, `channels` how many components the texels of an image have."""

    name: str
    type: str
    uniform: bool
    workgroup: tuple[int, int, int] | None = None
    channels: int = 4

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return math.prod(_sides(self.type))

    @property
    def whole(self) -> bool:
        """Whether its numbers are integers."""
        return self.type.startswith(("int", "ivec", "uint", "uvec"))


def _sides(type_: str) -> tuple[int, ...]:
    """The columns and rows of a matrix, the components of a vector, 1 of anything else."""
    if type_.startswith("mat"):
        return tuple(map(int, (type_[3:].split("x") * 2)[:2]))
    return (int(type_[-1]) if type_[-1].isdigit() else 1,)


Inputs = Mapping[str, Input]


def inputs_of(program: Program) -> dict[str, Input]:
    """What a program's functions read, by name, in the order of declaration."""
    module = program.module
    paths = used_paths(module)
    found = {}
    for id_, (pointee, storage) in module.variables.items():
        if storage not in INPUTS:
            continue
        name = interface_name(program, id_)
        count = 0
        for number, leaf in enumerate(leaves(module, pointee, name)):
            lengths = unwrap(module, leaf.type)[0]
            used = is_used(paths.get(id_, ()), leaf.path)
            count += used * math.prod(lengths)
            if max(count, number) > _MOST_ELEMENTS:
                array = leaf.name.partition("[")[0]
                raise NotInterpretedError(
                    f"not interpreted: {array} has more than {_MOST_ELEMENTS:,} elements",
                    remedy="give its array a length that the shader needs",
                )
            if not used:
                continue
            flat = module.decorated(id_, Decoration.Flat) is not None
            type_, uniform = type_name(module, leaf.type), flat or storage != StorageClass.Input
            if type_ in ("sampler", "samplerShadow"):  # the texture is all that is read
                continue
            for each in _elements(lengths, leaf.name):
                size = program.local_size if each in NUMBERS else None
                of = re.match(r"(rg?)(?:8|16|32|64)", image_format(module, leaf.type))
                found[each] = Input(each, type_, uniform, size, len(of[1]) if of else 4)
    return found


def _elements(lengths: tuple[int, ...], name: str) -> Iterator[str]:
    if not lengths:
        yield name
        return
    for i in range(lengths[0] or _ENDLESS):
        yield from _elements(lengths[1:], f"{name}[{i}]")


def find_declared_ranges(program: Program) -> dict[str, str]:
    """The `// range:` of each name declared in its line: "0..50", "unit"; and that of a parameter
    (`#pragma parameter`)."""
    text = "" if program.source is None else program.source.text
    found = {name: f"{least}..{most}" for name, least, most in _PARAMETER.findall(text)}
    for line in text.splitlines():
        said = _RANGE.search(line)
        if said:
            code = _LAYOUT.sub("", line.partition("//")[0])
            found.update((name, "".join(said[1].split())) for name in _DECLARED.findall(code))
    return found


Kind = Literal["number", "unit", "rotation", "affine", "projection", "texture", "mipmaps"]

_IN_WORDS: Mapping[str, str] = {
    "unit": "of length 1", "projection": "a perspective projection", "rotation": "a rotation",
    "affine": "a matrix that turns, scales and moves", "texture": "any texels within 0..1",
}  # fmt: skip


@dataclass(frozen=True)
class InputDomain:
    """Which values an input is given.

    Attributes:
        kind: numbers between `low` and `high`, vectors of length 1 (the square of whose length lies
            between them), matrices that turn, those that turn, scale and move, those of a
            perspective, or textures.
        source: "given" by --range, "declared" in a comment, "learned" from captures,
            or "assumed".
        above: the name of an input than which this one is not less.
        constants: numbers to try besides: what the programs compare theirs with, for example.
    """

    kind: Kind
    low: float = 0.0
    high: float = 1.0
    source: Literal["given", "declared", "assumed", "learned"] = "assumed"
    above: str = ""
    constants: tuple[float, ...] = ()

    def condition(self, name: str) -> str:
        """What holds of the input's values, as a formula."""
        if self.kind == "unit":
            return f"|{name}| = 1"
        if self.kind == "texture":
            return f"{name} has no mipmaps and no texel above 1"
        if self.kind != "number":
            return f"{name} is {_IN_WORDS[self.kind]}"
        low = f"{self.low:g} <= " if np.isfinite(self.low) else ""
        high = f" <= {self.high:g}" if np.isfinite(self.high) else ""
        return f"{low}{name}{high}"

    def __str__(self) -> str:
        text = _IN_WORDS.get(self.kind, f"{self.low:g}..{self.high:g}")
        return f"{text}, >= {self.above}" if self.above else text

    def clip(self, values: Array) -> Array:
        """The nearest values of the domain, float32; of numbers and of unit vectors."""
        if self.kind == "unit":
            with np.errstate(all="ignore"):
                values = values / np.linalg.norm(values, axis=1, keepdims=True)
            middle = values.shape[1] ** -0.5  # of opposite vectors there is none
            return np.nan_to_num(values, nan=middle).astype(np.float32)
        return np.clip(values, self.low, self.high).astype(np.float32)

    @property
    def relaxed(self) -> InputDomain | None:
        """The domain without its assumption; None if it is none, or can't be dropped."""
        if self.source in ("given", "declared") or self.kind in ("projection", "mipmaps"):
            return None
        if self.kind == "texture":
            return InputDomain("mipmaps")
        if self.source == "learned":
            free = InputDomain("number", -np.inf, np.inf, "given")
            return free if self.kind == "unit" or self.low == 0.0 else None
        if self.kind in ("unit", "rotation", "affine"):
            return InputDomain("number", -2.0, 2.0)
        wide = self.high - self.low
        return InputDomain("number", self.low - wide, self.high + wide)


Domains = Mapping[str, InputDomain]
_GIVE = 1e-6  # of the square of a vector's length
UNIT_VECTOR = InputDomain("unit", 1.0 - _GIVE, 1.0 + _GIVE)
# By a word of the name: the last one that is here counts.
_RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("position", "pos", "eye", "target", "origin"), (-4.0, 4.0)),
    **dict.fromkeys(("world", "offset", "center"), (-4.0, 4.0)),
    **dict.fromkeys(("color", "colour", "albedo", "ambient", "diffuse", "specular"), (0.0, 1.0)),
    **dict.fromkeys(("alpha", "opacity", "metallic", "ao", "mask", "strength"), (0.0, 1.0)),
    "roughness": (0.05, 1.0),
    **dict.fromkeys(("uv", "coord", "st"), (-0.5, 1.5)),
    **dict.fromkeys(("shininess", "power", "exponent"), (1.0, 128.0)),
    "ior": (1.0, 3.0),
    "cut": (0.5, 1.0),
    "gamma": (1.5, 3.0),
    "exposure": (0.1, 4.0),
    "near": (0.1, 1.0),
    "far": (5.0, 100.0),
    "distance": (0.1, 20.0),
    "time": (0.0, 20.0),
    "dt": (0.01, 0.1),
    **dict.fromkeys(("angle", "yaw", "pitch", "roll", "phase"), (-3.2, 3.2)),
    **dict.fromkeys(("radius", "scale", "aspect", "focal"), (0.1, 4.0)),
    **dict.fromkeys(("resolution", "viewport", "size"), (16.0, 1024.0)),
    "constant": (0.5, 1.5),
}  # fmt: skip
_PLACES = frozenset(
    {"position", "positions", "pos", "eye", "target", "origin", "world", "center", "uv", "coord",
     "coords", "st"}
)  # fmt: skip
_DIRECTIONS = frozenset(
    {"normal", "dir", "direction", "halfway", "tangent", "bitangent", "axis", "up", "forward"}
)
_LETTERS = frozenset("NLVHTBR")  # as in N · L; of papers, and of shaders after them
_ORDERS = (
    ("cutoff", "outercutoff"), ("far", "near"), ("max", "min"), ("high", "low"), ("end", "start"),
    ("edge1", "edge0"), ("most", "least"),
)  # fmt: skip
WORKGROUPS = 4
"""Workgroups of a compute stage in each direction."""
_BUILT_IN = {
    "gl_NumWorkGroups": (WORKGROUPS, WORKGROUPS), "gl_FragCoord": (0.0, 16384.0),
    "gl_FrontFacing": (0.0, 1.0), "gl_PointCoord": (0.0, 1.0), "gl_PrimitiveID": (0.0, 64.0),
    "gl_InstanceID": (0.0, 8.0), "gl_InstanceIndex": (0.0, 8.0), "gl_SampleID": (0.0, 3.0),
    "iResolution": (1.0, 4096.0), "iTime": (0.0, 3600.0), "iTimeDelta": (0.0, 1.0),
    "iMouse": (-4096.0, 4096.0), "iFrame": (0.0, 216_000.0), "iFrameRate": (0.0, 240.0),
}  # fmt: skip


def domains_of(
    inputs: Inputs, programs: Sequence[Program], ranges: Mapping[str, str]
) -> dict[str, InputDomain]:
    """The role of each input, by name: of `ranges` ("a..b", "a:b" or "unit" by whole name, of all
    elements of an array or of one), else of a comment, else as the name and the type suggest.
    Raises UsageError: what is given is no range, or of what no program reads."""
    for name in unknown_names(list(ranges), inputs):
        raise UsageError(f"the shader does not read {name!r}", remedy=suggest(name, inputs))
    declared = {name: text for one in programs for name, text in find_declared_ranges(one).items()}
    found = {}
    for one in inputs.values():
        plain = re.sub(r"\[\d+\]", "", one.name)
        said = ranges.get(one.name, ranges.get(plain, ""))
        # Of a line with several names, those of numbers.
        comment = "" if "sampler" in one.type else declared.get(plain.rpartition(".")[2], "")
        if said or comment:
            domain = _parse_range(said or comment, one.name)
            found[one.name] = replace(domain, source="given" if said else "declared")
        else:
            found[one.name] = _assume_domain(one)
    add_orders(found)
    return found


def add_constants(
    domains: Domains, inputs: Inputs, programs: Sequence[Program]
) -> dict[str, InputDomain]:
    """The domains of numbers with the programs' own constants to try; of an integer those beyond
    its assumed range, too: `id == 12345` is true for no other."""
    constants = sorted({number for program in programs for number in program.numbers})
    near = [(a + b) / 2.0 for a, b in itertools.pairwise(constants) if 0.0 < b - a < ALIKE * abs(b)]
    constants = sorted({*constants, *near})  # between 0.00313 and 0.0031308
    found = dict(domains)
    for name, domain in domains.items():
        if domain.kind == "number" and name in inputs and "mat" not in inputs[name].type:
            beyond = inputs[name].whole and domain.source == "assumed" and name[:3] != "gl_"
            low, high = (-_WHOLE, 2.0 * _WHOLE) if beyond else (domain.low, domain.high)
            own = tuple(n for n in constants if low < n < high and n not in (0.0, 1.0))
            found[name] = replace(domain, constants=own)
    return found


def _parse_range(text: str, name: str) -> InputDomain:
    if text == "unit":
        return UNIT_VECTOR
    parts = re.split(r"\.\.|:", text)
    try:
        low, high = map(float, parts)
    except ValueError:
        low, high = 1.0, 0.0
    if not -1e38 < low <= high < 1e38:
        raise UsageError(f"{name}: {text!r} is no range", remedy="write a..b, a:b or unit")
    return InputDomain("number", low, high)


def _assume_domain(one: Input) -> InputDomain:
    words = words_of(one.name)
    if re.search("sampler|texture|image", one.type):
        return InputDomain("texture")
    if one.workgroup is not None:
        local = max(one.workgroup) if one.type == "uvec3" else math.prod(one.workgroup)
        groups = 1 if "Local" in one.name else WORKGROUPS
        return InputDomain("number", 0.0, groups * (1 if "Group" in one.name else local) - 1.0)
    if one.name in _BUILT_IN:
        return InputDomain("number", *_BUILT_IN[one.name])
    if "mat" in one.type:
        turns = one.type != "mat4" or {"rotation", "normal", "turn"} & set(words)
        return InputDomain(
            "projection" if "projection" in words else "rotation" if turns else "affine"
        )
    if one.type in ("vec2", "vec3") and is_direction(one.name):
        return UNIT_VECTOR
    if one.type in ("bool", "bvec2", "bvec3", "bvec4"):
        return InputDomain("number")
    if not one.type.startswith(("float", "vec")):
        return InputDomain("number", 0.0, 4.0)
    for word in reversed(words):
        found = _RANGES.get(word) or _RANGES.get(word.removesuffix("s"))  # lights, lightColors
        if found is not None:
            return InputDomain("number", *found)
    if one.name.lower().endswith("f0"):  # the share that is reflected straight on
        return InputDomain("number", 0.0, 1.0)
    return InputDomain("number") if one.type == "float" else InputDomain("number", -2.0, 2.0)


def words_of(name: str) -> list[str]:
    """The words of a name.

    >>> words_of("light.outerCutOff"), words_of("aTexCoords"), words_of("u_near")
    (['light', 'outer', 'cut', 'off'], ['a', 'tex', 'coords'], ['u', 'near'])
    """
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def is_direction(name: str) -> bool:
    """Whether a name is one of a vector whose length is 1, as a rule."""
    words = words_of(name)[-2:]
    letter = name.rpartition(".")[2] in _LETTERS
    return letter or bool(_DIRECTIONS & {*words, *(word.removesuffix("s") for word in words)})


def is_place(name: str) -> bool:
    """Whether a name is one of a place, as a rule: two of them are seldom the same one."""
    return bool(_PLACES & set(words_of(name)))


def add_orders(domains: dict[str, InputDomain]) -> None:
    """Note of each number that is named as the higher one of a pair which one is the lower."""
    names = {name.lower(): name for name, domain in domains.items() if domain.kind == "number"}
    for higher, name in names.items():
        start, dot, own = higher.rpartition(".")
        for high, low in _ORDERS:
            lower = names.get(start + dot + own.replace(high, low), name)
            if lower != name:
                domains[name] = replace(domains[name], above=lower)


def keep_in_order(each: dict[str, Array], domains: Domains) -> None:
    """Exchange values of inputs where the higher one of a pair is below the lower one."""
    for name, domain in domains.items():
        if domain.above in each and name in each and each[name].shape == each[domain.above].shape:
            low, high = each[domain.above], each[name]
            each[domain.above], each[name] = np.minimum(low, high), np.maximum(low, high)


def unknown_names(ranges: Sequence[str], inputs: Iterable[str]) -> list[str]:
    """Which of the given names are no input's."""
    known = {*inputs, *(re.sub(r"\[\d+\]", "", name) for name in inputs)}
    return [name for name in ranges if name not in known]


_SIDES, _FACE_SIDES = (8, 32), (8, 16)  # of textures; loops over all of a cube's texels end
_CORNERS = 0.08  # the share of numbers that are an end of their range, 0 or 1
_BYTES = (0, 1, 0x7F, 0x80, 0xFF)  # of words: ends of what fields in them may hold
_PIXELS = 64  # in a row


def sample_inputs(
    inputs: Inputs, domains: Domains, count: int, seed: int, together: Size | None = None
) -> InputBatch:
    """Inputs for `count` invocations, uniforms as well, which differ between them here; or between
    whole workgroups of a size. Raises NotInterpretedError: there is a texture of a kind that has no
    formula."""
    group = math.prod(together or (1,))
    most = MOST_NUMBERS // (1 + sum(one.size for one in inputs.values())) // _FEWEST * _FEWEST
    count = max(min(count, max(most, _FEWEST)) // group, 1) * group
    rng = np.random.default_rng([19, seed])
    each: dict[str, Array] = {}
    textures: dict[str, Texels] = {}
    size = None
    for name, one in inputs.items():
        domain = domains[name]
        if one.workgroup:
            size = one.workgroup
        elif domain.kind in ("texture", "mipmaps"):
            textures[name] = _texture(one, rng, mipmaps=domain.kind == "mipmaps")
        elif name in ("gl_VertexID", "gl_VertexIndex"):
            each[name] = np.arange(count, dtype=np.int64)[:, None]
        elif name == "gl_FragCoord":
            each[name] = _places(count, rng)
        elif "mat" in one.type:
            each[name] = _matrices(one.type, domain, count, rng)
        else:
            each[name] = _numbers(one.type, domain, count, rng)
    if size is not None:
        groups = rng.integers(0, WORKGROUPS, (count, 3))
        each |= number_invocations(size, groups, rng.integers(0, size, (count, 3)))
    if together is not None:
        each = {name: values[np.arange(count) // group * group] for name, values in each.items()}
        local = np.stack(np.unravel_index(np.arange(count) % group, together[::-1])[::-1], axis=1)
        each |= number_invocations(together, each.get(NUMBERS[0], 0 * local), local)
    keep_in_order(each, domains)
    if "gl_FragCoord" not in each:
        each["gl_FragCoord"] = _places(count, rng)  # of derivatives' neighbours
    batch = InputBatch(each, Bindings(textures=textures), count)
    mipmapped = any(texels.filter[0] != texels.filter[1] for texels in textures.values())
    return smooth_quads(batch, inputs, domains) if mipmapped else batch


def _numbers(type_: str, domain: InputDomain, count: int, rng: np.random.Generator) -> Array:
    (size,) = _sides(type_)
    if domain.kind == "unit":
        v = rng.normal(size=(count, size))
        few = rng.random(count) < _CORNERS  # along an axis
        v[few] = np.sign(v[few]) * (np.abs(v[few]) == np.abs(v[few]).max(axis=1, keepdims=True))
        return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True), np.float32)
    if type_.startswith(("int", "ivec", "uint", "uvec", "bool", "bvec")):
        whole = rng.integers(int(domain.low), int(domain.high) + 1, (count, size))
        few = rng.random(whole.shape) < _CORNERS
        if domain.high - domain.low > 2.0**16:  # of each magnitude as many
            whole = whole >> rng.integers(0, 32, (count, size))
            whole[few] = (rng.choice(_BYTES, (count, size, 4)) @ 256 ** np.arange(4))[few]
            return whole % 2**32 if type_[0] == "u" else whole.astype(np.int32).astype(np.int64)
        if type_[0] == "b":
            return whole > 0
        if own := [int(n) for n in domain.constants if n == int(n)]:
            whole[few] = rng.choice(own, whole.shape)[few]
        return whole.astype(np.int32).astype(np.int64) if type_[0] == "i" else np.abs(whole)
    x = rng.uniform(domain.low, domain.high, (count, size))
    if domain.low > 0.0 and domain.high > 20.0 * domain.low:  # of each magnitude as many
        x = np.exp(rng.uniform(np.log(domain.low), np.log(domain.high), (count, size)))
    tried = (domain.low, domain.high, 0.0, 1.0, *domain.constants)
    ends = np.array([e for e in tried if domain.low <= e <= domain.high])
    often = (np.arange(count) % 4 == 0)[:, None] & bool(domain.constants)
    corner = rng.random((count, size)) < np.where(often, 0.5, _CORNERS)
    x = np.where(corner, rng.choice(ends, (count, size)), x)
    return np.asarray(np.clip(x.astype(np.float32), domain.low, domain.high), np.float32)


def _places(count: int, rng: np.random.Generator) -> Array:
    i = np.arange(count)
    x, y = i % _PIXELS + 0.5, i // _PIXELS + 0.5
    z, w = rng.uniform(0.0, 1.0, count), 1.0 / rng.uniform(0.5, 50.0, count)
    return np.stack([x, y, z, w], axis=1).astype(np.float32)


def smooth_quads(batch: InputBatch, inputs: Inputs, domains: Domains) -> InputBatch:
    """Invocations whose inputs change from pixel to pixel as in draws: a quad's get the same
    uniforms, and varyings that are more alike in some quads than in others."""
    places, rng = batch.each["gl_FragCoord"], np.random.default_rng(17)
    _, first, of = np.unique(quads_of(places), return_index=True, return_inverse=True)
    share = 2.0 ** rng.uniform(-9.0, 0.0, (len(first), 1))[of.ravel()]
    each = {name: values[first][of.ravel()] for name, values in batch.each.items()}
    for name, same in each.items():
        varies = name in inputs and not inputs[name].uniform
        if varies and same.dtype.kind == "f" and same.ndim == 2:  # a matrix stays one
            each[name] = domains[name].clip(same + share * (batch.each[name] - same))
    return replace(batch, each={**each, "gl_FragCoord": places})


_STEPS = 16  # of the largest number
_COARSE = 2048


def coarsen_inputs(batch: InputBatch, domains: Domains) -> InputBatch:
    """The same invocations with numbers of so few bits that sums and products are exact and often
    equal: what is compared meets its bounds. Vectors are often those before, unit vectors lie along
    an axis, matrices only move, textures are flat in places."""
    batch = batch.part(np.arange(min(batch.count, _COARSE)))
    each, rng = dict(batch.each), np.random.default_rng(31)
    before: dict[tuple[int, ...], Array] = {}  # by shape
    for name, domain in domains.items():
        values = each.get(name)
        if values is None or values.dtype.kind != "f" or name == "gl_FragCoord":
            continue
        if domain.kind in ("rotation", "affine"):
            step = _coarse_step(values)
            each[name] = values * np.float32(0.0) + np.eye(*values.shape[1:], dtype=np.float32)
            each[name][:, :3, 3:] = step * np.round(values[:, :3, 3:] / step)
        elif domain.kind == "unit":
            size = np.abs(values)
            values = np.where(size == size.max(axis=-1, keepdims=True), values, 0.0)
            each[name] = np.sign(values).astype(np.float32)
        elif domain.kind == "number":
            step = _coarse_step(values)
            least, most = np.ceil(domain.low / step), np.floor(domain.high / step)
            if least <= most:
                whole = np.where(rng.random(values.shape) < 0.25, np.round(values), values)
                values = step * np.clip(np.round(whole / step), least, most)
                again = rng.random(len(values)) < _CORNERS
                values[again] = before.get(values.shape, values)[again]
                each[name] = before[values.shape] = domain.clip(values)
    return InputBatch(each, coarsen_textures(batch.bindings, domains), batch.count)


def _coarse_step(values: Array) -> float:
    return float(2.0 ** np.ceil(np.log2(max(float(np.abs(values).max()), 1e-30) / _STEPS)))


def coarsen_textures(bindings: Bindings, made_up: Container[str]) -> Bindings:
    """Textures that are flat in places, 0 or as much as their largest texel, 1 of those that are
    made up; but for normals."""
    textures = dict(bindings.textures)
    for name, texels in textures.items():
        if "normal" not in words_of(name):
            levels = [
                _coarsen(level, name in made_up) for level in (texels.values, *texels.smaller)
            ]
            textures[name] = replace(texels, values=levels[0], smaller=tuple(levels[1:]))
    return replace(bindings, textures=textures)


def _coarsen(texels: Array, made_up: bool) -> Array:
    step = _coarse_step(texels) if texels.dtype.kind == "f" else 1
    values: Array = (step * np.round(texels / step)).astype(texels.dtype)
    high, wide = (size // 2 for size in values.shape[-3:-1])
    least, most = (end(values, (-3, -2), keepdims=True) for end in (np.min, np.max))
    ends = (0, 1) if made_up else (np.minimum(least, 0), most)
    values[..., :high, :wide, :], values[..., high:, wide:, :] = ends
    values[..., 1:high:4, 1:wide:4, :] = ends[1]
    first = texels[..., high : high + 1, :1, :] * 1.0  # others are ever more like it
    fade = np.geomspace(1.0, 0.01, values.shape[-3] - high)[:, None, None]
    values[..., high:, :wide, :] = first + fade * (texels[..., high:, :wide, :] - first)
    return values


def _matrices(type_: str, domain: InputDomain, count: int, rng: np.random.Generator) -> Array:
    """Matrices as the interpreter has them, (count, rows, columns)."""
    columns, rows = _sides(type_)
    if domain.kind == "number" or columns != rows:
        return rng.uniform(domain.low, domain.high, (count, rows, columns)).astype(np.float32)
    size = columns
    found = np.broadcast_to(np.eye(size), (count, size, size)).copy()
    if domain.kind == "projection" and size == 4:
        focal, aspect = rng.uniform(0.7, 2.5, count), rng.uniform(0.5, 2.0, count)
        near, far = rng.uniform(0.1, 1.0, count), rng.uniform(5.0, 100.0, count)
        found[:, 0, 0], found[:, 1, 1] = focal / aspect, focal
        found[:, 2, 2], found[:, 2, 3] = (far + near) / (near - far), 2 * far * near / (near - far)
        found[:, 3, 2], found[:, 3, 3] = -1.0, 0.0
        return found.astype(np.float32)
    turn = min(size, 3)
    q, _ = np.linalg.qr(rng.normal(size=(count, turn, turn)))
    q[:, :, 0] *= np.sign(np.linalg.det(q))[:, None]  # no reflection
    if domain.kind == "affine":
        q = q * rng.uniform(0.4, 2.5, (count, 1, turn))
    if domain.kind == "affine" and size == 4:
        found[:, :3, 3] = rng.uniform(-4.0, 4.0, (count, 3))
    found[:, :turn, :turn] = q
    return found.astype(np.float32)


# 0 is a texture's side.
_SHAPES: Mapping[str, tuple[int, ...]] = {
    "1D": (1, 0), "1DArray": (4, 1, 0), "Buffer": (1, 0), "2D": (0, 0), "2DArray": (4, 0, 0),
    "3D": (0, 0, 0), "Cube": (6, 0, 0), "CubeArray": (12, 0, 0), "2DMS": (4, 0, 0),
}  # fmt: skip


def _texture(one: Input, rng: np.random.Generator, *, mipmaps: bool) -> Texels:
    """A small texture; one of normals holds unit vectors, by 0.5 + 0.5 n. With mipmaps, other ones,
    its light may be above 1."""
    is_image = "image" in one.type
    of = one.type.replace("image" if is_image else "texture", "sampler")
    kind = of.partition("sampler")[2]
    shadow = kind.endswith("Shadow")
    kind = kind.removesuffix("Shadow")
    if kind not in _SHAPES or (is_image and kind not in ("2D", "2DArray", "3D")):
        raise NotInterpretedError(f"not interpreted: {one.type} {one.name}")
    side = int(rng.choice(_FACE_SIDES if "Cube" in kind else _SIDES)) * (4 if is_image else 1)
    shape = *(size or side for size in _SHAPES[kind]), 4
    values = rng.uniform(0.02, 3.0 if mipmaps else 1.0, shape)
    values[..., -side // 4 :, :] *= np.geomspace(0.2, 0.01, side // 4)[:, None]  # dark columns
    if "normal" in words_of(one.name):
        n = rng.normal(size=(*values.shape[:-1], 3))
        n[..., 2] = np.abs(n[..., 2])
        values[..., :3] = 0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True)
    if dtype := {"i": np.int32, "u": np.uint32}.get(of[0]):
        values *= 16.0
    filters = ("nearest", "nearest") if dtype or kind == "2DMS" else ("linear", "linear")
    levels = (2, 4, 8) if kind in ("2D", "2DArray", "Cube") and not (shadow or is_image) else ()
    smaller = (values[..., ::n, ::n, :][..., ::-1, :, :] * 0.9 for n in levels)
    values = values[..., : one.channels]
    texels = Texels(
        values.astype(dtype or np.float32),
        filters,
        ("repeat",) * 3,
        (0.0,) * 4,
        smaller=tuple(level.astype(dtype or np.float32) for level in smaller),
        kind=kind,
        compare="lequal" if shadow else None,
    )
    return add_mipmaps(texels) if mipmaps and not dtype else texels


def add_mipmaps(texels: Texels) -> Texels:
    """The texture with filters that read its smaller levels, if it has any."""
    return replace(texels, filter=("linear_mipmap_linear", "linear")) if texels.smaller else texels


_NEAR = 1e-3  # how far from 1 the length of a unit vector is found
_AFFINE = np.array([0.0, 0.0, 0.0, 1.0])


def learn_domains(captured: Sequence[InputBatch]) -> dict[str, InputDomain]:
    """What the captures' floats are, by name."""
    values: dict[str, list[Array]] = {}
    for batch in captured:
        for name, rows in [*batch.each.items(), *batch.bindings.uniforms.items()]:
            array = np.asarray(rows)
            if array.dtype.kind == "f" and name != "gl_FragCoord":
                own = array if name in batch.each else array[None]
                values.setdefault(name, []).append(own)
    found = {name: _learn_domain(name, arrays) for name, arrays in values.items()}
    add_orders(found)
    return found


def _learn_domain(name: str, arrays: Sequence[Array]) -> InputDomain:
    shape = arrays[0].shape[1:]
    flat = np.concatenate([a.reshape(-1, *shape[-1:]) for a in arrays])
    if len(shape) == 2 and shape[0] == shape[1] and shape[0] > 1:
        whole = np.concatenate(arrays).astype(np.float64)
        turn = whole[:, :3, :3]
        square = turn @ np.swapaxes(turn, 1, 2)
        if shape[0] < 4 or (whole[:, 3] == _AFFINE).all():
            turns = np.abs(square - np.eye(turn.shape[1])).max() < _NEAR
            moves = shape[0] == 4 and not (whole[:, :3, 3] == 0.0).all()
            return InputDomain("rotation" if turns and not moves else "affine", source="learned")
        return InputDomain("projection", source="learned")
    with np.errstate(all="ignore"):
        length = np.linalg.norm(flat.astype(np.float64), axis=-1)
        unit = shape[-1:] in ((2,), (3,), (4,)) and bool((np.abs(length - 1.0) < _NEAR).all())
        turns = shape == (4,) and np.count_nonzero(flat, axis=-1).max(initial=0) > 1  # no colour
        if unit and (is_direction(name) or turns or (flat < 0.0).any()):
            return InputDomain("unit", source="learned")
        low = 0.0 if flat.min(initial=0.0) >= 0.0 else -np.inf
        high = 1.0 if low == 0.0 and flat.max(initial=0.0) <= 1.0 else np.inf
    return InputDomain("number", low, high, "learned")


def enclose_inputs(
    inputs: Inputs, captured: Sequence[InputBatch]
) -> tuple[dict[str, InputDomain], InputBatch]:
    """The ranges of what draws give a program, and all of it together, with one draw's textures. Of
    a vector of two or three floats the square of the length has a range, too: that of its domain,
    "unit". Raises NotInterpretedError: they give it what is no number."""
    drawn, each = join_batches(captured), {}
    domains = {}
    for name in inputs:
        textures = [b.bindings.textures[name] for b in captured if name in b.bindings.textures]
        array, _, index = name.removesuffix("]").rpartition("[")
        rows = drawn.each.get(name, np.zeros((0, 1)))
        if array in drawn.each:
            rows = drawn.each[array][:, int(index)]
        rows = rows.reshape(len(rows), *rows.shape[1:] or (1,))
        if textures:
            domains[name] = _enclose_texels(textures)
            continue
        each[name] = rows
        if not rows.size or not np.isfinite(rows).all():
            raise NotInterpretedError(f"not proved: {name} is no number in a draw")
        kind: Kind = "number"
        low, high = float(rows.min()), float(rows.max())
        if rows.dtype.kind == "f" and rows.ndim == 2 and rows.shape[1] in (2, 3):
            square = (rows.astype(np.float64) ** 2).sum(axis=1)
            kind, low, high = "unit", float(square.min()) - _GIVE, float(square.max()) + _GIVE
            low = max(low, 0.0)
        domains[name] = InputDomain(kind, low, high, source="learned")
    return domains, InputBatch({**drawn.each, **each}, drawn.bindings, drawn.count)


def _enclose_texels(textures: Sequence[Texels]) -> InputDomain:
    levels = [level for one in textures for level in (one.values, *one.smaller)]
    # NumPy takes three times as long for the ends of float16 itself.
    levels = [level.astype(np.float32) if level.dtype == np.float16 else level for level in levels]
    ends = [
        end for level in levels if level.dtype != np.uint8 for end in (level.min(), level.max())
    ]
    # What 8 bits hold, channels that a texture lacks, and what lies outside of it.
    ends += [0.0, 1.0] * any(v.dtype == np.uint8 or v.shape[-1] < 4 for v in levels)
    ends += [end for one in textures if "clamp_to_border" in one.wrap for end in one.border]
    low, high = float(min(ends)), float(max(ends))
    give = 1e-6 * max(abs(low), abs(high))  # of what filters round
    return InputDomain("texture", low - give * (low != 0.0), high + give, "learned")


def vary_inputs(batch: InputBatch, domains: Domains, seed: int) -> InputBatch:
    """Other inputs of the same roles: uniforms differ between quads of pixels now, and texels have
    changed places."""
    rng = np.random.default_rng([29, seed])
    group = np.arange(batch.count)  # the same number in a quad of pixels
    if "gl_FragCoord" in batch.each:
        group = np.unique(quads_of(batch.each["gl_FragCoord"]), return_inverse=True)[1].ravel()
    each = dict(batch.each)
    for name, values in batch.bindings.uniforms.items():
        if name in domains and name not in each:
            each[name] = np.repeat(np.asarray(values)[None], batch.count, axis=0)
    for name, domain in domains.items():
        if name in each:
            each[name] = _vary(each[name], domain, group, rng)
    keep_in_order(each, domains)
    textures = {name: _shuffle(texels, rng) for name, texels in batch.bindings.textures.items()}
    return InputBatch(each, replace(batch.bindings, textures=textures), batch.count)


def _vary(values: Array, domain: InputDomain, group: Array, rng: np.random.Generator) -> Array:
    """Values of the same role, changed alike in each group."""
    count, shape = int(group.max(initial=0)) + 1, values.shape[1:]
    if len(values) == 1:
        values = np.repeat(values, len(group), axis=0)
    x = values.astype(np.float64)
    if domain.kind == "projection":
        return np.asarray(x * np.exp(rng.uniform(-0.3, 0.3, (count, *shape)))[group], np.float32)
    if domain.kind in ("rotation", "affine"):
        by = _matrices(f"mat{shape[-1]}", domain, count, rng)
        return np.asarray(x @ by[group], np.float32)
    if domain.kind == "unit":
        x = x + rng.normal(scale=0.4, size=(count, *shape))[group]
        return np.asarray(x / np.linalg.norm(x, axis=-1, keepdims=True), np.float32)
    size = max(float(np.nanmax(np.abs(x), initial=0.0)), 0.1)
    x = x * np.exp(rng.uniform(-0.7, 0.7, (count, *shape)))[group]
    low = 0.0 if domain.low == 0.0 else -1.0
    moved = rng.uniform(low, 1.0, (count, *shape)) * 0.2 * size
    x = x + np.where(rng.random((count, *shape)) < 0.5, moved, 0.0)[group]
    if domain.source != "learned":  # what was learned does not hold: signs are free
        x = np.where((rng.random((count, *shape)) < 0.3)[group], -x, x)
    return np.asarray(np.clip(x, domain.low, domain.high), np.float32)


def _shuffle(texels: Texels, rng: np.random.Generator) -> Texels:
    def mix(values: Array) -> Array:
        flat = values.reshape(-1, values.shape[-1])
        return flat[rng.permutation(len(flat))].reshape(values.shape)

    smaller = tuple(mix(level) for level in texels.smaller)
    return replace(texels, values=mix(texels.values), smaller=smaller)
