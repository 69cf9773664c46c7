"""Code coverage: the branches and terms of shaders that no judged pixel exercised.

A program is run once more with its expressions wrapped by functions that note what they saw: an
`if` that was never false, a `max` that never chose its second argument, a factor that was 1
everywhere. A mistake there changes no pixel, so that no expectation could notice it.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tree_sitter import Node

from shaderlab.compiler.compile import Compiled
from shaderlab.compiler.sources import Source
from shaderlab.compiler.syntax import (
    Syntax,
    arguments_of,
    field as field_of,
    name_of,
    operator_of,
    reachable,
)
from shaderlab.drivers.programs.prepare import PreparedDraw
from shaderlab.drivers.programs.stages import end_of_directives, may_drop_fragments
from shaderlab.engine.expectations.base import all_reads
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderError, UnsupportedError
from shaderlab.files import display_path
from shaderlab.model.case import Scene
from shaderlab.model.options import RunOptions
from shaderlab.model.records import CodeCoverage, CoverageGap

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker

# What each kind of point can see, a bit each, and the message if it never did.
ITEMS: dict[str, tuple[str, ...]] = {
    "condition": ("is never true", "is never false"),
    "term": ("is always 0", "is always 1"),
    "factor": ("is always 0", "is always 1"),
    "divisor": ("", "is always 1"),
    "max": ("never gives its first argument", "never gives its second argument"),
    "min": ("never gives its first argument", "never gives its second argument"),
    "clamp": ("is never below its range", "is never inside its range", "is never above its range"),
    "normalize": ("is of a vector whose length is 1 already",),
}
_CALLS = {"max": 2, "min": 2, "clamp": 3, "normalize": 1}
_OPERANDS = {
    **dict.fromkeys(("&&", "||", "^^"), ("condition", "condition")),
    **dict.fromkeys(("+", "-"), ("term", "term")),
    "*": ("factor", "factor"),
    "/": ("factor", "divisor"),
}
_COMPOUND = {"+=": "term", "-=": "term", "*=": "factor", "/=": "divisor"}
_IF = "if_statement"
# A main that is called by another one, and a last word before the fragment is gone.
_REPLACED = {
    ("identifier", "main"): "shaderlab_body",
    ("expression_statement", "discard;"): "{ shaderlab_note(); discard; }",
}
# What runs once for a program, or is no code: it can't be wrapped, nor does it vary.
_CONSTANT = ("preproc", "layout_specification", "struct_specifier", "array_declarator",
             "case_statement")  # fmt: skip

WORD = 32
"""Bits of one number of the buffer."""
_VECTORS = {"float": "vec", "int": "ivec", "uint": "uvec"}
_MATRICES = tuple(f"mat{c}x{r}" for c in (2, 3, 4) for r in (2, 3, 4))
# A direction that was normalised before is off by rounding alone.
_UNIT = "1e-4"

Place = tuple[str, int, int, str, str]
"""An author's file, line and column, the kind of point and its text."""


@dataclass(frozen=True)
class Point:
    """An expression that is watched: its kind, a key of ITEMS, its place in the text (line from 1,
    column from 0), its own text in one line, and the bit of its first item."""

    kind: str
    line: int
    column: int
    text: str
    bit: int


def wrap_points(text: str) -> tuple[str, list[Point]]:
    """Return the text of a stage after includes with its points wrapped, and the points.

    Each is wrapped by a GLSL function that notes what it sees; main becomes `shaderlab_body`.
    Functions that main does not reach are left alone.
    """
    file = Syntax(text)
    functions = reachable(file)
    points: list[Point] = []
    bits = itertools.count()

    def number(kind: str, node: Node) -> int:
        row, column = node.start_point
        first, *_ = (next(bits) for _ in ITEMS[kind])
        points.append(Point(kind, row + 1, column, " ".join(file.of(node).split()), first))
        return first

    def render(node: Node, kind: str = "") -> str:
        """The node's text, wrapped as `kind` says, with everything below it wrapped as well."""
        if node.type.startswith(_CONSTANT) or _is_left_alone(node, file, functions):
            return file.of(node)
        if (node.type, file.of(node)) in _REPLACED:
            return _REPLACED[node.type, file.of(node)]
        call = _watch_call(node, file)
        is_watched = bool(kind) and not _is_plain(node)
        head = f"shaderlab_{kind}({number(kind, node)}, " if is_watched else ""
        own = number(call, node) if call else None
        below = {child.start_byte: kind for child, kind in _watch_children(node, file)}
        parts, at = [], node.start_byte
        for child in node.children:
            parts.append(file.bytes[at : child.start_byte].decode())
            if own is not None and child.type == "argument_list":
                parts.append(f"({own}, " + render(child)[1:])
            elif own is not None and child == node.child_by_field_name("function"):
                parts.append(f"shaderlab_{call}")
            else:
                parts.append(render(child, below.get(child.start_byte, "") * child.is_named))
            at = child.end_byte
        parts.append(file.bytes[at : node.end_byte].decode())
        return head + "".join(parts) + (")" if head else "")

    return render(file.root), points


