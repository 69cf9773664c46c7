"""`--shader NAME=FILE`: which shader is meant, and whether anything read the file in its place."""

from __future__ import annotations

import posixpath
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from shaderlab.errors import UsageError, nearest
from shaderlab.model.records import Record
from shaderlab.workers import Job

Replacements = Mapping[str, Path]


def parsed(words: Sequence[str]) -> Replacements:
    """What stands on both sides of each NAME=FILE.

    Raises:
        UsageError: it is not of that form, or there is no such file.
    """
    found: dict[str, Path] = {}
    for word in words:
        name, equals, file = word.partition("=")
        if not equals or not name or not file:
            raise UsageError(f"--shader {word}: write it as NAME=FILE")
        if not Path(file).is_file():
            raise UsageError("there is no such file", file=file)
        found[posixpath.normpath(name)] = Path(file)
    return found


def named(
    replacements: Replacements,
    jobs: Iterable[Job],
    include: Sequence[Path] = (),
    renamed: Mapping[str, str] | None = None,
) -> Replacements:
    """Each name as the jobs' cases know it: its whole path, or the end of one, if only one ends
    so.

    Raises:
        UsageError: there is no shader of that name, or more than one; or the file declares other
            names (`renamed` says which are changed).
    """
    if not replacements:
        return {}
    from shaderlab.cli.renaming import require_same_names
    from shaderlab.engine.catalogue import shaders_of

    folders = dict.fromkeys(Path(job.file).parent for job in jobs)
    places = [shaders_of(folder, {}, include) for folder in folders]
    known = sorted({name for shaders in places for name in shaders.names()})
    whole = {
        name if any(shaders.has(name) for shaders in places) else _whole(name, known): file
        for name, file in replacements.items()
    }
    require_same_names(whole, renamed or {}, places)
    return whole


def unread(replacements: Replacements, records: Sequence[Record]) -> list[UsageError]:
    """An error for each file that no program was made of, so that nothing was said about it.

    Records of cases that did not get as far as their programs might have read it.
    """
    if not replacements or not all(record.programs for record in records):
        return []
    from shaderlab.files import display_path

    used = {file for record in records for program in record.programs for file in program.files}
    names = sorted({posixpath.basename(file.replace("\\", "/")) for file in used})
    return [
        UsageError(
            f"no program of these cases is made of {name}, so nothing was judged in its place",
            file=str(file),
            remedy=f"name a shader that they use: {', '.join(names)}",
        )
        for name, file in replacements.items()
        if display_path(file) not in used
    ]


def _whole(name: str, known: Sequence[str]) -> str:
    ends = [one for one in known if one.endswith(f"/{name}")]
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise UsageError(
            f"--shader {name}: there are {len(ends)} of that name",
            remedy=f"say which: {', '.join(ends)}",
        )
    short = {posixpath.basename(one): one for one in known}
    raise UsageError(
        f"--shader {name}: there is no such shader", remedy=nearest(name, [*known, *short])
    )
