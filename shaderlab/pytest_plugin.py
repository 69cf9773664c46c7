"""`pytest my_cases/`: each variant of each case file is an item; a failure shows what `run` does.

Only files that take `Case` from shaderlab and assign `case = Case(...)` are touched. One lab is
opened a process, on the first item that needs it, so it works under pytest-xdist as well.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from shaderlab.discovery import is_case_file
from shaderlab.errors import ShaderlabError
from shaderlab.terminal import failed, failure, label

if TYPE_CHECKING:
    from shaderlab.model import Scene
    from shaderlab.pipeline import Lab
    from shaderlab.records import Record

_LAB: pytest.StashKey[Lab] = pytest.StashKey()


class CaseFailure(Exception):
    """A scene did not pass; carries its record."""

    def __init__(self, record: Record) -> None:
        super().__init__(f"{label(record.id, record.variant)}: {record.status}")
        self.record = record


class CaseFile(pytest.File):
    """A case file; collecting it imports it, which touches no device."""

    def collect(self) -> Iterator[CaseItem]:
        from shaderlab.catalogue import load_case

        case = load_case(self.path)
        for scene in case.scenes():
            item: CaseItem = CaseItem.from_parent(
                self, name=label(case.id, scene.variant), scene=scene
            )
            yield item

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """A wrong case file is shown as one message, not as a traceback."""
        if isinstance(excinfo.value, ShaderlabError):
            return str(excinfo.value)
        return super().repr_failure(excinfo)


class CaseItem(pytest.Item):
    """One variant of a case."""

    def __init__(self, *, scene: Scene, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.scene = scene

    def runtest(self) -> None:
        record = lab_of(self.config).run(self.scene)
        if record.status == "unsupported":
            pytest.skip(record.message or "this driver lacks what the case needs")
        if failed(record):
            raise CaseFailure(record)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        if isinstance(excinfo.value, CaseFailure):
            return "\n".join(failure(excinfo.value.record))
        if isinstance(excinfo.value, ShaderlabError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[os.PathLike[str], int | None, str]:
        return self.path, None, self.name


def lab_of(config: pytest.Config) -> Lab:
    """This process's lab, opened on first use."""
    lab = config.stash.get(_LAB, None)
    if lab is None:
        from shaderlab.pipeline import Lab

        lab = config.stash[_LAB] = Lab()
    return lab


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> CaseFile | None:
    """Collect case files, and nothing else."""
    if not is_case_file(file_path):
        return None
    found: CaseFile = CaseFile.from_parent(parent, path=file_path)
    return found


def pytest_unconfigure(config: pytest.Config) -> None:
    """Close the lab."""
    lab = config.stash.get(_LAB, None)
    if lab is not None:
        lab.close()
        del config.stash[_LAB]
