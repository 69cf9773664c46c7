"""Boxes of inputs: many ranges at once, what an instruction may get anywhere in each, their halves.

A box has a lower and an upper end for each number that a program reads. A program run on boxes in
bands gives for each box what any of its inputs may give on any conforming device.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.bands import Band, Integer, Rules
from shaderlab.bands.rounding import LARGEST
from shaderlab.compiler.spirv import Op
from shaderlab.model.frame import Array

from .batches import InputBatch, asks_for_neighbours
from .checks import CHECKS, INDEX, INDEXING, Check, Place, arguments_of, indices_of, number_of
from .enclosures import STEPS, Enclosures
from .inputs import Domains, InputDomain, Inputs, sample_inputs
from .interpreter import Bands, Program
from .interpreter.program import INPUTS, Instruction
from .interpreter.running import Run
from .interpreter.textures import LOOKUPS, is_read_only
from .interpreter.values import Flags, PathState

ARITHMETIC = Bands(Rules(trig_outside="scaled", ranges=True))
_LIMITS = {"unit": (-1.0, 1.0), "rotation": (-1.0, 1.0), "affine": (-5.0, 5.0),
           "projection": (-5.0, 5.0)}  # fmt: skip
# The pixels of the largest target, depth, and 1/w of what lies 1e-6 to 1e6 in front of the eye.
_FRAG_COORD = ([0.0, 0.0, 0.0, 1e-6], [16384.0, 16384.0, 1.0, 1e6])
_FINEST = 2.0**-40  # of a range: smaller boxes are not halved
_SLOPE, _PIXELS = 0.01, 64  # of varyings in a quad, in widths of their ranges; in a row of quads
_UNDERFLOW = 2.0**-63  # the square of what is smaller may be flushed to 0
_MOST_TEXELS = 32768  # of a texture's side, or levels or samples


class Space:
    """The numbers that a program reads, one column for each: within the domains, or between the
    least and the greatest of what some draws give it (`is_drawn`): the ends of all that is asked
    about, (columns,), and which of these are `whole` numbers. `rows` is how many invocations a
    point has: a quad's where the program asks for neighbours."""

    def __init__(
        self, program: Program, inputs: Inputs, domains: Domains, drawn: InputBatch | None = None
    ) -> None:
        self.inputs, self.domains = inputs, domains
        self._samples = sample_inputs(inputs, domains, 64, 0) if drawn is None else drawn
        self.is_drawn = drawn is not None
        self._columns: dict[str, tuple[slice, tuple[int, ...]]] = {}
        low: list[Array] = []
        high: list[Array] = []
        whole: list[bool] = []
        for name, one in inputs.items():
            domain = domains[name]
            if domain.kind == "texture":
                continue
            shape = self._samples.each[name].shape[1:]
            size = int(np.prod(shape))
            self._columns[name] = slice(len(whole), len(whole) + size), shape
            ends: Any = _LIMITS.get(domain.kind, (domain.low, domain.high))
            ends = np.asarray(_FRAG_COORD if name == "gl_FragCoord" else ends, np.float32)
            if drawn is not None:
                rows = drawn.each[name].reshape(-1, size)
                ends = rows.min(axis=0), rows.max(axis=0)
            is_float = one.type.startswith(("float", "vec", "mat"))
            whole += [not is_float] * size
            for end, into in zip(ends, (low, high), strict=True):
                into.append(np.broadcast_to(np.float64(end), (size,)))
        self.low, self.high = (np.concatenate([*ends, np.zeros(0)]) for ends in (low, high))
        self.whole = np.array(whole, np.bool_)
        self.rows = 4 if asks_for_neighbours(program, self._samples.bindings) else 1
        self._varying = [
            k for n, (columns, _) in self._columns.items() if not inputs[n].uniform
            for k in range(columns.start, columns.stop) if not self.whole[k]
        ]  # fmt: skip
        textures = self._samples.bindings.textures
        self.texels = {id(textures[n]): one for n, one in domains.items() if n in textures}

    def ranges(self, low: Array, high: Array) -> InputBatch:
        """Boxes (count, columns) as what a run in bands takes."""
        ends = low + 1j * high
        each = {
            name: ends[:, columns].reshape(len(low), *shape)
            for name, (columns, shape) in self._columns.items()
        }
        return InputBatch(each, self._samples.bindings, len(low))

    def points(self, values: Array) -> InputBatch:
        """Inputs (count, columns) as invocations, each the first of its `rows`, in which varyings
        differ a little; those that must fit together are samples."""
        if self.rows > 1:
            values = np.repeat(values, self.rows, axis=0)
            slopes = np.random.default_rng(7).normal(size=(len(values), len(self._varying)))
            slopes[:: self.rows] = 0.0
            values[:, self._varying] += _SLOPE * slopes * (self.high - self.low)[self._varying]
            values = np.clip(values, self.low, self.high)
        count = len(values)
        samples = self._samples.part(np.arange(count) % self._samples.count)
        each = dict(samples.each)
        for name, (columns, shape) in self._columns.items():
            domain, is_numbered = self.domains[name], self.inputs[name].workgroup is not None
            if domain.kind in ("number", "unit") and not is_numbered:
                own = values[:, columns].reshape(count, *shape)
                is_whole = self.whole[columns].any()
                if domain.kind == "unit" and not self.is_drawn:
                    own = domain.clip(own)
                elif domain.kind == "unit":
                    square = (own**2).sum(axis=1, keepdims=True)
                    inside = (square >= domain.low) & (square <= domain.high)
                    own = np.where(inside, own, samples.each[name])
                each[name] = own.astype(np.int64 if is_whole else np.float32)
        quad, corner = np.divmod(np.arange(count), self.rows)
        pixels = np.stack([2 * (quad % _PIXELS) + corner % 2, quad // _PIXELS * 2 + corner // 2], 1)
        if "gl_FragCoord" not in self._columns or self.rows > 1 or not self.is_drawn:
            places = [pixels + 0.5, samples.each["gl_FragCoord"][:, 2:]]
            each["gl_FragCoord"] = np.concatenate(places, axis=1)
        return InputBatch(each, samples.bindings, count)

    def feasible(self, low: Array, high: Array) -> Flags:
        """Which boxes hold an input that meets what is assumed of several numbers together."""
        found = np.ones(len(low), np.bool_)
        for name, (columns, _) in self._columns.items():
            a, b = low[:, columns], high[:, columns]
            if self.domains[name].kind == "unit":
                most = np.maximum(np.abs(a), np.abs(b))
                least = np.maximum(np.maximum(a, -b), 0.0)
                found &= (most**2).sum(axis=1) >= self.domains[name].low
                found &= (least**2).sum(axis=1) <= self.domains[name].high
            other = self._columns.get(self.domains[name].above)
            if other is not None and other[1] == self._columns[name][1]:
                found &= (b >= low[:, other[0]]).all(axis=1)
        return found

    def urgent(self, low: Array, high: Array) -> Flags:
        """The sides of vectors that come much nearer to 0 than draws' do: halving these first drops
        boxes."""
        found = np.zeros(low.shape, np.bool_)
        for name, (columns, _) in self._columns.items():
            if self.is_drawn and self.domains[name].kind == "unit":
                least = np.maximum(np.maximum(low[:, columns], -high[:, columns]), 0.0)
                near = (least**2).sum(axis=1) < 0.25 * self.domains[name].low
                found[:, columns] = near[:, None]
        return found

    def relative(self, low: Array, high: Array) -> Array:
        """Each side of a box as a share of the whole range."""
        whole = np.where(self.whole, 1.0, 0.0)
        width = np.maximum(self.high - self.low + whole, np.finfo(np.float64).tiny)
        return np.asarray(np.where(self.high > self.low, (high - low + whole) / width, 1.0))

    def divisible(self, low: Array, high: Array) -> Flags:
        """Which sides of boxes can be halved."""
        with np.errstate(all="ignore"):
            after = np.nextafter(low.astype(np.float32), np.float32(np.inf)).astype(np.float64)
        small = (self.relative(low, high) < _FINEST) | (after >= high)
        return np.where(self.whole, high > low, ~small)

    def halve(self, low: Array, high: Array, sides: Array) -> tuple[Array, Array]:
        """Both halves of boxes at one side of each, whose common end is in both; at 0, or of a
        range of several magnitudes at a middle one."""
        rows = np.arange(len(low))
        a, b = low[rows, sides], high[rows, sides]
        with np.errstate(all="ignore"):
            middle = np.where(a == 0.0, b / 4.0, np.where(b == 0.0, a / 4.0, (a + b) / 2.0))
            root = np.sign(a) * np.sqrt(a * b)
            far = np.maximum(np.abs(a), np.abs(b)) > 4.0 * np.minimum(np.abs(a), np.abs(b))
            middle = np.where(far & (a * b > 0.0), root, middle)
            middle = np.where((a < 0.0) & (b > 0.0), 0.0, middle)
            middle = np.clip(middle.astype(np.float32).astype(np.float64), a, b)
            between = (middle > a) & (middle < b)
            after = np.nextafter(a.astype(np.float32), np.float32(np.inf))
        middle = np.minimum(np.where(between, middle, after), b)
        whole = self.whole[sides]
        middle = np.where(whole, np.floor((a + b) / 2.0), middle)
        lower, upper = high.copy(), low.copy()
        lower[rows, sides], upper[rows, sides] = middle, middle + whole
        return np.concatenate([low, upper]), np.concatenate([lower, high])

    def in_words(self) -> dict[str, str]:
        """What the numbers lie between, by name; of textures their texels."""
        found = {n: f"texels of {one.low:.6g}..{one.high:.6g}" for n, one in self.domains.items()}
        for name, (columns, _) in self._columns.items():
            pairs = zip(self.low[columns], self.high[columns], strict=True)
            ends = [dict.fromkeys(f"{end:.6g}" for end in pair) for pair in pairs]
            found[name] = ", ".join(map("..".join, ends))
            if self.domains[name].kind == "unit" and max(map(len, ends)) > 1:
                least, most = self.domains[name].low ** 0.5, self.domains[name].high ** 0.5
                found[name] += f", of length {least:.6g}..{most:.6g}"
        return found

    def describe(self, low: Array, high: Array) -> str:
        """One box in words: the sides that are not the whole range."""
        found = []
        for name, (columns, _) in self._columns.items():
            for k in range(columns.start, columns.stop):
                if (low[k], high[k]) != (self.low[k], self.high[k]):
                    size, number = columns.stop - columns.start, k - columns.start
                    letter = f"[{number}]" if size > 4 else f".{'xyzw'[number]}" * (size > 1)
                    ends = dict.fromkeys(f"{np.float32(end):.9g}" for end in (low[k], high[k]))
                    found.append(f"{name}{letter} {'..'.join(ends)}")
        return ", ".join(found)


@dataclass
class BoxWatcher:
    """A `Watch` of a run on boxes: `bad` says in which of them an instruction may go wrong, by its
    place, (count,), `lines` where it is, `texels` what textures hold, by their identity."""

    count: int
    texels: Mapping[int, InputDomain]
    lines: dict[Place, int] = field(default_factory=dict)
    bad: dict[Place, Flags] = field(default_factory=dict)
    steps: int = 1
    enclosures: Enclosures = field(default_factory=Enclosures)

    def __call__(self, run: Run, at: Instruction, state: PathState, result: Any) -> Any:
        self.steps += 1
        if at.op == Op.Load:
            if run.program.variables[run.value(at.operands[0]).variable][1] in INPUTS:
                self.enclosures.add_read(result)
        elif at.op in STEPS:
            return self._narrow(run, at, result)
        for check in CHECKS.get(number_of(at.op, at.operands), ()):
            values = run.values(arguments_of(at.op, at.operands))
            self._note(run, at, state, check, [ends_of(value) for value in values])
        if at.op in INDEXING:
            for index, size in indices_of(run, at):  # a constant one is right, or does not compile
                self._note(run, at, state, INDEX, [ends_of(index), (np.full((1, 1), size),) * 2])
        if at.op in LOOKUPS or (at.op == Op.ImageRead and is_read_only(run, at)):
            return self._anything(run, at, result)
        return result

    def _narrow(self, run: Run, at: Instruction, result: Any) -> Any:
        """The result of a sum or a product, which may be narrower than its operands' bands give."""
        values = run.values(at.operands)
        for id_, value in zip(at.operands, values, strict=True):
            if id_ in run.program.module.constants:
                self.enclosures.add_read(value)
        return self.enclosures.narrow(at.op, values, result)

    def _note(
        self, run: Run, at: Instruction, state: PathState, check: Check, ends: Sequence[Any]
    ) -> None:
        place = Place(at.id, tuple(run.calls), check.kind)
        flags = may_go_wrong(check, ends)
        if flags is not None:
            self.lines[place] = at.line
            known = self.bad.setdefault(place, np.zeros(self.count, np.bool_))
            known |= flags & state.mask

    def _anything(self, run: Run, at: Instruction, result: Any) -> Any:
        """What a texture may give, of which the range of its texels alone is known."""
        texels = run.value(at.operands[0])
        domain = self.texels[id(texels)]
        low, high = (0.0, 1.0) if texels.compare is not None else (domain.low, domain.high)
        if at.op == Op.ImageQueryLod:
            low, high = 0.0, float(_MOST_TEXELS)
        elif at.op in (Op.ImageFetch, Op.ImageRead):  # 0 outside; an image's alpha may be 1
            low, high = min(low, 0.0), max(high, 1.0 if at.op == Op.ImageRead else 0.0)
        if isinstance(result, Integer):
            query = at.op in range(Op.ImageQuerySizeLod, Op.ImageQuerySamples + 1)
            ends = (1, _MOST_TEXELS) if query else (int(low), int(high))
            least, most = (np.full(result.shape, end) for end in ends)
            return Integer(least, most, unsigned=result.unsigned, rules=result.rules)
        least, most = (np.full(result.shape, end) for end in (low, high))
        return Band.between(least, most, ARITHMETIC.rules)


def ends_of(value: Any) -> tuple[Array, Array]:
    """The least and the greatest of what a band, settled, or an integer may be."""
    low, high = value.apply_slack() if isinstance(value, Band) else (value.lo, value.hi)
    return low.astype(np.float64), high.astype(np.float64)


def may_go_wrong(check: Check, ends: Sequence[tuple[Array, Array]]) -> Flags | None:
    """In which boxes an instruction may go wrong whose operands lie between these ends; None of
    constants that don't, such as the bounds of a clamp.

    A margin is least at a corner, for it rises or falls in each operand or is the lesser of such;
    those that are never negative and bad at 0 are least where each operand is next to 0."""
    finite = [tuple(np.clip(end, -LARGEST, LARGEST) for end in pair) for pair in ends]
    nearest = [np.clip(0.0, low, high) for low, high in finite]
    if len(ends) == 1 and ends[0][0].shape[-1] > 1:  # of a vector's length, whose squares underflow
        nearest = [np.where(np.abs(nearest[0]) < _UNDERFLOW, 0.0, nearest[0])]
    with np.errstate(all="ignore"):
        margins = [check.margin(*point) for point in (*itertools.product(*finite), nearest)]
        found = np.logical_or.reduce([check.bad(margin) for margin in margins])
        same = all((margin == margins[0].flat[0]).all() for margin in margins)
    flags: Flags = found.reshape(len(found), -1).any(axis=1)
    return None if same and not flags.any() else flags
