"""A mutant: one small, realistic mistake; and all those of a shader."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from tree_sitter import Node

from shaderlab.compiler.sources import Source
from shaderlab.compiler.syntax import Syntax, name_of, reachable, walk
from shaderlab.files import display_path
from shaderlab.model.calls import CallEdit
from shaderlab.model.case import Scene
from shaderlab.mutation.names import Names, names_of

Change = tuple[str, Node, Node, str]
"""What an operator proposes: its name, the node to show, the node to replace, the new text."""

Operator = Callable[[Node, Syntax, Names], Iterator[Change]]

_SHOWN = 72
_CONDITIONAL = ("preproc_if", "preproc_ifdef", "preproc_elif", "preproc_else")
_CONDITION = ("condition", "name")  # the fields of #if, and of #ifdef
# An initialised array's declarator holds its size alone: `float w[3]`.
_NO_CODE = ("layout_specification", "struct_specifier", "array_declarator")


@dataclass(frozen=True)
class Effect:
    """What a mutant changes in one scene.

    Attributes:
        scene: the scene with the mistake, if that is one of its data.
        passes: the passes that run what was changed.
        vertex_passes: those of them in which it is a vertex or geometry shader.
        program: the shaders of the program whose text is changed.
        texts: the texts to take in place of some of its shaders', by name.
        edit: what becomes of one call of its drawing.
    """

    scene: Scene
    passes: frozenset[str]
    vertex_passes: frozenset[str] = frozenset()
    program: tuple[str, ...] = ()
    texts: Mapping[str, str] = field(default_factory=dict)
    edit: CallEdit | None = None


@dataclass(frozen=True, kw_only=True)
class Mutant(ABC):
    """One mistake.

    Attributes:
        file, line: the place in the author's file, the line counted from 1; 0 for none.
        operator: the kind of mistake, such as "constant + 1 %".
        before, after: the expression or statement that shows it.
        program: the shaders of the program that has it; none for a mistake in state or calls.
    """

    file: str
    line: int
    operator: str
    before: str
    after: str
    program: tuple[str, ...] = ()

    @abstractmethod
    def effect(self, scene: Scene) -> Effect | None:
        """What it changes in a scene; None for nothing."""

    def __str__(self) -> str:
        place = display_path(self.file, self.line or None)
        alone = len(self.program) == 1 and self.file.endswith(self.program)
        where = f"  in {' + '.join(self.program)}" if self.program and not alone else ""
        return f"{place}  {self.operator}: {self.before} → {self.after}{where}"


@dataclass(frozen=True, kw_only=True)
class ShaderMutant(Mutant):
    """A mistake in one stage of one program: `shader` is the stage's name inside the shader roots,
    `text` its whole text with includes expanded and with the mistake."""

    shader: str
    stage: str
    text: str

    def effect(self, scene: Scene) -> Effect | None:
        passes = frozenset(
            description.name
            for description in scene.passes
            if any(draw.shaders == self.program for draw in description.draws)
        )
        if not passes:
            return None
        before = frozenset[str]() if self.stage == "fragment" else passes
        return Effect(scene, passes, before, self.program, {self.shader: self.text})


def mutants_of(
    source: Source,
    program: tuple[str, ...],
    operators: Iterable[Operator] | None = None,
    functions: Iterable[str] = ("main",),
) -> list[ShaderMutant]:
    """Every mutant of one stage of a program, in the order of its text; two ways to the same text
    count once. Functions that its `main` does not reach are left alone.

    Args:
        source: the stage, with includes expanded.
        program: the names of the program's shaders.
        operators: kinds of mistakes; all of `shaderlab.mutation.operators.all_operators` by
            default.
        functions: the names of those that are called from outside, in place of `main`.
    """
    if operators is None:
        from shaderlab.mutation.operators import all_operators

        operators = all_operators()
    file = Syntax(source.text, source.stage)
    names, reached, chosen = names_of(file), reachable(file, functions), tuple(operators)
    found: dict[str, ShaderMutant] = {}
    for node in walk(file.root):
        if _is_left_alone(node, file, reached):
            continue
        for operator in chosen:
            for kind, shown, old, new in operator(node, file, names):
                text = _with(file, old, new)
                if text == file.text or text in found:
                    continue
                left = file.bytes[shown.start_byte : old.start_byte].decode()
                right = file.bytes[old.end_byte : shown.end_byte].decode()
                path, line = source.place(old.start_point[0] + 1)
                found[text] = ShaderMutant(
                    file=path,
                    line=line,
                    operator=kind,
                    before=_short(left, file.of(old), right),
                    after=_short(left, new, right) or "nothing",
                    program=program,
                    shader=source.name,
                    stage=source.stage,
                    text=text,
                )
    return list(found.values())


def _with(file: Syntax, node: Node, text: str) -> str:
    head, tail = file.bytes[: node.start_byte], file.bytes[node.end_byte :]
    return (head + text.encode() + tail).decode()


def _is_left_alone(node: Node, file: Syntax, functions: set[str]) -> bool:
    """Whether a node is no code that runs: layouts, array sizes, directives, unused functions."""
    inner, around = node, node.parent
    while True:
        if inner.type == "function_definition" and file.of(name_of(inner)) not in functions:
            return True
        directive = inner.type.startswith("preproc") and inner.type not in _CONDITIONAL
        if directive or inner.type in _NO_CODE:
            return True
        if around is None:
            return False
        # What stands between #if and #endif is code.
        if around.type in _CONDITIONAL and inner in map(around.child_by_field_name, _CONDITION):
            return True
        inner, around = around, around.parent


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
