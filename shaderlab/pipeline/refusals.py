"""Asking for what must be refused: the compilers and the driver for programs, the lab for files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from shaderlab.activity import doing
from shaderlab.checks.refusals import Answer, Complaint
from shaderlab.errors import DriverError, ShaderlabError
from shaderlab.glsl.sources import Source
from shaderlab.model import CompileFails, Refused, Scene
from shaderlab.programs.prepare import Preparer
from shaderlab.records import Verdict

Opinion = Callable[[tuple[Source, ...]], Verdict]


def gathered(
    scene: Scene, preparer: Preparer, opinion: Opinion
) -> Mapping[int, Answer | Complaint]:
    """For each expectation about a refusal, by its place in `scene.expect`, what was said.

    Args:
        scene: what is run.
        preparer: reads and compiles its shaders.
        opinion: asks the driver about a program.

    Raises:
        ShaderError: a shader that a compiler must refuse can't even be read.
    """
    folders = (Path(scene.case.file).parent, *preparer.folders)
    found: dict[int, Answer | Complaint] = {}
    for index, expectation in enumerate(scene.expect):
        if isinstance(expectation, CompileFails):
            found[index] = _answer(expectation, preparer, opinion, folders)
        elif isinstance(expectation, Refused):
            found[index] = _complaint(expectation, preparer, folders)
    return found


def _answer(
    expectation: CompileFails, preparer: Preparer, opinion: Opinion, folders: Iterable[Path]
) -> Answer:
    with doing("compile"):
        sources, compiled = preparer.refusal(expectation.shaders)
    names = {source.path: source.name for source in sources}
    verdict = compiled.verdicts[0]
    try:
        driver = opinion(sources)
    except DriverError:  # it has no such stage: glslang's verdict is the only one
        driver = None
    return Answer(
        errors=tuple(
            (names.get(d.file) or shortened(d.file, folders), d.line, d.message)
            for d in verdict.diagnostics
            if d.severity == "error"
        ),
        accepted=verdict.ok,
        stages={source.name: source.stage for source in sources},
        driver=driver,
    )


def _complaint(expectation: Refused, preparer: Preparer, folders: Iterable[Path]) -> Complaint:
    folders = tuple(folders)
    what = expectation.what
    try:
        if isinstance(what, str):
            preparer.source(what)
        else:
            what()
    except ShaderlabError as error:
        return Complaint(
            error=ShaderlabError(
                shortened(error.message, folders),
                file=None if error.file is None else shortened(error.file, folders),
                line=error.line,
                remedy=None if error.remedy is None else shortened(error.remedy, folders),
            )
        )
    return Complaint(error=None)


def shortened(text: str, folders: Iterable[Path]) -> str:
    """The text with these folders left out of its paths, and a folder alone by its own name.

    >>> shortened("/a/b/x.frag:3 is not in /a/b", [Path("/a/b")])
    'x.frag:3 is not in b'
    """
    for folder in sorted({str(f) for f in folders}, key=len, reverse=True):
        text = text.replace(f"{folder}/", "").replace(folder, Path(folder).name)
    return text
