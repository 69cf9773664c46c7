"""Does anything leave what was proved? `python -m benchmarks.proving_adversary --seconds 600`.

Random functions are run in boxes of inputs. Inputs of each box are run in float32, by a device that
errs in every operation as much as the rules allow (`erring_arithmetic`), and on a driver
(SHADERLAB_DRIVER names it). Each result must lie between the box's ends. And what is proved to be a
finite number has to be one everywhere. A function that a value leaves is printed.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import time
from collections import Counter
from typing import Any

import numpy as np

from benchmarks.adversary_device import Device
from benchmarks.erring_arithmetic import Erring
from benchmarks.proving import Case, find_escapes
from shaderlab.analysis.batches import InputBatch, run_batch
from shaderlab.analysis.boxes import ARITHMETIC, BoxWatcher, Space, ends_of
from shaderlab.analysis.inputs import domains_of, inputs_of
from shaderlab.analysis.interpreter import FLOAT32, Program
from shaderlab.analysis.proof import Proof
from shaderlab.bands.bounds import contains
from shaderlab.engine.worker import Worker
from shaderlab.errors import ShaderlabError
from shaderlab.functions.evaluation import use_worker
from shaderlab.functions.library import load

BOXES, POINTS = 64, 64
SUMS = ("({a} + {b})", "({a} - {b})", "({a} * {b})", "({a} - {a} * {b})", "dot({v}, {w})",
        "({v} * {a} - {w}).y", "(-{v}).x", "({v} + {w} * {a}).x")  # fmt: skip
OTHERS = (
    "({a} / {b})", "sqrt({a})", "log({a})", "pow({a}, {b})", "inversesqrt({a})",
    "clamp({a}, 0.0, 1.0)", "mix({a}, {b}, {c})", "smoothstep({a}, {b}, {c})", "mod({a}, {b})",
    "floor({a})", "fract({a})", "min({a}, {b})", "max({a}, {b})", "step({a}, {b})",
    "({a} > {b} ? {c} : {a})", "exp({a})", "sin({a})", "asin({a})", "abs({a})", "length({v})",
    "normalize({v}).x", "float(int({a} * 3.0) / (int({b} * 4.0) + 2))", "fma({a}, {b}, {c})",
    "vec3({a}, {b}, {c})[int(clamp({a}, 0.0, 1.0) * 2.0)]", "reflect({v}, {w}).x",
    "cross(vec3({v}, {a}), vec3({w}, {b})).x", "distance({v}, {w})", "exp2({a})", "atan({a}, {b})",
    "(mat2({v}, {w}) * {v}).x", "sign({a})", "trunc({a})", "tan({a})", "cos({a})",
)  # fmt: skip
BODIES = (
    "return {a};",
    "float r; if ({a} > {b}) r = {c}; else r = {b}; return r / ({a} + 1.5);",
    "float s = {a}; for (int i = 0; i < 3; ++i) {{ s = s * 0.5 + {b}; if (s > {c}) break; }} "
    "return 1.0 / (s + {a});",
    "if ({a} <= 0.0) return {b}; return sqrt({a}) + {c};",
    "vec2 s = {v}; s.y = {a}; s *= {b}; return 1.0 / (s.x - s.y * {c} + 3.0);",
)
RANGES = ("0:1", "0.1:1", "-1:1", "0.5:2", "0:8", "-3:0.25", "1:1.001",
          "1e-30:1e-20", "1e-38:1", "0:1e15", "-1e20:1e30")  # fmt: skip


def expression(rng: random.Random, depth: int, linear: float) -> str:
    """A random one, of sums and products with a probability of `linear`."""
    if depth == 0 or rng.random() < 0.12:
        number = rng.choice((0.0, 0.5, 1.0, 2.0, 0.25, 3.0, 1e-3))
        return rng.choice(("x", "y", "x", "y", "v.x", "v.y", f"{number:.4f}"))
    parts = {name: expression(rng, depth - 1, linear) for name in "abc"}
    pairs = {
        name: f"vec2({rng.choice('xy')}, {expression(rng, depth - 1, linear)})" for name in "vw"
    }
    pairs["v"] = rng.choice(("v", pairs["v"]))
    return rng.choice(SUMS if rng.random() < linear else OTHERS).format(**parts, **pairs)


def make_case(rng: random.Random) -> Case:
    """A random function of those of x, y and v that it reads."""
    linear = rng.choice((0.2, 0.9))
    body = rng.choice(BODIES)
    parts = {name: expression(rng, rng.choice((1, 2, 3)), linear) for name in "abc"}
    body = body.format(**parts, v=f"vec2({parts['a']}, {parts['b']})")
    ranges = {"x": rng.choice(RANGES), "y": rng.choice(RANGES), "v": rng.choice((*RANGES, "unit"))}
    used = {name: ends for name, ends in ranges.items() if re.search(rf"\b{name}\b", body)}
    return Case("random", False, f"float f(float x, float y, vec2 v) {{ {body} }}", used)


def random_boxes(space: Space, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Boxes of all sizes, from one point to the whole range."""
    shape = BOXES, len(space.low)
    wide = rng.choice([0.0, 1e-7, 1e-4, 0.05, 1.0], (BOXES, 1)) * rng.choice(
        [1.0, 0.0], shape, p=[0.8, 0.2]
    )
    low = rng.uniform(space.low, space.high, shape)
    high = np.minimum(low + wide * (space.high - space.low), space.high)
    ends = [np.clip(np.float64(np.float32(end)), space.low, space.high) for end in (low, high)]
    return np.minimum(*ends), np.maximum(*ends)


