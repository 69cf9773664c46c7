"""What of a case is mutated: its shader files, with the passes that each one has a part in."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from shaderlab.errors import ShaderError
from shaderlab.evaluation.search_path import shaders_of
from shaderlab.glsl.sources import Source
from shaderlab.model import Case, Pass, Scene, outputs_read
from shaderlab.mutation.mutants import ShaderMutant, mutants_of
from shaderlab.mutation.syntax import Syntax, reachable


@dataclass(frozen=True)
class ShaderFile:
    """One file that a case's programs are made of, with all it is compiled together with."""

    name: str
    path: str
    text: str
    beside: tuple[str, ...]


def glsl_mutants(case: Case) -> list[ShaderMutant]:
    """Every mutant of every shader file of a case; a law file that several shaders include counts
    once. Functions that none of the case's programs calls are left alone.

    Raises:
        ShaderError: a file can't be read.
    """
    found: list[ShaderMutant] = []
    for file in shader_files(case):
        others = [Syntax(text) for text in file.beside]
        own = Syntax(file.text)
        found += mutants_of(
            own,
            shader=file.name,
            path=file.path,
            others=others,
            functions=reachable([own, *others]),
        )
    return found


def shader_files(case: Case) -> list[ShaderFile]:
    """The files of all programs of all variants, in the order in which they first appear."""
    sources = dict(_sources(case))
    files: dict[str, ShaderFile] = {}
    for scene in case.scenes():
        for description in scene.passes:
            for draw in description.draws:
                program = [sources[name] for name in draw.shaders]
                for path, text in (part for source in program for part in source.parts):
                    others = [t for s in program for p, t in s.parts if p != path]
                    known = files.get(path)
                    beside = {*others, *(known.beside if known else ())}
                    name = known.name if known else _name(path, case)
                    files[path] = ShaderFile(name, path, text, tuple(sorted(beside)))
    return list(files.values())


def downstream(scene: Scene, passes: Collection[str]) -> set[str]:
    """These passes and all that read what they draw."""
    touched = set(passes)
    for description in scene.passes:
        if reads(description) & touched:
            touched.add(description.name)
    return touched


def reads(description: Pass) -> set[str]:
    """Names of the earlier passes whose outputs a pass reads as textures, faces and layers
    included, or goes on in."""
    found = {
        output.pass_name
        for draw in description.draws
        for texture in draw.textures.values()
        for output in outputs_read(texture)
    }
    return found | ({description.onto} if description.onto else set())


def with_what_they_read(scene: Scene, passes: Iterable[str]) -> set[str]:
    """These passes, and all earlier ones that they need as textures."""
    wanted = set(passes)
    for description in reversed(scene.passes):
        if description.name in wanted:
            wanted |= reads(description)
    return wanted


def sources_of(case: Case) -> dict[str, Source]:
    """Every shader of the case by its name, read once."""
    return dict(_sources(case))


def _sources(case: Case) -> Iterator[tuple[str, Source]]:
    shaders = shaders_of(Path(case.file).parent, {})
    seen: set[str] = set()
    for scene in case.scenes():
        for description in scene.passes:
            for draw in description.draws:
                for name in set(draw.shaders) - seen:
                    seen.add(name)
                    yield name, shaders.load(name)


def _name(path: str, case: Case) -> str:
    """The name by which a file inside the shader roots is asked for and replaced."""
    from shaderlab.discovery import data_folder

    folder = Path(case.file).parent
    for root in (data_folder("shaders"), folder / "shaders", folder):
        if Path(path).resolve().is_relative_to(root.resolve()):
            return Path(path).resolve().relative_to(root.resolve()).as_posix()
    raise ShaderError("this file lies in no shader folder of the case", file=path)
