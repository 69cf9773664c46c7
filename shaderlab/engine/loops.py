"""Whether the loops of a scene's shaders end: llvmpipe ends all loops of an invocation after 65,535
turns in all, and a shader that loops for ever, or that long, would pass.

A scene is drawn once more with shaders that count the turns of loops not short by their bounds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, lru_cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from shaderlab.compiler.shader_files import strip_comments
from shaderlab.compiler.sources import Source
from shaderlab.compiler.syntax import Node, Syntax, walk
from shaderlab.drivers import STORAGE_OF_PROBES
from shaderlab.drivers.programs.prepare import PreparedDraw, Programs
from shaderlab.drivers.programs.stages import end_of_directives
from shaderlab.errors import ShaderError, UnsupportedError

if TYPE_CHECKING:
    from shaderlab.engine.run import SceneRunner
    from shaderlab.model.case import Scene

_MOST_TURNS = 65_000
_SHORT = 4096  # turns of all loops with constant bounds, inside one another
_LOOPS = ("for_statement", "while_statement", "do_statement")
_BOUND = r"(-?\w+)\s*(?:([-+])\s*(\d+)\s*)?"
_COUNTING = re.compile(
    rf"for\s*\(\s*u?int\s+(\w+)\s*=\s*{_BOUND};\s*\1\s*([<>])=?\s*{_BOUND}(?:&&[\w\s.<>&!]*)?;"
    r"\s*(?:(\+\+|--)\s*\1|\1\s*(?:(\+\+|--)|([-+])=\s*[1-9]\d*))\s*\)"
)
_CONSTANT = re.compile(
    r"(?:\bconst\s+u?int\s+(\w+)\s*=|#\s*define\s+(\w+))\s+(-?\d+)u?\s*(?:;|$)", re.MULTILINE
)


def require_loops_to_end(lab: SceneRunner, scene: Scene, programs: Programs) -> None:
    """Raise ShaderError for a loop of a scene that its driver, llvmpipe, cuts short.

    Nothing is said where there are no storage buffers to count in.
    """
    loops: list[tuple[Source, int]] = []
    # One text for all draws of a source: the driver compiles it once.
    count = cache(partial(count_turns, loops=loops))
    counted = {
        name: tuple(_count_draw(draw, count) for draw in draws) for name, draws in programs.items()
    }

    def draw() -> None:
        with lab.evaluation(scene, counted):
            pass

    _require_ends(lab, loops, draw)


def require_passes_to_end(
    lab: SceneRunner, passes: Sequence[tuple[Source, int]], run: Callable[[Any], None]
) -> None:
    """As `require_loops_to_end`, for the passes of a `drivers.Evaluation`, which `run` runs."""
    loops: list[tuple[Source, int]] = []
    counted = tuple((count_turns(source, loops), words) for source, words in passes)
    _require_ends(lab, loops, lambda: run(counted))


def _require_ends(
    lab: SceneRunner, loops: Sequence[tuple[Source, int]], draw: Callable[[], None]
) -> None:
    if not loops:
        return
    try:
        with lab.backend.storage(len(loops), STORAGE_OF_PROBES) as read:
            draw()
            seen = read()
    except UnsupportedError:
        return
    for (source, line), late in zip(loops, seen, strict=True):
        if late:
            file, own_line = source.place(line)
            raise ShaderError(
                f"the loop at {file}:{own_line} does not end: its shader goes on after "
                f"{_MOST_TURNS:,} turns, and the driver cuts it",
                remedy="give the loop a bound that it reaches earlier",
            )


def _count_draw(draw: PreparedDraw, count: Callable[[Source], Source]) -> PreparedDraw:
    sources = tuple(count(each) if each in draw.authored else each for each in draw.sources)
    first = draw.sources[:1]
    return replace(draw, sources=sources, compiling=lambda _, to: draw.compiling(first, to))


def count_turns(source: Source, loops: list[tuple[Source, int]]) -> Source:
    """A stage that notes in a buffer which of its loops goes on for too long, appended to `loops`
    with its line; the stage as it is where all of them are short, or its version of GLSL has no
    such buffer."""
    file, nodes = _parse(source.text)
    version, profile = source.version
    if not nodes or version < 140 or profile == "es":
        return source
    inserts: dict[int, str] = {}
    for node in nodes:
        body = node.child_by_field_name("body") or node.children[-1]
        start, end = body.start_byte, body.end_byte
        inserts[start] = f"{{ shaderlab_turn({len(loops)}); " + inserts.get(start, "")
        inserts[end] = inserts.get(end, "") + " }"
        loops.append((source, node.start_point[0] + 1))
    cuts = pairwise([0, *sorted(inserts), len(file.bytes)])
    text = "".join(file.bytes[at:end].decode() + inserts.get(end, "") for at, end in cuts)
    end = end_of_directives(text)
    return replace(source, text="\n".join([text[:end], *_declarations(), text[end:]]))


@lru_cache(maxsize=256)
def _parse(text: str) -> tuple[Syntax, list[Node]]:
    """A text's loops; none where all of them are short."""
    file = Syntax(text)
    nodes = [node for node in walk(file.root) if node.type in _LOOPS]
    return file, [] if all_are_short(text, [file.of(node) for node in nodes]) else nodes


def _declarations() -> Iterator[str]:
    yield "#extension GL_ARB_shader_storage_buffer_object : require"
    yield "#extension GL_ARB_shading_language_420pack : require"
    yield f"layout(std430, binding = {STORAGE_OF_PROBES}) buffer shaderlab_Late {{"
    yield "    uint shaderlab_late[];"
    yield "};"
    yield "int shaderlab_turns = 0;"
    yield "void shaderlab_turn(int loop) {"
    yield f"    if (++shaderlab_turns == {_MOST_TURNS}) shaderlab_late[loop] = 1u;"
    yield "}"


def all_are_short(text: str, loops: list[str]) -> bool:
    """Whether constants bound all of these loops of a text, inside one another perhaps."""
    text = strip_comments(text)
    values = {a or b: int(value) for a, b, value in _CONSTANT.findall(text)}
    return math.prod(_bound(strip_comments(loop), values) for loop in loops) <= _SHORT


def _bound(loop: str, values: dict[str, int]) -> float:
    """How many turns a loop takes at most; infinite where that is not plain to see."""
    head = _COUNTING.match(loop)
    if head is None:
        return math.inf
    name, step = head[1], r"(?:\+\+|--)"
    first, last = (_value(head.group(n, n + 1, n + 2), values) for n in (2, 6))
    rises = (head[9] or head[10] or head[11])[0] == "+"
    changes = rf"\b{name}\s*(?:(?:[-+*/%&|^]|<<|>>)?=(?!=)|{step})|{step}\s*{name}\b"
    if rises != (head[5] == "<") or re.search(changes, loop[head.end() :]):
        return math.inf
    return max(1.0, abs(last - first) + 1)


def _value(parts: tuple[str, ...], values: dict[str, int]) -> float:
    word, sign, offset = parts
    bare = word.rstrip("uU")
    value = int(bare) if bare.lstrip("-").isdecimal() else values.get(word, math.inf)
    return value + int(f"{sign}{offset}") if sign else value
