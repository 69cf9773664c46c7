"""What of a case is mutated: its programs; and the passes that a mutant has a part in."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from pathlib import Path

from shaderlab.engine.search_path import shaders_of
from shaderlab.model.case import Case, Scene
from shaderlab.model.scene import Pass
from shaderlab.mutation.mutants import Operator, ShaderMutant, mutants_of


def scenes_of(case: Case, variants: Collection[str] = ()) -> list[Scene]:
    """The case's scenes: those of the `variants` that are named, or all."""
    return [s for s in case.scenes() if not variants or s.variant in variants]


def glsl_mutants(
    case: Case, variants: Collection[str] = (), operators: Iterable[Operator] | None = None
) -> list[ShaderMutant]:
    """Every mutant of every program of a case, in the order in which programs first appear.

    A mutant is one place in one program: what two programs include is mutated in each of them. A
    program that several draws, passes or variants share counts once.

    Args:
        case: the case.
        variants: names of those whose programs are mutated; all of them if empty.
        operators: kinds of mistakes; all of them by default.

    Raises:
        ShaderError: a shader can't be read.
    """
    shaders = shaders_of(Path(case.file).parent, {})
    programs = dict.fromkeys(
        draw.shaders
        for scene in scenes_of(case, variants)
        for description in scene.passes
        for draw in description.draws
    )
    made: dict[str, list[ShaderMutant]] = {}
    found: list[ShaderMutant] = []
    for program in programs:
        for name in program:
            if name not in made:
                made[name] = mutants_of(shaders.load(name), program, operators)
            found += (replace(mutant, program=program) for mutant in made[name])
    return found


def downstream(scene: Scene, passes: Collection[str]) -> set[str]:
    """These passes and all that read what they draw."""
    touched = set(passes)
    for description in scene.passes:
        if reads(description) & touched:
            touched.add(description.name)
    return touched


def reads(description: Pass) -> set[str]:
    """Names of the earlier passes whose outputs a pass reads as textures, faces and layers
    included, or in buffers, or goes on in."""
    found = {output.pass_name for draw in description.draws for output in draw.outputs_read()}
    return found | ({description.onto} if description.onto else set())


def with_what_they_read(scene: Scene, passes: Iterable[str]) -> set[str]:
    """These passes, and all earlier ones that they need as textures."""
    wanted = set(passes)
    for description in reversed(scene.passes):
        if description.name in wanted:
            wanted |= reads(description)
    return wanted
