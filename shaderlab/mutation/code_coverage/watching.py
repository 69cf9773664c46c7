"""The GLSL functions that points are wrapped by, and the buffer that they write to."""

from __future__ import annotations

from collections.abc import Iterator

from shaderlab.drivers.programs.stages import after_directives, may_keep_out

WORD = 32
"""Bits of one number of the buffer."""
_VECTORS = {"float": "vec", "int": "ivec", "uint": "uvec"}
_MATRICES = tuple(f"mat{c}x{r}" for c in (2, 3, 4) for r in (2, 3, 4))
# A direction that was normalised before is off by rounding alone.
_UNIT = "1e-4"


def watched(text: str, stage: str, first: int, words: int) -> str:
    """The text of a stage whose points are wrapped, with all that they need around it.

    An invocation keeps its bits to itself and adds them to the buffer when it ends, if they are
    new: a write a point would take ten times as long.

    Args:
        text: see `points.wrapped`.
        stage: "vertex", "geometry" or "fragment".
        first: the number in the buffer where the stage's bits begin.
        words: how many numbers it has there.
    """
    end = after_directives(text)
    early = stage == "fragment" and not may_keep_out(text)
    before = "\n".join(_before(first, words, early))
    zeros = " ".join(f"shaderlab_own[{i}] = 0u;" for i in range(words))
    main = f"void main() {{ {zeros} shaderlab_body(); shaderlab_note(); }}"
    return f"{text[:end]}{before}\n{text[end:]}\n{main}\n"


def _before(first: int, words: int, early: bool) -> Iterator[str]:
    yield "#extension GL_ARB_shader_storage_buffer_object : require"
    if early:  # a fragment that fails a test is not seen, and must not count
        yield "#extension GL_ARB_shader_image_load_store : require"
        yield "layout(early_fragment_tests) in;"
    yield "layout(std430) buffer shaderlab_Seen { uint shaderlab_seen[]; };"
    yield f"uint shaderlab_own[{words}];"
    yield "void shaderlab_note() {"
    for i in range(words):
        yield f"    if ((shaderlab_own[{i}] & ~shaderlab_seen[{first + i}]) != 0u)"
        yield f"        atomicOr(shaderlab_seen[{first + i}], shaderlab_own[{i}]);"
    yield "}"
    yield "void shaderlab_see(int bit, bool now) {"
    yield f"    shaderlab_own[bit / {WORD}] |= uint(now) << (bit % {WORD});"
    yield "}"
    yield from _wrapper("bool", "condition", ["bool v"], ["v", "!v"], "v")
    for scalar, vector in _VECTORS.items():
        for size in (1, 2, 3, 4):
            kind = scalar if size == 1 else f"{vector}{size}"
            yield from _operands(kind)
            yield from _choices(kind, kind, size)
            if size > 1:
                yield from _choices(kind, scalar, size)
            if scalar == "float":
                longer = f"abs(dot(v, v) - 1.0) > {_UNIT}"
                yield from _wrapper(kind, "normalize", [f"{kind} v"], [longer], "normalize(v)")
    for kind in _MATRICES:
        yield from _operands(kind)


def _wrapper(
    kind: str, name: str, parameters: list[str], items: list[str], value: str
) -> Iterator[str]:
    """A function that notes which of the conditions hold, one bit each, and returns a value."""
    yield f"{kind} shaderlab_{name}({', '.join(['int bit', *parameters])}) {{"
    for i, item in enumerate(items):
        yield f"    shaderlab_see(bit + {i}, {item});"
    yield f"    return {value};"
    yield "}"


def _operands(kind: str) -> Iterator[str]:
    other = [f"v != {kind}(0)", f"v != {kind}(1)"]
    for name in ("term", "factor", "divisor"):
        yield from _wrapper(kind, name, [f"{kind} v"], other, "v")


def _choices(kind: str, other: str, size: int) -> Iterator[str]:
    """max, min and clamp of `kind` against bounds of type `other`."""

    def less(a: str, b: str) -> str:
        return f"{a} < {b}" if size == 1 else f"any(lessThan({kind}({a}), {kind}({b})))"

    two, three = [f"{kind} a", f"{other} b"], [f"{kind} x", f"{other} low", f"{other} high"]
    yield from _wrapper(kind, "max", two, [less("b", "a"), less("a", "b")], "max(a, b)")
    yield from _wrapper(kind, "min", two, [less("a", "b"), less("b", "a")], "min(a, b)")
    below, above = less("x", "low"), less("high", "x")
    inside = f"!({below}) && !({above})"
    items = [below, inside, above]
    yield from _wrapper(kind, "clamp", three, items, "clamp(x, low, high)")