def leave_boxes(case: Case, program: Program, seed: int, tally: Counter[str]) -> bool:
    """Whether a value of a random box is not between its ends."""
    inputs = inputs_of(program)
    space = Space(program, inputs, domains_of(inputs, [program], case.ranges))
    rng = np.random.default_rng(seed)
    low, high = random_boxes(space, rng)
    watcher = BoxWatcher(BOXES, space.texels)
    box = space.ranges(low, high)
    whole: Any = run_batch(program, box, ARITHMETIC, watch=watcher).outputs["result"]
    share = rng.choice([0.0, 1.0, 0.5, 2.0], (BOXES, POINTS, len(space.low)))
    share = np.where(share == 2.0, rng.random(share.shape), share)
    points = np.float32(low[:, None] + share * (high - low)[:, None])
    points = np.clip(points, np.float32(low)[:, None], np.float32(high)[:, None])
    points = points.reshape(-1, len(space.low))
    columns = np.split(points, np.cumsum([box.each[n].shape[1] for n in inputs])[:-1], axis=1)
    each = dict(zip(inputs, columns, strict=True))
    batch = InputBatch(each, box.bindings, len(points))
    found = {"float32": run_batch(program, batch, FLOAT32).outputs["result"]}
    for mode in ("either", "zero"):
        erring = Erring(device=Device(int(rng.integers(2**63)), mode))
        erred = run_batch(program, batch, erring, watch=erring.keep_folded)
        found[f"erring, {mode}"] = erred.outputs["result"]
    given = {n: v[:, 0] if inputs[n].type == "float" else v for n, v in each.items()}
    found["the driver"] = load(case.code)["f"](**given)
    low, high, nan = (
        np.repeat(np.broadcast_to(end, (BOXES, 1)), POINTS, axis=0)
        for end in (*ends_of(whole), whole.nan)
    )
    escaped = False
    for name, values in found.items():
        rows = np.broadcast_to(np.float32(np.asarray(values)).reshape(-1, 1), (len(points), 1))
        good = contains(low, high, nan, rows)[:, 0]
        tally[f"values of {name}"] += len(points)
        if not good.all():
            row = int(np.flatnonzero(~good)[0])
            print(f"ESCAPE on {name}: {int((~good).sum())}: {case.code}\n  {points[row]} gives "
                  f"{rows[row]}, not {low[row]}..{high[row]}", flush=True)  # fmt: skip
            escaped = True
    return escaped


def main() -> int:
    """Print what was tried; 1 if anything escaped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--samples", type=int, default=20_000, help="of each proved function")
    options = parser.parse_args()
    worker, tally, escaped, seed = Worker(), Counter[str](), 0, options.seed
    stop = time.monotonic() + options.seconds
    with use_worker(worker):
        while time.monotonic() < stop:
            seed += 1
            case = make_case(random.Random(seed))
            tally["functions"] += 1
            try:
                program = case.program(worker)
                escaped += leave_boxes(case, program, seed, tally)
                inputs = inputs_of(program)
                domains = domains_of(inputs, [program], case.ranges)
                proof = Proof(program, inputs, domains, boxes=2048)
                if not proof.points and all(c.status == "proved" for c in proof.claims()):
                    tally["proved"] += 1
                    tally["values of proved functions"] += options.samples
                    gone = find_escapes(case, worker, options.samples, seed)
                    escaped += bool(gone)
                    if gone:
                        print(f"ESCAPE of {gone}: {case.code} {case.ranges}", flush=True)
            except ShaderlabError as error:
                tally[f"not run: {error.message[:40]}"] += 1
    for name, number in tally.items():
        print(f"{number:14,} {name}")
    print(f"{escaped} functions escape; seeds {options.seed + 1} to {seed}")
    return 1 if escaped else 0


if __name__ == "__main__":
    sys.exit(main())
