"""No value that a real driver computes lies outside its band: every built-in and rearrangeable
expressions, on llvmpipe and on softpipe, over 4096 inputs each.

Run as a script it prints its findings for the driver that the environment chooses.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import glslmath as g
from shaderlab.bands import Band, Rules

SIZE = 64
RULES = Rules(trig_outside="scaled")
ROOT = Path(__file__).resolve().parents[2]

Formula = Callable[..., Any]

VERTEX_SHADER = """#version 330 core
    void main() {
        vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
        gl_Position = vec4(corner * 4.0 - 1.0, 0.0, 1.0);
    }"""

# GLSL over the vec4 inputs `a` and `b`, and the same as a formula. Grouped by the inputs' domain.
UNIT: dict[str, Formula] = {
    "a * b": lambda a, b: a * b,
    "a + b": lambda a, b: a + b,
    "a * b + a.wzyx": lambda a, b: a * b + g.swizzle(a, "wzyx"),
    "(a + b) - a": lambda a, b: (a + b) - a,
    "(a - b) + b": lambda a, b: (a - b) + b,
    "a * b + a * b.yzwx": lambda a, b: a * b + a * g.swizzle(b, "yzwx"),
    "a * b - a * b.yzwx": lambda a, b: a * b - a * g.swizzle(b, "yzwx"),
    "a * (1.0 - b) + b * b.yzwx": lambda a, b: a * (1.0 - b) + b * g.swizzle(b, "yzwx"),
    "(a + 0.3) * 0.7 - 0.21": lambda a, b: (a + 0.3) * 0.7 - 0.21,
    "(a + b) * (a - b)": lambda a, b: (a + b) * (a - b),
    "a + 0.1 + b + 0.2 - a": lambda a, b: a + 0.1 + b + 0.2 - a,
    "1.0 / (1.0 + 0.09 * a + 0.032 * a * a)": lambda a, b: 1.0 / (1.0 + 0.09 * a + 0.032 * a * a),
    "a / (a + 1.0)": lambda a, b: a / (a + 1.0),
    "mix(a, b, b.yzwx)": lambda a, b: g.mix(a, b, g.swizzle(b, "yzwx")),
    "smoothstep(0.2, 0.8, a)": lambda a, b: g.smoothstep(0.2, 0.8, a),
    "step(a, b)": lambda a, b: g.step(a, b),
    "clamp(a, 0.25, 0.75)": lambda a, b: g.clamp(a, 0.25, 0.75),
    "min(a, b) + max(a, b)": lambda a, b: g.min(a, b) + g.max(a, b),
    "pow(a, vec4(1.0 / 2.2))": lambda a, b: g.pow(a, 1.0 / 2.2),
    "pow(a, vec4(32.0))": lambda a, b: g.pow(a, 32.0),
    "pow(a, b)": lambda a, b: g.pow(a, b),
    "pow(a, vec4(2.0)) * pow(a, vec4(0.5))": lambda a, b: g.pow(a, 2.0) * g.pow(a, 0.5),
    "vec4(1.0) - exp(-a * 3.0)": lambda a, b: 1.0 - g.exp(-a * 3.0),
    "sqrt(a) * sqrt(a)": lambda a, b: g.sqrt(a) * g.sqrt(a),
    "mat4(a, b, a.wzyx, b.yxwz) * a": lambda a, b: g.mul(
        g.mat4(a, b, g.swizzle(a, "wzyx"), g.swizzle(b, "yxwz")), a
    ),
    "a.x < b.x ? a * 0.3 : b / 3.0": lambda a, b: g.where(
        a[..., 0:1] < b[..., 0:1], a * 0.3, b / 3.0
    ),
    "a * 2.0 - 1.0": lambda a, b: a * 2.0 - 1.0,
    "(a - b) / 0.01": lambda a, b: (a - b) / 0.01,
    # Rewrites that docs/guide/bands.md names: the shader's, and the reference's.
    "mix(a, b, step(vec4(0.5), a.yzwx))": lambda a, b: g.either(
        g.where(a.yzwx < 0.5, a, b), g.mix(a, b, g.step(0.5, a.yzwx))
    ),
    "a.y < 0.5 ? a : b": lambda a, b: g.mix(a, b, g.step(0.5, a.y)),
    "pow(a, vec4(5.0))": lambda a, b: g.either(a * a * a * a * a, g.pow(a, 5.0)),
    "a * a * a * a * a": lambda a, b: g.pow(a, 5.0),
    "(a * a) * (a * a) * a": lambda a, b: a * a * a * a * a,
    "a * inversesqrt(a + 0.5)": lambda a, b: a / g.sqrt(a + 0.5),
    "pow((a + 0.055) / 1.055, vec4(2.4))": lambda a, b: g.pow((a + 0.055) / 1.055, 2.4),
}
ANGLES: dict[str, Formula] = {
    "sin(a)": lambda a, b: g.sin(a),
    "cos(a)": lambda a, b: g.cos(a),
    "tan(a * 0.4)": lambda a, b: g.tan(a * 0.4),
    "sin(a) * sin(a) + cos(a) * cos(a)": lambda a, b: g.sin(a) * g.sin(a) + g.cos(a) * g.cos(a),
    "atan(a)": lambda a, b: g.atan(a),
    "atan(a, b)": lambda a, b: g.atan(a, b),
    "radians(a)": lambda a, b: g.radians(a),
    "degrees(a)": lambda a, b: g.degrees(a),
    "exp(a)": lambda a, b: g.exp(a),
    "exp2(a)": lambda a, b: g.exp2(a),
    "abs(a) + sign(b)": lambda a, b: g.abs(a) + g.sign(b),
    "floor(a) + ceil(b)": lambda a, b: g.floor(a) + g.ceil(b),
    "trunc(a) + round(b)": lambda a, b: g.trunc(a) + g.round(b),
    "roundEven(a)": lambda a, b: g.roundEven(a),
    "fract(a)": lambda a, b: g.fract(a),
    "mod(a, vec4(0.7))": lambda a, b: g.mod(a, 0.7),
    "mod(a, b)": lambda a, b: g.mod(a, b),
    "vec4(dot(a, b))": lambda a, b: g.vec4(g.dot(a, b)),
    "vec4(length(a))": lambda a, b: g.vec4(g.length(a)),
    "vec4(distance(a, b))": lambda a, b: g.vec4(g.distance(a, b)),
    "normalize(a)": lambda a, b: g.normalize(a),
    "vec4(dot(normalize(a), normalize(b)))": lambda a, b: g.vec4(
        g.dot(g.normalize(a), g.normalize(b))
    ),
    "vec4(max(dot(normalize(a - b), normalize(b)), 0.0))": lambda a, b: g.vec4(
        g.max(g.dot(g.normalize(a - b), g.normalize(b)), 0.0)
    ),
    "vec4(cross(a.xyz, b.xyz), 1.0)": lambda a, b: g.vec4(g.cross(a[..., :3], b[..., :3]), 1.0),
    "reflect(a, normalize(b))": lambda a, b: g.reflect(a, g.normalize(b)),
    "refract(normalize(a), normalize(b), 0.66)": lambda a, b: g.refract(
        g.normalize(a), g.normalize(b), 0.66
    ),
    "faceforward(a, b, a.wzyx)": lambda a, b: g.faceforward(a, b, g.swizzle(a, "wzyx")),
    "vec4(inverse(mat3(a.xyz, b.xyz, a.wzx)) * b.xyz, 0.0)": lambda a, b: g.vec4(
        g.mul(g.inverse(g.mat3(a[..., :3], b[..., :3], g.swizzle(a, "wzx"))), b[..., :3]),
        0.0,
    ),
    "vec4(determinant(mat2(a.xy, b.xy)))": lambda a, b: g.vec4(
        g.determinant(g.mat2(a[..., :2], b[..., :2]))
    ),
}
POSITIVE: dict[str, Formula] = {
    "sqrt(a)": lambda a, b: g.sqrt(a),
    "inversesqrt(a)": lambda a, b: g.inversesqrt(a),
    "1.0 / sqrt(a)": lambda a, b: 1.0 / g.sqrt(a),
    "log(a)": lambda a, b: g.log(a),
    "log2(a)": lambda a, b: g.log2(a),
    "a / b": lambda a, b: a / b,
    "1.0 / a": lambda a, b: 1.0 / a,
    "a / b * b": lambda a, b: a / b * b,
    "sin(a)": lambda a, b: g.sin(a),
    "a * b - b * a.yxwz": lambda a, b: a * b - b * g.swizzle(a, "yxwz"),
}
RATIOS: dict[str, Formula] = {
    "asin(a)": lambda a, b: g.asin(a),
    "acos(a)": lambda a, b: g.acos(a),
}


def random_expressions(count: int, seed: int) -> dict[str, Formula]:
    """Sums and products that a compiler may rearrange: text that is GLSL and Python at once."""
    rng = np.random.default_rng(seed)

    def expression(depth: int) -> str:
        if depth == 0 or rng.random() < 0.15:
            # No bare constants: the compiler folds those in float32, Python in float64.
            return str(rng.choice(["a", "b", "c", "d", "0.1 * a", "2.0 * b"]))
        inner = [expression(depth - 1) for _ in range(3)]
        patterns = [
            *("({0} + {1})", "({0} - {1})", "(({0}) * ({1}))", "({0} * {1} + {0} * {2})"),
            *("(({0} + {1}) - {0})", "({0} * (1.0 - {1}) + {2} * {1})", "({0} * {1} - {2} * {1})"),
            *("max({0}, {1})", "mix({0}, {1}, {2})", "(({0} + 0.1) * 0.7)"),
        ]
        return str(rng.choice(patterns)).format(*inner)

    names = {"max": g.max, "mix": g.mix}

    def formula(text: str) -> Formula:
        def run(a: Any, b: Any) -> Any:
            moved = {"c": g.swizzle(a, "yzwx"), "d": g.swizzle(b, "wzyx")}
            return eval(text, names | moved | {"a": a, "b": b})

        return run

    texts = [f"(a * {expression(3)} + b)" for _ in range(count)]
    return {text: formula(text) for text in texts}


def inputs(group: str, seed: int) -> np.ndarray:
    """SIZE² vec4 inputs of a group's domain, its corners among them."""
    rng = np.random.default_rng(seed)
    count = SIZE * SIZE * 4
    if group == "unit":
        values = rng.uniform(0.0, 1.0, count)
        values[:24] = np.tile([0.0, 1.0, 0.5, 0.2, 0.25, 1e-6], 4)
    elif group == "angles":
        values = rng.uniform(-3.14159, 3.14159, count)
        values[:16] = np.tile([1.0, -1.0, 0.5, 2.0], 4)
    elif group == "positive":
        values = np.exp2(rng.uniform(-40.0, 40.0, count))
        values[: count // 2] = rng.uniform(0.4, 2.5, count // 2)
        values[:8] = [1.0, 2.0, 0.5, 4.0, 1.5, 0.75, 3.0, 1e-3]
    else:
        values = rng.uniform(-1.0, 1.0, count)
        values[: count // 4] = 1.0 - np.exp2(rng.uniform(-24.0, 0.0, count // 4))
        values[:12] = np.tile([0.0, 1.0, -1.0], 4)
    return values.astype(np.float32).reshape(-1, 4)


def drawn(context: Any, expressions: list[str], a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    """What the driver makes of up to eight expressions, as (SIZE², 4) arrays."""
    outputs = "".join(f"layout(location = {i}) out vec4 out{i};\n" for i in range(len(expressions)))
    body = "".join(f"    out{i} = {text};\n" for i, text in enumerate(expressions))
    program = context.program(
        vertex_shader=VERTEX_SHADER,
        fragment_shader=f"""#version 330 core
            uniform sampler2D first;
            uniform sampler2D second;
            {outputs}
            void main() {{
                vec4 a = texelFetch(first, ivec2(gl_FragCoord.xy), 0);
                vec4 b = texelFetch(second, ivec2(gl_FragCoord.xy), 0);
                vec4 c = a.yzwx;
                vec4 d = b.wzyx;
                {body}
            }}""",
    )
    for unit, (name, values) in enumerate((("first", a), ("second", b))):
        context.texture((SIZE, SIZE), 4, values.tobytes(), dtype="f4").use(unit)
        if name in program:
            program[name] = unit
    targets = [context.texture((SIZE, SIZE), 4, dtype="f4") for _ in expressions]
    framebuffer = context.framebuffer(targets)
    framebuffer.use()
    context.vertex_array(program, []).render(vertices=3)
    pictures = []
    for i in range(len(expressions)):
        picture = np.empty((SIZE * SIZE, 4), np.float32)
        framebuffer.read_into(picture, components=4, attachment=i, dtype="f4")
        pictures.append(picture)
    return pictures


def stored(context: Any, values: np.ndarray) -> dict[str, np.ndarray]:
    """Values written to targets of several formats, as they come back, (SIZE², 1) each."""
    formats = {"rgba8": ("f1", None), "srgb8": ("f1", 0x8C43), "rgba16f": ("f2", None)}
    program = context.program(
        vertex_shader=VERTEX_SHADER,
        fragment_shader="""#version 330 core
            uniform sampler2D values;
            out vec4 colour;
            void main() {
                colour = texelFetch(values, ivec2(gl_FragCoord.xy), 0);
                gl_FragDepth = clamp(colour.r, 0.0, 1.0);  // softpipe doesn't clamp by itself
            }""",
    )
    wide = np.repeat(values.reshape(-1, 1), 4, axis=1)
    context.texture((SIZE, SIZE), 4, wide.astype(np.float32).tobytes(), dtype="f4").use(0)
    array = context.vertex_array(program, [])
    depth = context.depth_texture((SIZE, SIZE))
    read = {}
    for name, (dtype, internal) in formats.items():
        options = {} if internal is None else {"internal_format": internal}
        target = context.texture((SIZE, SIZE), 4, dtype=dtype, **options)
        framebuffer = context.framebuffer([target], depth)
        framebuffer.use()
        context.enable_direct(0x8DB9)  # GL_FRAMEBUFFER_SRGB
        context.enable(context.DEPTH_TEST)
        context.depth_func = "1"
        array.render(vertices=3)
        picture = np.empty((SIZE * SIZE, 4), {"f1": np.uint8, "f2": np.float16}[dtype])
        framebuffer.read_into(picture, components=4, dtype=dtype)
        read[name] = picture[:, 0:1].astype(np.float64)
    read["depth24"] = np.frombuffer(depth.read(), np.float32).reshape(-1, 1).astype(np.float64)
    return read


def judged_formats(context: Any) -> dict[str, Any]:
    """Per format: stored values outside what its rule allows, and the share of sharp ones."""
    values = np.linspace(-0.1, 1.1, SIZE * SIZE).astype(np.float32)
    found = {}
    for fmt, measured in stored(context, values).items():
        allowed = Band.exact(values[:, None]).quantise(fmt)
        found[fmt] = {
            "outside": int((~allowed.contains(measured)).sum()),
            "outside if shifted": float((~allowed.contains(np.roll(measured, 99))).mean()),
        }
    return found


def survey() -> dict[str, Any]:
    """Per expression: values outside, share of vacuous and undecided, the worst in half widths."""
    import moderngl

    context = moderngl.create_context(standalone=True, backend="egl")
    found: dict[str, Any] = {}
    random = random_expressions(48, seed=7)
    groups = {"unit": UNIT | random, "angles": ANGLES, "positive": POSITIVE, "ratios": RATIOS}
    for group, formulas in groups.items():
        a, b = inputs(group, 1), inputs(group, 2)
        band_a, band_b = Band.exact(a, RULES), Band.exact(b, RULES)
        texts = list(formulas)
        for start in range(0, len(texts), 8):
            some = texts[start : start + 8]
            for text, measured in zip(some, drawn(context, some, a, b), strict=True):
                band = formulas[text](band_a, band_b)
                inside = band.contains(measured)
                worst = int(np.argmax(np.where(inside, -1.0, band.widths(measured))))
                found[text] = {
                    "outside": int((~inside).sum()),
                    "vacuous": float(band.vacuous.mean()),
                    "undecided": float(band.undecided.mean()),
                    "widths": float(np.quantile(band.widths(measured), 0.999)),
                    "worst": None
                    if inside.all()
                    else [
                        a.reshape(-1, 4)[worst // 4].tolist(),
                        b.reshape(-1, 4)[worst // 4].tolist(),
                        float(measured.flat[worst]),
                        float(np.broadcast_to(band.lo, measured.shape).flat[worst]),
                        float(np.broadcast_to(band.hi, measured.shape).flat[worst]),
                    ],
                }
    return {
        "renderer": context.info["GL_RENDERER"],
        "found": found,
        "formats": judged_formats(context),
    }


@pytest.mark.parametrize("driver", ["llvmpipe", "softpipe"])
def test_nothing_a_driver_computes_is_outside(driver: str) -> None:
    environment = os.environ | {
        "GALLIUM_DRIVER": driver,
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "PYTHONPATH": str(ROOT),
    }
    done = subprocess.run(
        [sys.executable, __file__], env=environment, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    if driver not in answer["renderer"]:
        pytest.skip(f"this machine renders with {answer['renderer']}")
    outside = {text: found for text, found in answer["found"].items() if found["outside"]}
    assert not outside, f"{answer['renderer']}: {outside}"
    for fmt, found in answer["formats"].items():
        assert not found["outside"], f"{answer['renderer']} stores {fmt}: {found}"
        assert found["outside if shifted"] > 0.8, f"the rule of {fmt} could not fail"
    vacuous = {text: f["vacuous"] for text, f in answer["found"].items() if f["vacuous"] > 0.01}
    assert not vacuous, "a band that allows everything has shown nothing"


if __name__ == "__main__":
    print(json.dumps(survey()))
