"""Choosing cases and variants by what was typed.

Case files are found by name and read, never imported here: executors load them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from shaderlab.discovery import case_files, place, shipped_cases
from shaderlab.errors import CaseError, UsageError, nearest
from shaderlab.execution.jobs import CaseFacts, Job, jobs_of

Load = Callable[[Sequence[Path]], list[CaseFacts]]
_WITH_VARIANT = re.compile(r"(?P<id>[^\[\]]+)\[(?P<variant>.*)\]")


@dataclass(frozen=True)
class _Wanted:
    """Case files that one word stands for; `variant` is None for all variants."""

    files: tuple[Path, ...]
    variant: str | None = None
    in_order_of_notes: bool = False


def choose(targets: Sequence[str], every: bool, variants: Sequence[str], load: Load) -> list[Job]:
    """The jobs of all `targets` (ids, ids with a variant, case files, folders), in order.

    Args:
        targets: as typed.
        every: whether all shipped cases come before them.
        variants: the names of the only variants to keep; all of them if empty.
        load: tells what is in case files.

    Raises:
        UsageError: nothing is named, or something that does not exist.
        CaseError: all case files are wrong. One that is wrong among others is a job that says so.
    """
    if not targets and not every:
        raise UsageError("nothing to run", remedy="name cases or case files, or say --all")
    wanted = [_Wanted(_shipped(), None, True)] if every else []
    wanted += [_wanted(target) for target in targets]
    files = list(dict.fromkeys(file for one in wanted for file in one.files))
    facts = dict(zip(files, load(files), strict=True))
    _refuse_duplicate_ids(list(facts.values()))
    jobs: dict[tuple[str, str], Job] = {}
    for one in wanted:
        found = [facts[file] for file in one.files]
        if one.in_order_of_notes:
            found.sort(key=lambda case: place(case.section, case.id))
        for case in found:
            jobs |= {job.key: job for job in _jobs(case, one.variant) if job.key not in jobs}
    errors = [case.error for case in facts.values() if case.error is not None]
    if errors and all(job.broken for job in jobs.values()):
        raise errors[0]
    return _keep_variants(list(jobs.values()), variants)


def one(target: str, load: Load) -> tuple[CaseFacts, str]:
    """The single case that `target` names, and its variant; the first where none is named.

    Raises:
        UsageError: there is no such case or variant, or it stands for several cases.
        CaseError: the case file is wrong.
    """
    wanted = _wanted(target)
    if len(wanted.files) != 1:
        raise UsageError(f"{target}: {len(wanted.files)} cases; name one of them")
    (facts,) = load(wanted.files)
    if facts.error is not None:
        raise facts.error
    return facts, _jobs(facts, wanted.variant)[0].variant


def files_of(targets: Sequence[str]) -> list[Path]:
    """The case files of ids, case files and folders, each once. Raises UsageError."""
    return list(dict.fromkeys(file for target in targets for file in _wanted(target).files))


def _shipped() -> tuple[Path, ...]:
    return tuple(shipped_cases())


def _wanted(target: str) -> _Wanted:
    path = Path(target)
    if path.is_dir() and _is_path(target, path):
        files = tuple(case_files(path))
        if not files:
            raise UsageError(
                "there is no case file in this folder",
                file=target,
                remedy="a case file takes Case from shaderlab and says case = Case(…)",
            )
        return _Wanted(files)
    if _is_path(target, path):
        return _Wanted((_existing(path, target),))
    found = _WITH_VARIANT.fullmatch(target)
    if found:
        return _Wanted((_file_of(found["id"]),), found["variant"])
    return _Wanted((_file_of(target),))


def _is_path(target: str, path: Path) -> bool:
    return path.suffix == ".py" or "/" in target or "\\" in target or target in (".", "..")


def _existing(path: Path, target: str) -> Path:
    if not path.exists():
        beside = [str(p) for p in path.parent.glob("*.py")] if path.parent.is_dir() else []
        raise UsageError("there is no such file", file=target, remedy=nearest(target, beside))
    return path


def _file_of(case_id: str) -> Path:
    """The shipped case file of this id, which is its name."""
    known = {file.stem.replace("_", "-"): file for file in _shipped()}
    if case_id not in known:
        raise UsageError(f"there is no case {case_id!r}", remedy=nearest(case_id, known))
    return known[case_id]


def _jobs(case: CaseFacts, variant: str | None) -> list[Job]:
    if case.error is not None:
        status, trouble = case.status, _said(case.error)
        return [Job(file=case.file, id=case.id, variant="default", broken=status, trouble=trouble)]
    if variant is not None and variant not in case.variants:
        raise UsageError(
            f"{case.id} has no variant {variant!r}", remedy=nearest(variant, case.variants)
        )
    return [job for job in jobs_of(case) if variant in (None, job.variant)]


def _said(error: CaseError) -> str:
    place = f"line {error.line}: " if error.line else ""
    return f"{place}{error.message}" + (f"\n→ {error.remedy}" if error.remedy else "")


def _keep_variants(jobs: list[Job], variants: Sequence[str]) -> list[Job]:
    names = list(dict.fromkeys(job.variant for job in jobs if not job.broken))
    for variant in variants:
        if variant not in names:
            raise UsageError(
                f"no case among these has a variant {variant!r}", remedy=nearest(variant, names)
            )
    return [job for job in jobs if not variants or job.broken or job.variant in variants]


def _refuse_duplicate_ids(cases: Sequence[CaseFacts]) -> None:
    """Outcomes, pictures and JSON are keyed by id, so two files of one name can't run together."""
    files: dict[str, str] = {}
    for case in cases:
        other = files.setdefault(case.id, case.file)
        if Path(other).resolve() != Path(case.file).resolve():
            raise UsageError(
                f"the id {case.id!r} is also that of {other}",
                file=case.file,
                remedy="rename one file, or run them one after the other",
            )