def _watch_children(node: Node, file: Syntax) -> Iterator[tuple[Node, str]]:
    if node.type == "binary_expression":
        word = file.of(operator_of(node))
        left, right = field_of(node, "left"), field_of(node, "right")
        kinds = _OPERANDS.get(word, ("", ""))
        inner = file.of(operator_of(left)) if left.type == "binary_expression" else ""
        # Of a + b + c, a and b are watched, not their sum.
        if not inner or _OPERANDS.get(inner, ("", ""))[0] != kinds[0]:
            yield left, kinds[0]
        yield right, kinds[1]
    elif node.type == "assignment_expression":
        kind = _COMPOUND.get(file.of(operator_of(node)))
        if kind:
            yield field_of(node, "right"), kind
    elif node.type == "conditional_expression":
        yield field_of(node, "condition"), "condition"
    elif node.type == "parenthesized_expression" and node.parent and node.parent.type == _IF:
        yield next(child for child in node.children if child.is_named), "condition"


def _watch_call(node: Node, file: Syntax) -> str:
    """The kind of a call of a built-in function that chooses; "" for every other node."""
    if node.type != "call_expression":
        return ""
    name = file.of(field_of(node, "function"))
    watched = _CALLS.get(name) == len(arguments_of(node)) and name not in file.functions
    return name if watched else ""


def _is_plain(node: Node) -> bool:
    """Whether a node is a number, with a sign or without: what it is can be read."""
    if node.type in ("number_literal", "true", "false"):
        return True
    if node.type in ("unary_expression", "parenthesized_expression"):
        inner = [child for child in node.children if child.is_named]
        return len(inner) == 1 and _is_plain(inner[0])
    return False


def _is_left_alone(node: Node, file: Syntax, functions: set[str]) -> bool:
    """Whether nothing in a node is watched: constants and what is never called."""
    if node.type == "function_definition":
        return file.of(name_of(node)) not in functions
    # Outside of functions, an initialiser has to be a constant expression.
    outside = node.parent is None or node.parent.type == "translation_unit"
    words = [file.of(child) for child in node.children if child.type == "type_qualifier"]
    return node.type == "declaration" and (outside or "const" in words)


def instrument(text: str, stage: str, first: int, words: int) -> str:
    """Return the text of a stage whose points are wrapped, with all that they need around it.

    An invocation keeps its bits to itself and adds them to the buffer when it ends, if they are
    new: a write a point would take ten times as long.

    Args:
        text: the result of `wrap_points`.
        stage: "vertex", "geometry" or "fragment".
        first: the number in the buffer where the stage's bits begin.
        words: how many numbers it has there.
    """
    end = end_of_directives(text)
    early = stage == "fragment" and not may_drop_fragments(text)
    before = "\n".join(_declarations(first, words, early))
    zeros = " ".join(f"shaderlab_own[{i}] = 0u;" for i in range(words))
    main = f"void main() {{ {zeros} shaderlab_body(); shaderlab_note(); }}"
    return f"{text[:end]}{before}\n{text[end:]}\n{main}\n"


def _declarations(first: int, words: int, early: bool) -> Iterator[str]:
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
    kinds = [*_MATRICES]
    for scalar, vector in _VECTORS.items():
        for size in (1, 2, 3, 4):
            kind = scalar if size == 1 else f"{vector}{size}"
            kinds.append(kind)
            yield from _min_max_clamp(kind, kind, size)
            if size > 1:
                yield from _min_max_clamp(kind, scalar, size)
            if scalar == "float":
                longer = f"abs(dot(v, v) - 1.0) > {_UNIT}"
                yield from _wrapper(kind, "normalize", [f"{kind} v"], [longer], "normalize(v)")
    for kind in kinds:
        for name in ("term", "factor", "divisor"):
            items = [f"v != {kind}(0)", f"v != {kind}(1)"]
            yield from _wrapper(kind, name, [f"{kind} v"], items, "v")


def _wrapper(
    kind: str, name: str, parameters: list[str], items: list[str], value: str
) -> Iterator[str]:
    yield f"{kind} shaderlab_{name}({', '.join(['int bit', *parameters])}) {{"
    for i, item in enumerate(items):
        yield f"    shaderlab_see(bit + {i}, {item});"
    yield f"    return {value};"
    yield "}"


