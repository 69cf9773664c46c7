"""A device that errs as much as the rules allow, and the expression trees that it evaluates.

Each rounding goes up or down at random, sums of products are fused or not, denormals are flushed
or not, dot products are summed in any order, `mix` and `normalize` take either expansion. A tree
can be rearranged as an optimiser would. Nothing of it is shared with the bands themselves but the
formulas that `on_bands` says.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab import glslmath as g
from shaderlab.bands import Band

Tree = Any


BINARY = ("add", "sub", "mul", "max", "min", "div")
UNARY = ("neg", "abs", "sqrt", "exp2", "log2", "sin", "normalize", "clamp", "pow")


def ulp(x: np.ndarray) -> np.ndarray:
    """Independently of the bands: the distance to the neighbour nearer to zero."""
    value = np.abs(x).astype(np.float32)
    return np.maximum(value - np.nextafter(value, np.float32(0)), 2.0**-149).astype(np.float64)


class Device:
    """Float32 arithmetic on float64 arrays that sit on the float32 grid."""

    def __init__(self, seed: int, mode: str) -> None:
        self.rng = np.random.default_rng(seed)
        self.mode = mode

    def rounded(self, x: np.ndarray) -> np.ndarray:
        near = x.astype(np.float32)
        if self.mode != "nearest":
            below = np.where(near > x, np.nextafter(near, np.float32(-np.inf)), near)
            above = np.where(near < x, np.nextafter(near, np.float32(np.inf)), near)
            upward = self.rng.random(x.shape) < 0.5 if self.mode == "either" else x < 0.0
            near = np.where(upward, above, below)
        result = near.astype(np.float64)
        flushes = (np.abs(result) < 2.0**-126) & (self.rng.random(x.shape) < 0.5)
        return np.where(flushes, 0.0, result)

    def within(self, exact: np.ndarray, error: np.ndarray | float) -> np.ndarray:
        """A float32 at most `error` away from the exact value; often as far as it goes."""
        error = np.where(np.isinf(exact), 0.0, error)
        share = np.clip(self.rng.uniform(-1.6, 1.6, exact.shape), -1.0, 1.0)
        near = (exact + share * error).astype(np.float32).astype(np.float64)
        too_far = np.abs(near - exact) > error
        return self.rounded(np.where(too_far, exact.astype(np.float32), near))

    def within_ulps(self, exact: np.ndarray, ulps: np.ndarray | float) -> np.ndarray:
        """As `within`, but zero stays zero and no error takes a value past it."""
        result = self.within(exact, ulps * ulp(exact))
        is_kept = np.isnan(exact) | (result * np.sign(exact) > 0.0)
        result = np.where(is_kept, result, 0.0)
        return np.where(np.abs(exact) > 3.4028235e38, self.rounded(exact), result)

    def add(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return self.rounded(a + b)

    def mul(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return self.rounded(a * b)

    def div(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return self.within_ulps(a / b, 2.5)

    def multiply_add(self, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        """Fused or not."""
        if self.rng.random() < 0.5:
            return self.rounded(a * b + c)
        return self.add(self.mul(a, b), c)

    def dot(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        order = self.rng.permutation(a.shape[-1])
        total = self.mul(a[..., order[:1]], b[..., order[:1]])
        for j in order[1:]:
            total = self.multiply_add(a[..., j : j + 1], b[..., j : j + 1], total)
        return total

    def inversesqrt(self, x: np.ndarray) -> np.ndarray:
        return self.within_ulps(1.0 / np.sqrt(x), 2.0)

    def sqrt(self, x: np.ndarray) -> np.ndarray:
        root = self.inversesqrt(np.where(x == 0.0, 1.0, x))
        return np.where(x == 0.0, 0.0, self.div(np.ones(1), root))

    def exp2(self, x: np.ndarray) -> np.ndarray:
        return self.within_ulps(np.exp2(x), 3.0 + 2.0 * np.abs(x))

    def log2(self, x: np.ndarray) -> np.ndarray:
        near_one = (x >= 0.5) & (x <= 2.0)
        return self.within(np.log2(x), np.where(near_one, 2.0**-21, 3.0 * ulp(np.log2(x))))

    def normalize(self, v: np.ndarray) -> np.ndarray:
        if self.rng.random() < 0.5:
            return self.mul(v, self.inversesqrt(self.dot(v, v)))
        return self.div(v, self.sqrt(self.dot(v, v)))

    def mix(self, x: np.ndarray, y: np.ndarray, a: np.ndarray) -> np.ndarray:
        if self.rng.random() < 0.5:
            return self.multiply_add(self.add(y, -x), a, x)
        return self.multiply_add(x, self.add(np.ones(1), -a), self.mul(y, a))


def on_bands(tree: Tree, inputs: list[Band]) -> Any:
    """The tree as a formula would say it."""
    name, *rest = tree
    if name == "input":
        return inputs[rest[0]]
    if name == "constant":
        return Band.literal(rest[0], inputs[0].rules)
    args = [on_bands(branch, inputs) for branch in rest]
    table: dict[str, Callable[..., Any]] = {
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "max": g.max,
        "min": g.min,
        "div": lambda a, b: a / g.max(g.abs(b), 0.125),
        "neg": lambda a: -a,
        "abs": g.abs,
        "sqrt": lambda a: g.sqrt(g.abs(a)),
        "exp2": lambda a: g.exp2(g.clamp(a, -8.0, 8.0)),
        "log2": lambda a: g.log2(g.max(a, 0.125)),
        "sin": lambda a: g.sin(g.clamp(a, -3.0, 3.0)),
        "normalize": lambda a: g.normalize(g.max(a, 0.125)),
        "clamp": lambda a: g.clamp(a, 0.0, 1.0),
        "pow": lambda a: g.pow(g.max(a, 0.125), 2.5),
        "dot": lambda a, b: g.dot(g.vec3(a)[..., :3], g.vec3(b)[..., :3]),
        "mix": lambda a, b: g.mix(a, b, 0.75),
    }
    return table[name](*args)


def on_device(tree: Tree, inputs: list[np.ndarray], device: Device) -> np.ndarray:
    """The same tree, each operation erring."""
    name, *rest = tree
    if name == "input":
        return device.rounded(inputs[rest[0]])
    if name == "constant":
        return np.full((1, 1), rest[0])
    if name == "add" and rest[0][0] == "mul":
        (_, a, b), c = rest
        return device.multiply_add(*(on_device(t, inputs, device) for t in (a, b, c)))
    args = [on_device(branch, inputs, device) for branch in rest]
    a, b = args[0], args[-1]
    if name == "dot":
        wide = [np.broadcast_to(x, (*x.shape[:-1], 3)) if x.shape[-1] == 1 else x for x in (a, b)]
        return device.dot(wide[0], wide[1])
    if name == "pow":
        base = np.maximum(a, 0.125)
        return device.exp2(device.mul(np.full(1, 2.5), device.log2(base)))
    table: dict[str, Callable[[], np.ndarray]] = {
        "add": lambda: device.add(a, b),
        "sub": lambda: device.add(a, -b),
        "mul": lambda: device.mul(a, b),
        "max": lambda: np.maximum(a, b),
        "min": lambda: np.minimum(a, b),
        "div": lambda: device.div(a, np.maximum(np.abs(b), 0.125)),
        "neg": lambda: -a,
        "abs": lambda: np.abs(a),
        "sqrt": lambda: device.sqrt(np.abs(a)),
        "exp2": lambda: device.exp2(np.clip(a, -8.0, 8.0)),
        "log2": lambda: device.log2(np.maximum(a, 0.125)),
        "sin": lambda: device.within(np.sin(np.clip(a, -3.0, 3.0)), 2.0**-11),
        "normalize": lambda: device.normalize(np.maximum(a, 0.125)),
        "clamp": lambda: np.clip(a, 0.0, 1.0),
        "mix": lambda: device.mix(a, b, np.full(1, 0.75)),
    }
    return table[name]()


def rearranged(tree: Tree, rng: np.random.Generator) -> Tree:
    """The tree after an optimiser: reassociated, distributed, factored, terms exchanged."""
    if tree[0] in ("input", "constant"):
        return tree
    name, *branches = tree
    name, *branches = (name, *(rearranged(branch, rng) for branch in branches))
    if name == "sub" and rng.random() < 0.5:
        name, branches = "add", [branches[0], ("neg", branches[1])]
    if rng.random() < 0.3:
        return (name, *branches)
    if name in ("add", "mul") and branches[0][0] == name:
        (_, a, b), c = branches
        return (name, a, (name, b, c))
    if name in ("add", "mul") and branches[1][0] == name:
        a, (_, b, c) = branches
        return (name, (name, a, b), c)
    if name == "mul" and branches[1][0] in ("add", "sub"):
        a, (inner, b, c) = branches
        return (inner, ("mul", a, b), ("mul", a, c))
    if name == "mul" and branches[0][0] in ("add", "sub"):
        (inner, a, b), c = branches
        return (inner, ("mul", a, c), ("mul", b, c))
    if name in ("add", "sub") and branches[0][0] == branches[1][0] == "mul":
        (_, a, b), (_, c, d) = branches
        if a == c:
            return ("mul", a, (name, b, d))
        if b == d:
            return ("mul", (name, a, c), b)
    return (name, *branches)
