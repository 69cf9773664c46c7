"""Each function that GLSL gained with versions 4: what llvmpipe and softpipe compute lies in its
band, and what a similar function computes does not.

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
from shaderlab.bands import Band, Integer, Rules
from shaderlab.engine.judging.bands import store_band, to_result

SIZE = 32
RULES = Rules()
ROOT = Path(__file__).resolve().parents[2]

# Function: GLSL over a (vec4 in -3…3), u (in 0…1), n (ivec4) and m (uvec4 of any bits), the
# formula, and GLSL of a mistake.
Row = tuple[str, Callable[..., Any], str]
FLOATS: dict[str, Row] = {
    "sinh": ("sinh(a)", lambda i: g.sinh(i.a), "cosh(a)"),
    "cosh": ("cosh(a)", lambda i: g.cosh(i.a), "sinh(a)"),
    "tanh": ("tanh(a)", lambda i: g.tanh(i.a), "sinh(a)"),
    "asinh": ("asinh(a)", lambda i: g.asinh(i.a), "asinh(a * 1.01)"),
    "acosh": ("acosh(u + 1.5)", lambda i: g.acosh(i.u + 1.5), "asinh(u + 1.5)"),
    "atanh": ("atanh(u * 0.9)", lambda i: g.atanh(i.u * 0.9), "atan(u * 0.9)"),
    "fma": ("fma(a, u, a)", lambda i: g.fma(i.a, i.u, i.a), "fma(a, a, u)"),
    "ldexp": ("ldexp(a, n & 7)", lambda i: g.ldexp(i.a, i.n & 7), "ldexp(a, n & 3)"),
    "intBitsToFloat": (
        "intBitsToFloat((n & 0x7FFFFF) + 0x3F800000)",
        lambda i: g.intBitsToFloat((i.n & 0x7FFFFF) + 0x3F800000),
        "vec4((n & 0x7FFFFF) + 0x3F800000)",
    ),
    "uintBitsToFloat": (
        "uintBitsToFloat((m & 0x7FFFFFu) + 0x3F800000u)",
        lambda i: g.uintBitsToFloat((i.m & 0x7FFFFF) + 0x3F800000),
        "vec4((m & 0x7FFFFFu) + 0x3F800000u)",
    ),
    "modf": ("modf_fraction(a)", lambda i: g.modf(i.a)[0], "fract(a)"),
    "modf, whole": ("modf_whole(a)", lambda i: g.modf(i.a)[1], "floor(a)"),
    "frexp": ("frexp_significand(a)", lambda i: g.frexp(i.a)[0], "a"),
    "unpackUnorm2x16": (
        "vec4(unpackUnorm2x16(m.x), 0.0, 0.0)",
        lambda i: g.vec4(g.unpackUnorm2x16(i.m.x), 0.0, 0.0),
        "vec4(unpackUnorm2x16(m.x).yx, 0.0, 0.0)",
    ),
    "unpackSnorm2x16": (
        "vec4(unpackSnorm2x16(m.x), 0.0, 0.0)",
        lambda i: g.vec4(g.unpackSnorm2x16(i.m.x), 0.0, 0.0),
        "vec4(unpackUnorm2x16(m.x), 0.0, 0.0)",
    ),
    "unpackUnorm4x8": ("unpackUnorm4x8(m.x)", lambda i: g.unpackUnorm4x8(i.m.x), "u"),
    "unpackSnorm4x8": (
        "unpackSnorm4x8(m.x)",
        lambda i: g.unpackSnorm4x8(i.m.x),
        "unpackUnorm4x8(m.x)",
    ),
    "unpackHalf2x16": (
        "vec4(unpackHalf2x16(m.x & 0x7BFF7BFFu), 0.0, 0.0)",
        lambda i: g.vec4(g.unpackHalf2x16(i.m.x & 0x7BFF7BFF), 0.0, 0.0),
        "vec4(unpackHalf2x16(m.x & 0x7BFF7BFFu).yx, 0.0, 0.0)",
    ),
    "float": ("vec4(n)", lambda i: g.float(i.n), "vec4(m)"),
    "isnan": ("vec4(isnan(a))", lambda i: g.float(g.isnan(i.a)), "vec4(1.0)"),
    "isinf": ("vec4(isinf(a))", lambda i: g.float(g.isinf(i.a)), "vec4(1.0)"),
    "lessThan": ("vec4(lessThan(a, u))", lambda i: g.float(g.lessThan(i.a, i.u)), "vec4(2.0)"),
    "not": (
        "vec4(not(greaterThanEqual(a, u)))",
        lambda i: g.float(g.not_(g.greaterThanEqual(i.a, i.u))),
        "vec4(greaterThanEqual(a, u))",
    ),
    "any, all": (
        "vec4(any(lessThan(n, ivec4(0))), all(lessThan(n, ivec4(0))), 0.0, 0.0)",
        lambda i: g.vec4(
            g.float(g.any(g.lessThan(i.n, 0))), g.float(g.all(g.lessThan(i.n, 0))), 0.0, 0.0
        ),
        "vec4(all(lessThan(n, ivec4(0))), any(lessThan(n, ivec4(0))), 0.0, 0.0)",
    ),
    "outerProduct": (
        "outerProduct(a, u)[1]",
        lambda i: g.outerProduct(i.a, i.u)[..., :, 1],
        "outerProduct(u, a)[1]",
    ),
    "transpose": (
        "transpose(mat4(a, u, u, a))[1]",
        lambda i: g.transpose(g.mat4(i.a, i.u, i.u, i.a))[..., :, 1],
        "mat4(a, u, u, a)[1]",
    ),
    "matrixCompMult": (
        "matrixCompMult(mat4(a, u, u, a), mat4(u, u, a, a))[0]",
        lambda i: g.matrixCompMult(g.mat4(i.a, i.u, i.u, i.a), g.mat4(i.u, i.u, i.a, i.a))[..., 0],
        "(mat4(a, u, u, a) * mat4(u, u, a, a))[0]",
    ),
    "determinant": (
        "vec4(determinant(mat2(a.xy, u.xy)))",
        lambda i: g.vec4(g.determinant(g.mat2(i.a.xy, i.u.xy))),
        "vec4(determinant(mat2(u.xy, a.xy)))",
    ),
    "inverse": (
        "vec4(inverse(mat2(a.xy, u.xy + 4.0))[0], 0.0, 0.0)",
        lambda i: g.vec4(g.inverse(g.mat2(i.a.xy, i.u.xy + 4.0))[..., :, 0], 0.0, 0.0),
        "vec4(inverse(mat2(a.xy, u.xy + 4.0))[1], 0.0, 0.0)",
    ),
    "dFdx": ("dFdx(a)", lambda i: g.dFdx(i.a, i.frag_coord), "dFdy(a)"),
    "dFdy": ("dFdy(a)", lambda i: g.dFdy(i.a, i.frag_coord), "dFdx(a)"),
    "fwidth": ("fwidth(a)", lambda i: g.fwidth(i.a, i.frag_coord), "abs(dFdx(a))"),
}
SIGNED: dict[str, Row] = {
    "int": ("ivec4(a * 1000.0)", lambda i: g.int(i.a * 1000.0), "ivec4(floor(a * 1000.0))"),
    "frexp, exponent": ("frexp_exponent(a)", lambda i: g.frexp(i.a)[1], "ivec4(log2(abs(a)))"),
    "floatBitsToInt": ("floatBitsToInt(a)", lambda i: g.floatBitsToInt(i.a), "ivec4(a)"),
    "+ - *": ("n * n + 7 - n", lambda i: i.n * i.n + 7 - i.n, "n * n + 8 - n"),
    "/": ("n / 3", lambda i: i.n / 3, "n >> 2"),
    "<< >>": ("(n << 3) ^ (n >> 5)", lambda i: (i.n << 3) ^ (i.n >> 5), "(n << 3) | (n >> 5)"),
    "& | ~": ("(n & 255) | ~n", lambda i: (i.n & 255) | ~i.n, "(n & 127) | ~n"),
    "abs, sign": ("abs(n) * sign(n)", lambda i: g.abs(i.n) * g.sign(i.n), "abs(n)"),
    "min, max": ("min(max(n, 5), 900)", lambda i: g.clamp(i.n, 5, 900), "max(n, 5)"),
    "bitfieldExtract": (
        "bitfieldExtract(n, 5, 9)",
        lambda i: g.bitfieldExtract(i.n, 5, 9),
        "(n >> 5) & 511",
    ),
    "bitfieldInsert": (
        "bitfieldInsert(n, n.yxwz, 4, 8)",
        lambda i: g.bitfieldInsert(i.n, i.n.yxwz, 4, 8),
        "bitfieldInsert(n, n.yxwz, 3, 8)",
    ),
    "bitCount": ("bitCount(n)", lambda i: g.bitCount(i.n), "bitCount(n) + 1"),
    "findLSB": ("findLSB(n)", lambda i: g.findLSB(i.n), "findMSB(n)"),
    "findMSB": ("findMSB(n)", lambda i: g.findMSB(i.n), "findLSB(n)"),
    "findMSB, unsigned": ("findMSB(m)", lambda i: g.findMSB(i.m), "findLSB(m)"),
    "imulExtended": ("imul_upper(n)", lambda i: g.imulExtended(i.n, i.n.yxwz)[0], "n * n.yxwz"),
}
UNSIGNED: dict[str, Row] = {
    "uint": ("uvec4(u * 1e5)", lambda i: g.uint(i.u * 1e5), "uvec4(u * 1e5) + 1u"),
    "floatBitsToUint": ("floatBitsToUint(u)", lambda i: g.floatBitsToUint(i.u), "uvec4(u)"),
    "% /": ("m % 1000u + m / 7u", lambda i: i.m % 1000 + i.m / 7, "m % 1001u + m / 7u"),
    "bitfieldReverse": ("bitfieldReverse(m)", lambda i: g.bitfieldReverse(i.m), "~m"),
    "bitfieldExtract, unsigned": (
        "bitfieldExtract(m, 7, 11)",
        lambda i: g.bitfieldExtract(i.m, 7, 11),
        "bitfieldExtract(m, 6, 11)",
    ),
    "uaddCarry": ("carry(m)", lambda i: g.uaddCarry(i.m, i.m.yxwz)[1], "1u - carry(m)"),
    "usubBorrow": ("borrow(m)", lambda i: g.usubBorrow(i.m, i.m.yxwz)[1], "carry(m)"),
    "umulExtended": ("umul_upper(m)", lambda i: g.umulExtended(i.m, i.m.yxwz)[0], "m * m.yxwz"),
    "packUnorm2x16": (
        "uvec4(packUnorm2x16(u.xy))",
        lambda i: g.uvec4(g.packUnorm2x16(i.u.xy)),
        "uvec4(packUnorm2x16(u.yx))",
    ),
    "packSnorm2x16": (
        "uvec4(packSnorm2x16(a.xy))",
        lambda i: g.uvec4(g.packSnorm2x16(i.a.xy)),
        "uvec4(packUnorm2x16(a.xy))",
    ),
    "packUnorm4x8": (
        "uvec4(packUnorm4x8(u))",
        lambda i: g.uvec4(g.packUnorm4x8(i.u)),
        "uvec4(packUnorm4x8(u.wzyx))",
    ),
    "packSnorm4x8": (
        "uvec4(packSnorm4x8(a))",
        lambda i: g.uvec4(g.packSnorm4x8(i.a)),
        "uvec4(packUnorm4x8(a))",
    ),
    "packHalf2x16": (
        "uvec4(packHalf2x16(vec2(n.xy & 1023)))",
        lambda i: g.uvec4(g.packHalf2x16(g.float(i.n.xy & 1023))),
        "uvec4(packHalf2x16(vec2(n.yx & 1023)))",
    ),
}
GROUPS = {"vec4": FLOATS, "ivec4": SIGNED, "uvec4": UNSIGNED}

EXTENSIONS = ("gpu_shader5", "shading_language_packing", "shader_bit_encoding")
HEAD = "#version 330 core\n" + "".join(f"#extension GL_ARB_{e} : enable\n" for e in EXTENSIONS)
# What GLSL gives in `out` arguments, by functions that are only in shaders that call them.
HELPERS = {
    "modf_fraction": "vec4 modf_fraction(vec4 a) { vec4 whole; return modf(a, whole); }",
    "modf_whole": "vec4 modf_whole(vec4 a) { vec4 whole; modf(a, whole); return whole; }",
    "frexp_significand": "vec4 frexp_significand(vec4 a) { ivec4 e; return frexp(a, e); }",
    "frexp_exponent": "ivec4 frexp_exponent(vec4 a) { ivec4 e; frexp(a, e); return e; }",
    "carry": "uvec4 carry(uvec4 m) { uvec4 c; uaddCarry(m, m.yxwz, c); return c; }",
    "borrow": "uvec4 borrow(uvec4 m) { uvec4 b; usubBorrow(m, m.yxwz, b); return b; }",
    "umul_upper": "uvec4 umul_upper(uvec4 m)"
    "{ uvec4 u, l; umulExtended(m, m.yxwz, u, l); return u; }",
    "imul_upper": "ivec4 imul_upper(ivec4 n)"
    "{ ivec4 u, l; imulExtended(n, n.yxwz, u, l); return u; }",
}
VERTEX = """#version 330 core
    void main() {
        gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
    }"""


class Given:
    """The inputs of all pixels, in float32 and 32-bit integers."""

    def __init__(self) -> None:
        rng = np.random.default_rng(11)
        shape = (SIZE * SIZE, 4)
        wide = rng.uniform(-3.0, 3.0, shape).astype(np.float32)
        unit = rng.uniform(0.0, 1.0, shape).astype(np.float32)
        bits = (rng.integers(-(2**31), 2**31, shape) >> rng.integers(0, 31, shape)).astype(np.int32)
        bits[:2] = [[0, -1, 1, -(2**31)], [2**31 - 1, 2**24 + 1, -2, 40]]
        self.arrays = (wide, unit, bits)
        y, x = np.divmod(np.arange(SIZE * SIZE), SIZE)
        self.frag_coord = np.stack([x + 0.5, y + 0.5], axis=-1)
        self.a, self.u = Band.exact(wide, RULES), Band.exact(unit, RULES)
        self.n = Integer(bits, rules=RULES)
        self.m = Integer(bits.view(np.uint32), unsigned=True, rules=RULES)


def drawn(context: Any, kind: str, texts: list[str]) -> list[np.ndarray]:
    """What the driver makes of some expressions of one type, as (SIZE², 4) arrays."""
    outputs = "".join(f"layout(location = {k}) out {kind} o{k};\n" for k in range(len(texts)))
    body = "".join(f"o{k} = {text};\n" for k, text in enumerate(texts))
    helpers = [text for name, text in HELPERS.items() if f"{name}(" in body]
    fragment = f"""{HEAD}
        uniform sampler2D wide, unit;
        uniform isampler2D bits;
        {outputs}
        {"".join(helpers)}
        void main() {{
            ivec2 place = ivec2(gl_FragCoord.xy);
            vec4 a = texelFetch(wide, place, 0), u = texelFetch(unit, place, 0);
            ivec4 n = texelFetch(bits, place, 0);
            uvec4 m = uvec4(n);
            {body}
        }}"""
    program = context.program(vertex_shader=VERTEX, fragment_shader=fragment)
    for unit, name in enumerate(("wide", "unit", "bits")):
        if name in program:
            program[name] = unit
    dtype = {"vec4": "f4", "ivec4": "i4", "uvec4": "u4"}[kind]
    targets = [context.texture((SIZE, SIZE), 4, dtype=dtype) for _ in texts]
    framebuffer = context.framebuffer(targets)
    framebuffer.use()
    context.vertex_array(program, []).render(vertices=3)
    return [np.frombuffer(t.read(), dtype).reshape(-1, 4) for t in targets]


def survey() -> dict[str, Any]:
    """Per function: values outside its band, those of the mistake, the share of vacuous ones."""
    import moderngl

    context = moderngl.create_context(standalone=True, backend="egl")
    given = Given()
    for unit, array in enumerate(given.arrays):
        dtype = "i4" if array.dtype == np.int32 else "f4"
        texture = context.texture((SIZE, SIZE), 4, array.tobytes(), dtype=dtype)
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        texture.use(unit)
    found: dict[str, Any] = {}
    for kind, rows in GROUPS.items():
        format = {"vec4": "rgba32f", "ivec4": "rgba32i", "uvec4": "rgba32ui"}[kind]
        for name, (text, formula, mistake) in rows.items():
            right, wrong = drawn(context, kind, [text, mistake])
            with np.errstate(all="ignore"):
                band = store_band(to_result(formula(given), format, RULES), format, 4)
            inside = band.contains(right)
            worst = int(np.argmin(inside.ravel()))
            ends = [np.broadcast_to(end, right.shape).flat[worst] for end in (band.lo, band.hi)]
            found[name] = {
                "outside": int((~inside).sum()),
                "first": [float(right.flat[worst]), *map(float, ends)],
                "of the mistake": int((~band.contains(wrong)).sum()),
                "vacuous": float(band.vacuous.mean()),
            }
    return {"renderer": context.info["GL_RENDERER"], "found": found}


@pytest.mark.parametrize("driver", ["llvmpipe", "softpipe"])
def test_functions_lie_in_their_bands_and_others_do_not(driver: str) -> None:
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
    found = answer["found"]
    for name, row in found.items():
        assert row["outside"] == 0, f"{name}: {row}"
        assert row["of the mistake"] > 0, f"{name}: the mistake is not noticed: {row}"
        assert row["vacuous"] <= 0.02, f"{name}: {row}"


if __name__ == "__main__":
    print(json.dumps(survey()))