def _min_max_clamp(kind: str, other: str, size: int) -> Iterator[str]:
    """max, min and clamp of `kind` against bounds of type `other`."""

    def less(a: str, b: str) -> str:
        return f"{a} < {b}" if size == 1 else f"any(lessThan({kind}({a}), {kind}({b})))"

    two, three = [f"{kind} a", f"{other} b"], [f"{kind} x", f"{other} low", f"{other} high"]
    yield from _wrapper(kind, "max", two, [less("b", "a"), less("a", "b")], "max(a, b)")
    yield from _wrapper(kind, "min", two, [less("a", "b"), less("b", "a")], "min(a, b)")
    below, above = less("x", "low"), less("high", "x")
    items = [below, f"!({below}) && !({above})", above]
    yield from _wrapper(kind, "clamp", three, items, "clamp(x, low, high)")


def measure_coverage(lab: SceneRunner, scenes: Iterable[Scene]) -> CodeCoverage:
    """Return what the judged draws of some scenes of one case exercised of their shaders.

    A point that several programs share, or several scenes run, was exercised if one of them did.

    Raises:
        UnsupportedError: the driver has no storage buffers, or refuses a watched program.
        ShaderError, CaseError: a scene can't be drawn.
    """
    seen: Counter[tuple[Place, str]] = Counter()
    case_id = ""
    for scene in scenes:
        case_id = scene.case.id
        for item, now in _see_items(lab, scene):
            seen[item] += now
    gaps = [
        CoverageGap(file=display_path(file), line=line, text=text, what=what)
        for (file, line, _, _, text), what in sorted(s for s, now in seen.items() if not now)
    ]
    return CodeCoverage(id=case_id, items=len(seen), gaps=tuple(dict.fromkeys(gaps)))


@dataclass
class _Stages:
    """The stages whose points are wrapped, each once, and where their bits are in the buffer."""

    stages: dict[Source, Source] = field(default_factory=dict)
    points: list[tuple[Source, Point, int]] = field(default_factory=list)
    words: int = 0

    def stage(self, source: Source) -> Source:
        if source not in self.stages:
            text, points = wrap_points(source.text)
            words = -(-sum(len(ITEMS[point.kind]) for point in points) // WORD)
            if points:
                text = instrument(text, source.stage, self.words, words)
                self.points += [(source, point, self.words) for point in points]
                self.words += words
            self.stages[source] = replace(source, text=text if points else source.text)
        return self.stages[source]


def _see_items(lab: SceneRunner, scene: Scene) -> Iterator[tuple[tuple[Place, str], bool]]:
    """Each item of the points of a scene's judged stages, and whether it was seen."""
    every = _Stages()
    programs = {
        name: tuple(
            _instrument_draw(scene, (name, index), draw, every) for index, draw in enumerate(draws)
        )
        for name, draws in lab.prepare_for_opengl(scene).items()
    }
    if not every.words:
        return
    with lab.backend.storage(every.words) as read:
        try:
            with lab.evaluation(scene, programs) as evaluation:
                for expectation in scene.expect:
                    evaluation.gather(expectation)
        except ShaderError as error:
            raise UnsupportedError(
                f"{scene.case.id}: this driver refuses a program whose branches are watched "
                f"({error.message.splitlines()[0]})",
                file=scene.case.file or None,
            ) from error
        buffer = read()
    for source, point, first in every.points:
        file, line = source.place(point.line)
        place = (file, line, point.column, point.kind, point.text)
        for i, what in enumerate(ITEMS[point.kind]):
            if what:
                word, bit = divmod(point.bit + i, WORD)
                yield (place, what), bool(int(buffer[first + word]) >> bit & 1)


def _instrument_draw(
    scene: Scene, key: tuple[str, int], draw: PreparedDraw, every: _Stages
) -> PreparedDraw:
    """A draw with those of its stages watched that an expectation judges."""
    name, index = key
    reads = (r for r in all_reads(scene) if r.pass_name == name and r.draw in (None, index))
    read = {r.output for r in reads}
    judged = {"vertex", "geometry"} if read else set()
    if read & {*draw.outputs, "depth", "stencil", "coverage"}:
        judged.add("fragment")
    sources = (
        every.stage(source) if source in draw.authored and source.stage in judged else source
        for source in draw.sources
    )

    def compile_original(_: Sequence[Source], targets: Sequence[str]) -> Compiled:
        return draw.compiling(draw.sources[:1], targets)

    return replace(draw, sources=tuple(sources), compiling=compile_original)


@dataclass(frozen=True)
class CoverCase:
    """Requests the `CodeCoverage` of some variants of a case."""

    file: Path
    variants: tuple[str, ...]
    options: RunOptions

    def perform(self, worker: Worker) -> CodeCoverage:
        scenes = worker.scenes(str(self.file))

        def each() -> Iterator[Scene]:
            for name in self.variants:
                worker.restart_limit()  # it is that of a scene
                yield scenes[name]

        return measure_coverage(worker.lab(self.options), each())
