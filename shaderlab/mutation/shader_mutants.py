"""All mutants of shaders: each operator applied to each node of their syntax trees."""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tree_sitter import Node

from shaderlab.compiler.shader_files import find_sections
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.compiler.syntax import Syntax, name_of, reachable, walk
from shaderlab.engine.catalogue import shaders_of
from shaderlab.model.case import Case, Scene
from shaderlab.mutation.mutants import Effect, Mutant, select_scenes
from shaderlab.mutation.names import Operator, collect_names
from shaderlab.mutation.operators import OPERATORS

_LONGEST = 72
_CONDITIONAL = ("preproc_if", "preproc_ifdef", "preproc_elif", "preproc_else")
_CONDITION = ("condition", "name")  # the fields of #if, and of #ifdef
# An initialised array's declarator holds its size alone: `float w[3]`.
_NO_CODE = ("layout_specification", "struct_specifier", "array_declarator")


@dataclass(frozen=True, kw_only=True)
class ShaderMutant(Mutant):
    """A mistake in one stage of one program: `shader` is the stage's name inside the shader roots,
    `text` its whole text with includes expanded and with the mistake."""

    shader: str
    stage: str
    text: str

    def effect(self, scene: Scene) -> Effect | None:
        users = (p for p in scene.passes if any(d.shaders == self.program for d in p.draws))
        passes = frozenset(description.name for description in users)
        if not passes:
            return None
        vertex_passes = frozenset[str]() if self.stage == "fragment" else passes
        return Effect(scene, passes, vertex_passes, self.program, {self.shader: self.text})


def mutate_case(
    case: Case, variants: Collection[str] = (), operators: Iterable[Operator] = OPERATORS
) -> list[ShaderMutant]:
    """Return every mutant of every program of a case, in the order in which programs first appear.

    A mutant is one place in one program: what two programs include is mutated in each of them. A
    program of several draws, passes or variants counts once. Raises ShaderError: a shader
    can't be read."""
    shaders = shaders_of(Path(case.file).parent, {})
    passes = (description for s in select_scenes(case, variants) for description in s.passes)
    programs = dict.fromkeys(draw.shaders for each in passes for draw in each.draws)
    by_stage: dict[str, list[ShaderMutant]] = {}
    mutants: list[ShaderMutant] = []
    for program in programs:
        for name in dict.fromkeys(program):
            if name not in by_stage:
                by_stage[name] = _mutate_file(shaders, name, program, tuple(operators))
            mutants += (replace(mutant, program=program) for mutant in by_stage[name])
    return mutants


def _mutate_file(
    shaders: Shaders, name: str, program: tuple[str, ...], operators: Sequence[Operator]
) -> list[ShaderMutant]:
    """Every mutant of the stages of one file that a program has."""
    stages = shaders.load_stages(name)
    if not find_sections(text for _, text in stages[0].parts):
        return mutate_stage(stages[0], program, operators)
    used = [one.stage for one in stages] if program.count(name) > 1 else [shaders.load(name).stage]
    mutants = []
    for one in stages:
        texts = {each.stage: each.text for each in stages}
        for mutant in mutate_stage(one, program, operators) if one.stage in used else ():
            texts[one.stage] = mutant.text
            text = "\n".join(f"#type {stage}\n{own}" for stage, own in texts.items())
            mutants.append(replace(mutant, text=text))
    return mutants


def mutate_stage(
    source: Source,
    program: tuple[str, ...],
    operators: Iterable[Operator] = OPERATORS,
    functions: Iterable[str] = ("main",),
) -> list[ShaderMutant]:
    """Return every mutant of one stage of a program, in the order of its text; `program` are the
    names of its shaders. Two ways to the same text count once. Functions that its `main`, or else
    one of `functions`, does not reach are left alone."""
    file = Syntax(source.text, source.stage)
    names, reached, operators = collect_names(file), reachable(file, functions), tuple(operators)
    by_text: dict[str, ShaderMutant] = {}
    for node in walk(file.root):
        if _is_left_alone(node, file, reached):
            continue
        for kind, shown, old, new in (
            change for operator in operators for change in operator(node, file, names)
        ):
            head, tail = file.bytes[: old.start_byte], file.bytes[old.end_byte :]
            text = (head + new.encode() + tail).decode()
            if text == file.text or text in by_text:
                continue
            left = file.bytes[shown.start_byte : old.start_byte].decode()
            right = file.bytes[old.end_byte : shown.end_byte].decode()
            column = len(head.rpartition(b"\n")[2].decode())
            path, line = source.place(old.start_point[0] + 1)
            by_text[text] = ShaderMutant(
                file=path,
                line=line,
                operator=kind,
                before=_shorten(left, file.of(old), right),
                after=_shorten(left, new, right) or "nothing",
                program=program,
                text_edit=(source.name, old.start_point[0] + 1, column, file.of(old), new),
                shader=source.name,
                stage=source.stage,
                text=text,
            )
    return list(by_text.values())


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


def _shorten(left: str, middle: str, right: str) -> str:
    """One line, cut where it is long, but not where the change is.

    >>> _shorten("a + ", "b", " + c")
    'a + b + c'
    >>> _shorten("", "x" * 99, "")[-3:]
    'xx…'
    """
    left, middle, right = (re.sub(r"\s+", " ", part) for part in (left, middle, right))
    if len(middle) > _LONGEST:
        middle = middle[: _LONGEST - 1] + "…"
    side = (_LONGEST - len(middle)) // 2
    if len(left) + len(middle) + len(right) > _LONGEST:
        left = left if len(left) <= side else "…" + left[len(left) - side :]
        right = right if len(right) <= side else right[:side] + "…"
    return (left + middle + right).strip()
