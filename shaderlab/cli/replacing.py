"""`--shader NAME=FILE` and `--rename`: which shader is meant, whether its interface fits, and
whether the file was used."""

from __future__ import annotations

import difflib
import posixpath
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.reflection import Interface
from shaderlab.compiler.shader_files import read_shader, strip_comments
from shaderlab.compiler.sources import Shaders
from shaderlab.engine.jobs import Job
from shaderlab.errors import ShaderError, UsageError, suggest
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

Replacements = Mapping[str, Path]


def replace_shaders(
    options: RunOptions, shaders: Sequence[str], renames: Sequence[str], jobs: Iterable[Job]
) -> RunOptions:
    """Return the options with the files of `--shader` and the names of `--rename`.

    Raises:
        UsageError: a word is malformed, no shader has the name, or the file doesn't fit.
    """
    files = parse_replacements(shaders)
    names = parse_renames(renames, list(files.values()))
    files = resolve_replacements(files, jobs, options.include, names)
    return replace(options, shaders=files, renames=names)


def parse_replacements(words: Sequence[str]) -> Replacements:
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


def resolve_replacements(
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
    from shaderlab.engine.catalogue import shaders_of

    folders = dict.fromkeys(Path(job.file).parent for job in jobs)
    places = [shaders_of(folder, {}, include) for folder in folders]
    known = sorted({name for shaders in places for name in shaders.names()})
    whole = {
        name if any(shaders.has(name) for shaders in places) else _complete_name(name, known): file
        for name, file in replacements.items()
    }
    check_interfaces(whole, renamed or {}, places)
    return whole


def find_unused(replacements: Replacements, records: Sequence[Record]) -> list[UsageError]:
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


def _complete_name(name: str, known: Sequence[str]) -> str:
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
        f"--shader {name}: there is no such shader", remedy=suggest(name, [*known, *short])
    )


_KINDS = ("attributes", "varyings", "uniforms", "outputs")
_DECLARED = re.compile(
    r"\b(?:in|out|uniform|varying|attribute)\b[^;{}()]*?(\w+)\s*(?:\[\w*\]\s*)?;"
)


def parse_renames(words: Sequence[str], files: Sequence[Path]) -> dict[str, str]:
    """What each OLD=NEW says: a name in one of the files, and what the case calls it.

    Raises:
        UsageError: it is not of that form, no file has the old name, or one has the new one too.
    """
    found: dict[str, str] = {}
    codes = {file: strip_comments(read_shader(file)) for file in files if words}
    for word in words:
        old, _, new = word.partition("=")
        if not re.fullmatch(r"[A-Za-z_]\w*", old) or not re.fullmatch(r"[A-Za-z_]\w*", new):
            raise UsageError(
                f"--rename {word}: write it as NAME=OTHER", remedy="--rename vNormal=Normal"
            )
        having = [file for file, code in codes.items() if re.search(rf"\b{old}\b", code)]
        if not having:
            declared = [name for code in codes.values() for name in _DECLARED.findall(code)]
            raise UsageError(
                f"--rename {word}: no file given by --shader has a name {old!r}",
                remedy=suggest(old, declared) if codes else "give the file: --shader NAME=FILE",
            )
        for file in having:
            if re.search(rf"\b{new}\b", codes[file]):
                raise UsageError(f"--rename {word}: there is a {new!r} already", file=file)
        found[old] = new
    return found


def check_interfaces(
    replacements: Mapping[str, Path], renamed: Mapping[str, str], places: Sequence[Shaders]
) -> None:
    """Raise UsageError, once for all cases, where a shader can't stand in for another one: it reads
    inputs or uniforms that the other does not, or lacks some of its uniforms.

    Args:
        replacements: files by the name of the shader that each stands in for.
        renamed: the names in them that are changed.
        places: where shaders are found.
    """
    for name, file in replacements.items():
        for shaders in places:
            if not shaders.has(name):
                continue
            folders = [file.parent, *shaders.folders]
            stand_in = Shaders(folders, overrides={name: file}, renames=renamed)
            before, after = _interface(shaders, name), _interface(stand_in, name)
            if before is not None and after is not None:
                _compare(name, file, before, after)


def _compare(name: str, file: Path, before: Interface, after: Interface) -> None:
    differences, pairs, fatal = [], [], False
    for kind in _KINDS:
        old, new = getattr(before, kind), getattr(after, kind)
        extra, missing = [n for n in new if n not in old], [n for n in old if n not in new]
        fatal = (
            fatal or (kind != "outputs" and bool(extra)) or (kind == "uniforms" and bool(missing))
        )
        if extra or missing:
            has = f"has {', '.join(extra)}" if extra else ""
            lacks = f"lacks {', '.join(missing)}" if missing else ""
            said = " and ".join(filter(None, [has, lacks]))
            differences.append(f"of {'inputs' if kind in _KINDS[:2] else kind} it {said}")
        types = {n: old[n].type for n in missing}
        pairs += list(_pairs({n: new[n].type for n in extra}, types))
    if fatal:
        raise UsageError(
            f"it can't stand in for {name} as it is: {'; '.join(differences)}",
            file=file,
            remedy=" ".join(f"--rename {new}={old}" for new, old in pairs)
            or "declare what the shader declares that it stands in for",
        )


def _pairs(extra: Mapping[str, str], missing: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """New names with the old ones of the same type that are most like them."""
    left = dict(missing)
    for new, kind in extra.items():
        alike = {old.lower(): old for old, other in left.items() if other == kind}
        close = difflib.get_close_matches(new.lower(), alike, n=1, cutoff=0.0)
        if close and "." not in new:
            yield new, alike[close[0]]
            del left[alike[close[0]]]


def _interface(shaders: Shaders, name: str) -> Interface | None:
    """What a shader alone declares; None where it does not compile alone."""
    try:
        return compile_program([shaders.load(name)], ("glsl", "opengl")).interface
    except ShaderError:
        return None
