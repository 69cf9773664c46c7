"""Choosing what is run by what was typed: cases and variants, and with `--shader NAME=FILE` and
`--rename` the shaders that are replaced.

Case files are found by name and read, never imported here: executors load them.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.compiler.shader_files import refuse_other_languages
from shaderlab.engine.catalogue import (
    MAX_BYTES,
    case_files,
    files_below,
    is_case_file,
    shipped_cases,
    sort_key,
)
from shaderlab.engine.jobs import CaseInfo, Job, make_jobs
from shaderlab.errors import CaseError, UsageError, suggest
from shaderlab.files import display_path, read_regular

if TYPE_CHECKING:
    from shaderlab.model.options import RunOptions
    from shaderlab.model.records import Record

Load = Callable[[Sequence[Path]], list[CaseInfo]]
_NAME = re.compile(r"test_.*\.py|.*_test\.py")
_LOADS = re.compile(rb"\bshaderlab\b.*\bglsl\b", re.DOTALL)
_TESTS = re.compile(rb"^\s*(?:async\s+)?def test", re.MULTILINE)
_WITH_VARIANT = re.compile(r"(?P<id>[^\[\]]+)\[(?P<variant>.*)\]")


def select_jobs(
    targets: Sequence[str], every: bool, variants: Sequence[str], load: Load
) -> list[Job]:
    """The jobs of all `targets` (ids, ids with a variant, case files, folders), in order; before
    them those of `every` shipped case, if asked for. If `variants` are named, of these alone.

    Raises UsageError: nothing is named, or something that does not exist; CaseError: the only case
    file is wrong. One that is wrong among others is a job that says so."""
    if not targets and not every:
        raise UsageError("nothing to run", remedy="name cases or case files, or use --all")
    wanted = [(file, variant) for target in targets for file, variant in resolve_target(target)]
    shipped = list(shipped_cases()) if every else []
    files = list(dict.fromkeys([*shipped, *(file for file, _ in wanted)]))
    facts = dict(zip(files, make_ids_distinct(load(files)), strict=True))
    in_order = sorted((facts[f] for f in shipped), key=lambda case: sort_key(case.section, case.id))
    chosen = [(case, None) for case in in_order] + [(facts[file], v) for file, v in wanted]
    jobs: dict[tuple[str, str, str], Job] = {}
    for case, variant in chosen:
        jobs |= {job.key: job for job in select_variants(case, variant) if job.key not in jobs}
    errors = [case.error for case in facts.values() if case.error is not None]
    if errors and len(jobs) == 1:
        raise errors[0]
    return _keep_variants(list(jobs.values()), variants)


def select_one(target: str, load: Load) -> tuple[CaseInfo, str]:
    """The single case that `target` names, and its variant; the first where none is named. Raises
    UsageError: there is no such case or variant, or several; CaseError: its file is wrong."""
    wanted = resolve_target(target)
    if len(wanted) != 1:
        raise UsageError(f"{target}: {len(wanted)} cases; name one of them")
    ((file, variant),) = wanted
    (facts,) = load([file])
    if facts.error is not None:
        raise facts.error
    return facts, select_variants(facts, variant)[0].variant


def find_files(targets: Sequence[str]) -> list[Path]:
    """The case files of ids, case files and folders, each once. Raises UsageError."""
    return list(dict.fromkeys(file for target in targets for file, _ in resolve_target(target)))


def is_function_test(path: Path) -> bool:
    """Whether pytest would run tests of a file that uses `shaderlab.glsl`; never raises."""
    if not _NAME.fullmatch(path.name):
        return False
    try:
        text = read_regular(path, MAX_BYTES)
    except OSError:
        return False
    return bool(_LOADS.search(text) and _TESTS.search(text))


def split_targets(targets: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Return the files with tests of GLSL functions that targets stand for, absolute, and the
    targets that stand for cases."""
    tests: dict[Path, None] = {}
    cases = []
    for target in targets:
        path = Path(os.path.abspath(target))
        if path.is_dir():
            own = list(filter(is_function_test, files_below(path)))
            has_cases = not own or any(case_files(path))
        else:
            own = [path] if is_function_test(path) and not is_case_file(path) else []
            has_cases = not own
        tests |= dict.fromkeys(own)
        if has_cases:
            cases.append(target)
    return list(tests), cases


def resolve_target(target: str) -> list[tuple[Path, str | None]]:
    """The case files that a word stands for, with the only variant; None for all variants."""
    path = Path(target)
    by_path = path.suffix == ".py" or "/" in target or "\\" in target or target in (".", "..")
    known = {} if by_path else {file.stem.replace("_", "-"): file for file in shipped_cases()}
    if by_path or (target not in known and path.is_dir()):
        if path.is_dir():
            files: list[tuple[Path, str | None]] = [
                (file, None) for file in case_files(path, _report_skipped)
            ]
            if not files:
                remedy = "a case file takes Case from shaderlab and says case = Case(…)"
                if split_targets([target])[0]:
                    remedy = f"it has tests of functions: pytest {target}"
                raise UsageError("there is no case file in this folder", file=target, remedy=remedy)
            return files
        if not path.is_file():
            beside = [str(p) for p in path.parent.glob("*.py") if p.is_file()]
            what = "this is no regular file" if path.exists() else "there is no such file"
            raise UsageError(what, file=target, remedy=suggest(target, beside))
        return [(path, None)]
    found = _WITH_VARIANT.fullmatch(target)
    case_id, variant = (found["id"], found["variant"]) if found else (target, None)
    if case_id not in known:
        if path.is_file():
            refuse_other_languages(path)
            remedy = "compile, explain, audit and diff take shaders; a case file ends in .py"
            raise UsageError("this is no case file", file=path, remedy=remedy)
        own = [str(p) for p in Path().glob("[!.]*") if p.is_dir() or p.suffix == ".py"]
        raise UsageError(
            f"there is no case {case_id!r}, and no such folder",
            remedy=suggest(case_id, [*own, *known]),
        )
    return [(known[case_id], variant)]


