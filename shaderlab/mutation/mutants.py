"""A mutant: one small, realistic mistake; and all those of a shader file."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass

from tree_sitter import Node

from shaderlab.files import display_path
from shaderlab.glsl.sources import Source
from shaderlab.glsl.text import STAGES
from shaderlab.model import Scene
from shaderlab.mutation.names import Names, names_of
from shaderlab.mutation.syntax import Syntax, name_of, walk

Change = tuple[str, Node, Node, str]
"""What an operator proposes: its name, the node to show, the node to replace, the new text."""

Operator = Callable[[Node, Syntax, Names], Iterator[Change]]

_SHOWN = 72


@dataclass(frozen=True)
class Effect:
    """What a mutant changes in one scene.

    Attributes:
        scene: the scene with the mistake, if that is one of its data.
        texts: the shaders that are replaced, by name.
        passes: the passes that run what was changed.
        vertex_passes: those of them in which it is a vertex or geometry shader.
    """

    scene: Scene
    texts: Mapping[str, str]
    passes: frozenset[str]
    vertex_passes: frozenset[str] = frozenset()


@dataclass(frozen=True, kw_only=True)
class Mutant(ABC):
    """One mistake.

    Attributes:
        file, line: the place in the author's file, the line counted from 1; 0 for none.
        operator: the kind of mistake, such as "constant + 1 %".
        before, after: the expression or statement that shows it.
    """

    file: str
    line: int
    operator: str
    before: str
    after: str

    @abstractmethod
    def effect(self, scene: Scene, sources: Mapping[str, Source]) -> Effect | None:
        """What it changes in a scene; None for nothing. `sources` are the case's shaders."""

    def __str__(self) -> str:
        place = display_path(self.file, self.line or None)
        return f"{place}  {self.operator}: {self.before} → {self.after}"


@dataclass(frozen=True, kw_only=True)
class ShaderMutant(Mutant):
    """A mistake in one shader file: `shader` is its name inside the shader roots, `text` its whole
    text with the mistake."""

    shader: str
    text: str

    def effect(self, scene: Scene, sources: Mapping[str, Source]) -> Effect:
        def passes(stages: Collection[str]) -> frozenset[str]:
            running = {
                name
                for name, source in sources.items()
                if source.stage in stages and any(self.file == path for path, _ in source.parts)
            }
            return frozenset(
                description.name
                for description in scene.passes
                if any(running & set(draw.shaders) for draw in description.draws)
            )

        texts = {self.shader: self.text}
        return Effect(scene, texts, passes(STAGES), passes(("vertex", "geometry")))


def mutants_of(
    file: Syntax,
    *,
    shader: str,
    path: str,
    others: Iterable[Syntax] = (),
    functions: set[str] | None = None,
    operators: Iterable[Operator] | None = None,
) -> list[ShaderMutant]:
    """Every mutant of one file, in the order of its text; two ways to the same text count once.

    Args:
        file: the file itself.
        shader: its name inside the shader roots.
        path: where it is on disk.
        others: what it is compiled with, for the types of structs.
        functions: only the bodies of these are mutated, and what stands outside of functions;
            None for all of them.
        operators: kinds of mistakes; all of `shaderlab.mutation.operators.all_operators` by
            default.
    """
    if operators is None:
        from shaderlab.mutation.operators import all_operators

        operators = all_operators()
    names = names_of(file, others)
    chosen = tuple(operators)
    found: dict[str, ShaderMutant] = {}
    for node in walk(file.root):
        if _is_left_alone(node, file, functions):
            continue
        for operator in chosen:
            for change in operator(node, file, names):
                mutant = _mutant(change, file, shader, path)
                if mutant.text != file.text:
                    found.setdefault(mutant.text, mutant)
    return list(found.values())


def _mutant(change: Change, file: Syntax, shader: str, path: str) -> ShaderMutant:
    kind, shown, old, new = change
    head, tail = file.bytes[: old.start_byte], file.bytes[old.end_byte :]
    inside = (
        file.bytes[shown.start_byte : old.start_byte].decode(),
        file.bytes[old.end_byte : shown.end_byte].decode(),
    )
    return ShaderMutant(
        shader=shader,
        file=path,
        line=old.start_point[0] + 1,
        operator=kind,
        before=_short(inside[0], file.of(old), inside[1]),
        after=_short(inside[0], new, inside[1]) or "nothing",
        text=(head + new.encode() + tail).decode(),
    )


def _is_left_alone(node: Node, file: Syntax, functions: set[str] | None) -> bool:
    """Whether a node is no code that runs: layouts, array sizes, directives, unused functions."""
    around: Node | None = node
    while around is not None:
        if around.type.startswith("preproc") or around.type in (
            "layout_specification",
            "struct_specifier",
            "array_declarator",
        ):
            # An initialised array's declarator holds its size alone: `float w[3]`.
            return True
        if (
            around.type == "function_definition"
            and functions is not None
            and file.of(name_of(around)) not in functions
        ):
            return True
        around = around.parent
    return False


def _short(left: str, middle: str, right: str) -> str:
    """One line, cut where it is long, but not where the change is.

    >>> _short("a + ", "b", " + c")
    'a + b + c'
    >>> _short("", "x" * 99, "")[-3:]
    'xx…'
    """
    left, middle, right = (re.sub(r"\s+", " ", part) for part in (left, middle, right))
    if len(middle) > _SHOWN:
        middle = middle[: _SHOWN - 1] + "…"
    room = (_SHOWN - len(middle)) // 2
    if len(left) + len(middle) + len(right) > _SHOWN:
        left = left if len(left) <= room else "…" + left[len(left) - room :]
        right = right if len(right) <= room else right[:room] + "…"
    return (left + middle + right).strip()
