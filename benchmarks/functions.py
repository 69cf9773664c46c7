"""What calling GLSL functions costs, beside a call for each value and beside a script by hand.

    python -m benchmarks.functions [--most 1e7] [--repeats 7]

The function is attenuation, of one float that varies. "By hand" is what people write with moderngl:
the values in a float texture, a triangle over the target, the target read back, in this process.
"One by one" is the design of tools that draw a pixel for each call. Times are the shortest of some
repeats, taken in turn; on a machine that is busy with other things the ratios mean more.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from shaderlab import glsl
from shaderlab.drivers.opengl import environment

FUNCTION = "float attenuation(float d) { return 1.0 / (1.0 + 0.09 * d + 0.032 * d * d); }"
TRIANGLE = """#version 330
void main()
{
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
"""
WIDTH = 4096


class ByHand:
    """The script: one program, textures for so many values."""

    def __init__(self, context: Any, count: int) -> None:
        import moderngl

        self.count, self.size = count, (min(count, WIDTH), -(-count // WIDTH))
        self.program = context.program(
            vertex_shader=TRIANGLE,
            fragment_shader=f"""#version 330
                uniform sampler2D values;
                out float y;
                {FUNCTION}
                void main() {{ y = attenuation(texelFetch(values, ivec2(gl_FragCoord), 0).r); }}
            """,
        )
        self.values = context.texture(self.size, 1, dtype="f4")
        self.values.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.target = context.framebuffer([context.texture(self.size, 1, dtype="f4")])
        self.array = context.vertex_array(self.program, [])

    def __call__(self, values: Any) -> Any:
        padded = np.zeros(self.size[0] * self.size[1], np.float32)
        padded[: self.count] = values
        self.values.write(padded)
        self.values.use(0)
        self.target.use()
        self.array.render(vertices=3)
        data = self.target.read(components=1, dtype="f4")
        return np.frombuffer(data, np.float32, self.count).copy()


class OneByOne:
    """A pixel a call, its argument a uniform."""

    def __init__(self, context: Any) -> None:
        self.program = context.program(
            vertex_shader=TRIANGLE,
            fragment_shader=f"#version 330\nuniform float d; out float y; {FUNCTION}"
            "void main() { y = attenuation(d); }",
        )
        self.target = context.framebuffer([context.texture((1, 1), 1, dtype="f4")])
        self.array = context.vertex_array(self.program, [])

    def __call__(self, value: float) -> float:
        self.program["d"].value = value
        self.target.use()
        self.array.render(vertices=3)
        return float(np.frombuffer(self.target.read(components=1, dtype="f4"), np.float32)[0])


def shortest(repeats: int, *calls: Callable[[], Any]) -> list[float]:
    """The shortest time of each, in seconds; they take turns."""
    found = [float("inf")] * len(calls)
    for _ in range(repeats):
        for n, call in enumerate(calls):
            began = time.perf_counter()
            call()
            found[n] = min(found[n], time.perf_counter() - began)
    return found


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--most", type=float, default=1e7, help="the most values of a call")
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    with environment("llvmpipe"):
        import moderngl

        arguments: Any = {"standalone": True, "backend": "egl"}
        context = moderngl.create_context(require=330, **arguments)

    function = glsl.load(FUNCTION).attenuation
    function(0.0)  # the worker is there, its device open
    firsts = []
    for n in range(options.repeats):
        other = glsl.load(FUNCTION.replace("0.09", f"0.09{n}")).attenuation
        began = time.perf_counter()
        other(0.0)
        firsts.append(time.perf_counter() - began)
    print(f"first call of another file: {1e3 * min(firsts):.1f} ms")

    single = OneByOne(context)
    ours, naive = shortest(
        options.repeats,
        lambda: [function(1.5) for _ in range(200)],
        lambda: [single(1.5) for _ in range(200)],
    )
    print(f"one value a call: {200 / ours:,.0f} calls/s; one by one, here: {200 / naive:,.0f}")
    count = 10_000
    while count <= options.most:
        values = np.linspace(0.0, 50.0, count, dtype=np.float32)
        by_hand = ByHand(context, count)
        assert np.array_equal(by_hand(values), function(values))
        ours, hand = shortest(
            options.repeats,
            lambda values=values: function(values),
            lambda by_hand=by_hand, values=values: by_hand(values),
        )
        print(
            f"{count:>10,} values: {1e3 * ours:8.2f} ms, {count / ours / 1e6:7.1f} M values/s, "
            f"{count / ours * naive / 200:9,.0f} × one by one, {ours / hand:.2f} × by hand"
        )
        count *= 10


if __name__ == "__main__":
    main()
