"""`pytest my_cases/`: each variant of each case file is an item; a failure shows what `run` does.

Only files that take `Case` from shaderlab and assign `case = Case(...)` are touched. They are
imported and run by one worker process, started when it is first needed: a case that crashes or
hangs is a failed test, or a file that can't be collected, and the session goes on. Under
pytest-xdist each of its processes has a worker.

`shaderlab_timeout` (seconds) and `shaderlab_memory` (gigabytes) in pytest's configuration are the
limits of one variant. With SHADERLAB_JOBS=0 everything runs in pytest's own process, for debuggers.
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
    from shaderlab.records import Record
    from shaderlab.running import Job, Team

_TEAM: pytest.StashKey[Team] = pytest.StashKey()


class CaseFailure(Exception):
    """A scene did not pass; carries its record."""

    def __init__(self, record: Record) -> None:
        super().__init__(f"{label(record.id, record.variant)}: {record.status}")
        self.record = record


class CaseFile(pytest.File):
    """A case file; collecting it has the worker import it, which touches no device."""

    def collect(self) -> Iterator[CaseItem]:
        from shaderlab.running import Job

        (facts,) = team_of(self.config).load([self.path])
        if facts.error is not None:
            raise facts.error
        for variant in facts.variants:
            job = Job(
                file=facts.file,
                id=facts.id,
                variant=variant,
                title=facts.title,
                section=facts.section,
            )
            item: CaseItem = CaseItem.from_parent(self, name=label(facts.id, variant), job=job)
            yield item

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """A wrong case file is shown as one message, not as a traceback."""
        if isinstance(excinfo.value, ShaderlabError):
            return str(excinfo.value)
        return super().repr_failure(excinfo)


class CaseItem(pytest.Item):
    """One variant of a case."""

    def __init__(self, *, job: Job, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.job = job

    def runtest(self) -> None:
        from shaderlab.running import Setup

        team = team_of(self.config)
        (record,) = team.run([self.job], Setup(pictures=False), lambda job, record: None)
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


def team_of(config: pytest.Config) -> Team:
    """Whoever runs this process's cases, there from the first use on."""
    team = config.stash.get(_TEAM, None)
    if team is None:
        from shaderlab.running import Crew, Limits, Solo

        if os.environ.get("SHADERLAB_JOBS") == "0":
            team = Solo()
        else:
            limits = Limits(
                seconds=_number(config, "shaderlab_timeout"),
                gigabytes=_number(config, "shaderlab_memory"),
            )
            team = Crew(limits=limits, early=False)
        config.stash[_TEAM] = team
    return team


def pytest_addoption(parser: pytest.Parser) -> None:
    """Settings for pytest's configuration file, or for -o on its command line."""
    parser.addini("shaderlab_timeout", "seconds that one variant of a case may take", default="30")
    parser.addini("shaderlab_memory", "gigabytes that it may have; 0 for any amount", default="4")


def _number(config: pytest.Config, name: str) -> float:
    try:
        value = float(config.getini(name))
    except ValueError:
        value = -1.0
    if not (value > 0.0 or (value == 0.0 and name == "shaderlab_memory")):
        raise pytest.UsageError(f"{name} is {config.getini(name)!r}: give it a positive number")
    return value


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> CaseFile | None:
    """Collect case files, and nothing else."""
    if not is_case_file(file_path):
        return None
    found: CaseFile = CaseFile.from_parent(parent, path=file_path)
    return found


def pytest_unconfigure(config: pytest.Config) -> None:
    """End the worker."""
    team = config.stash.get(_TEAM, None)
    if team is not None:
        team.close()
        del config.stash[_TEAM]