def select_variants(case: CaseInfo, variant: str | None) -> list[Job]:
    """The jobs of a case, or of one of its variants. Raises UsageError."""
    if case.error is not None:
        status, trouble = case.status, _format_error(case.error)
        return [Job(file=case.file, id=case.id, variant="default", broken=status, trouble=trouble)]
    if variant is not None and variant not in case.variants:
        raise UsageError(
            f"{case.id} has no variant {variant!r}", remedy=suggest(variant, case.variants)
        )
    return [job for job in make_jobs(case) if variant in (None, job.variant)]


def _format_error(error: CaseError) -> str:
    place = f"line {error.line}: " if error.line else ""
    return f"{place}{error.message}" + (f"\n→ {error.remedy}" if error.remedy else "")


def _keep_variants(jobs: list[Job], variants: Sequence[str]) -> list[Job]:
    names = list(dict.fromkeys(job.variant for job in jobs if not job.broken))
    for variant in variants:
        if variant not in names:
            raise UsageError(
                f"no case among these has a variant {variant!r}", remedy=suggest(variant, names)
            )
    return [job for job in jobs if not variants or job.broken or job.variant in variants]


def make_ids_distinct(cases: Sequence[CaseInfo]) -> list[CaseInfo]:
    """The cases with ids that differ, since records and pictures are keyed by them: files of one
    name get as many folders before it as tell them apart, as in "lamps/fog". Raises UsageError: two
    files of one folder have the same id."""
    files = [Path(os.path.realpath(case.file)) for case in cases]  # also of links in a circle
    ids = {file: case.id for file, case in zip(files, cases, strict=True)}
    parts = {file: [*file.parts[1:-1], case_id] for file, case_id in ids.items()}
    length = 1
    while taken := [word for word, count in Counter(ids.values()).items() if count > 1]:
        length += 1
        if length > max(map(len, parts.values())):
            raise UsageError(
                f"two cases of one folder have the id {taken[0]!r}",
                remedy="rename one of the files",
            )
        ids |= {f: "/".join(parts[f][-length:]) for f, case_id in ids.items() if case_id in taken}
    return [replace(case, id=ids[file]) for file, case in zip(files, cases, strict=True)]


def _report_skipped(file: Path, reason: str) -> None:
    click.echo(f"shaderlab: not a case: {display_path(file)}: {reason}", err=True)


Replacements = Mapping[str, Path]


def replace_shaders(
    options: RunOptions, shaders: Sequence[str], renames: Sequence[str], jobs: Iterable[Job]
) -> RunOptions:
    """Return the options with the files of `--shader` and the names of `--rename`. Raises
    UsageError: a word is malformed, no shader has the name, or the file doesn't fit."""
    if not shaders and not renames:
        return options
    files = parse_replacements(shaders)
    names = parse_renames(renames, list(files.values()))
    files = resolve_replacements(files, jobs, options.include)
    return replace(options, shaders=files, renames=names)


def parse_replacements(words: Sequence[str]) -> Replacements:
    """What stands on both sides of each NAME=FILE. Raises UsageError: it is not of that form, or
    there is no such file."""
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
    replacements: Replacements, jobs: Iterable[Job], include: Sequence[Path] = ()
) -> Replacements:
    """Each name as the jobs' cases know it: its whole path, or the end of one, if only one ends so.
    Raises UsageError: there is no shader of that name, or more than one."""
    if not replacements:
        return {}
    from shaderlab.engine.catalogue import shaders_of

    folders = dict.fromkeys(Path(job.file).parent for job in jobs)
    places = [shaders_of(folder, {}, include) for folder in folders]
    known = sorted({name for shaders in places for name in shaders.names()})
    return {
        name if any(shaders.has(name) for shaders in places) else _complete_name(name, known): file
        for name, file in replacements.items()
    }


def find_unused(replacements: Replacements, records: Sequence[Record]) -> list[UsageError]:
    """An error for each file that no program was made of, so that nothing was said about it.

    Records of cases that did not get as far as their programs might have read it.
    """
    if not replacements or not all(record.programs for record in records):
        return []
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


_DECLARED = re.compile(
    r"\b(?:in|out|uniform|varying|attribute)\b[^;{}()]*?(\w+)\s*(?:\[\w*\]\s*)?;"
)


def parse_renames(words: Sequence[str], files: Sequence[Path]) -> dict[str, str]:
    """What each OLD=NEW says: a name in one of the files, and what the case calls it. Raises
    UsageError: it is not of that form, no file has the old name, or one has the new one too."""
    from shaderlab.compiler.shader_files import read_shader, strip_comments

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
