"""From what was typed after `shaderlab run` to the scenes that are meant."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from shaderlab.catalogue import Catalogue, load_case
from shaderlab.discovery import case_files
from shaderlab.errors import UsageError, nearest
from shaderlab.model import Case, Scene

_WITH_VARIANT = re.compile(r"(?P<id>[^\[\]]+)\[(?P<variant>.*)\]")


def select(targets: Sequence[str], every: bool, variants: Sequence[str]) -> list[Scene]:
    """The scenes of all `targets` (ids, ids with a variant, case files, folders), in order.

    `every` adds the whole shipped catalogue; `variants`, if any, keeps only those of that name.

    Raises:
        UsageError: nothing is asked for, or something that is not there.
        CaseError: a case file is wrong.
    """
    if not targets and not every:
        raise UsageError("nothing to run", remedy="name cases or case files, or say --all")
    scenes: list[Scene] = list(_shipped_scenes()) if every else []
    for target in targets:
        scenes += _scenes(target)
    distinct = {(s.case.file, s.case.id, s.variant): s for s in scenes}
    _refuse_duplicate_ids(list(distinct.values()))
    return _keep_variants(list(distinct.values()), variants)


def _shipped_scenes() -> list[Scene]:
    return [scene for case in Catalogue.shipped().cases for scene in case.scenes()]


def _scenes(target: str) -> list[Scene]:
    path = Path(target)
    if path.is_dir() and _is_path(target, path):
        files = list(case_files(path))
        if not files:
            raise UsageError(
                "there is no case file in this folder",
                file=target,
                remedy="a case file takes Case from shaderlab and says case = Case(…)",
            )
        return [scene for file in files for scene in load_case(file).scenes()]
    if _is_path(target, path):
        return list(_from_file(path, target).scenes())
    found = _WITH_VARIANT.fullmatch(target)
    if found:
        case = _find(found["id"])
        return [scene for scene in case.scenes() if _is_variant(case, scene, found["variant"])]
    return list(_find(target).scenes())


def _is_path(target: str, path: Path) -> bool:
    return path.suffix == ".py" or "/" in target or "\\" in target or target in (".", "..")


def _from_file(path: Path, target: str) -> Case:
    if not path.exists():
        beside = [str(p) for p in path.parent.glob("*.py")] if path.parent.is_dir() else []
        raise UsageError("there is no such file", file=target, remedy=nearest(target, beside))
    return load_case(path)


def _find(case_id: str) -> Case:
    catalogue = Catalogue.shipped()
    known = [case.id for case in catalogue.cases]
    if case_id not in known:
        raise UsageError(f"there is no case {case_id!r}", remedy=nearest(case_id, known))
    return catalogue.find(case_id)


def _is_variant(case: Case, scene: Scene, variant: str) -> bool:
    if variant == scene.variant:
        return True
    names = [other.variant for other in case.scenes()]
    if variant not in names:
        raise UsageError(f"{case.id} has no variant {variant!r}", remedy=nearest(variant, names))
    return False


def _keep_variants(scenes: list[Scene], variants: Sequence[str]) -> list[Scene]:
    names = list(dict.fromkeys(scene.variant for scene in scenes))
    for variant in variants:
        if variant not in names:
            raise UsageError(
                f"no case among these has a variant {variant!r}", remedy=nearest(variant, names)
            )
    return [s for s in scenes if not variants or s.variant in variants]


def _refuse_duplicate_ids(scenes: list[Scene]) -> None:
    """Outcomes, pictures and JSON are keyed by id, so two files of one name can't run together."""
    files: dict[str, str] = {}
    for scene in scenes:
        other = files.setdefault(scene.case.id, scene.case.file)
        if other != scene.case.file:
            raise UsageError(
                f"the id {scene.case.id!r} is also that of {other}",
                file=scene.case.file,
                remedy="rename one file, or run them one after the other",
            )
