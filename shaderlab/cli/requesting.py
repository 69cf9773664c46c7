"""The options of `shaderlab run` and `sweep`, and who is to do what they ask.

Little is imported here: workers get ready while the command imports the rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from shaderlab.cli.files import REPORTS
from shaderlab.errors import UsageError
from shaderlab.running import Crew, Limits, Solo, Team
from shaderlab.running.jobs import known


@dataclass(frozen=True, kw_only=True)
class Request:
    """The options of `shaderlab run`, as click gives them."""

    targets: tuple[str, ...] = ()
    every: bool = False
    variants: tuple[str, ...] = ()
    size: int = 64
    shaders: tuple[str, ...] = ()
    outputs: Mapping[str, str] = field(default_factory=dict)
    folder: str | None = None
    seconds: float
    gigabytes: float
    workers: int | None
    driver: str | None = None
    drivers: str | None = None
    resume: str | None = None
    pictures: bool = True
    profile: bool = False
    scheduler: str | None = None

    def team(self) -> Team:
        """Whoever is to run the jobs."""
        driver = self.driver if self.driver is None else known(self.driver)
        if self.resume is not None:
            from shaderlab.running.journal import read

            driver = read(place_of(self.resume))[0].setup.driver
        elif self.drivers is not None:
            driver = self.rivals()[0]
        return self.on(driver)

    def on(self, driver: str | None) -> Team:
        """A team on one driver."""
        limits = Limits(seconds=self.seconds, gigabytes=self.gigabytes)
        if self.scheduler is not None:
            from shaderlab.running.cluster import Cluster

            if self.workers == 0:
                raise UsageError("--scheduler does not go with -j 0")
            return Cluster(self.scheduler, driver, limits)
        if self.workers == 0:
            return Solo(driver)
        return Crew(driver, limits, self.workers)

    def rivals(self) -> tuple[str, ...]:
        """The drivers to be compared; none if there is only one. Raises UsageError."""
        if self.drivers is None:
            return ()
        if self.driver is not None or self.resume is not None or self.workers == 0:
            raise UsageError("--drivers goes with neither --driver, --resume nor -j 0")
        names = tuple(known(name.strip()) for name in self.drivers.split(","))
        if len(set(names)) != len(names) or len(names) < 2:
            raise UsageError(f"--drivers {self.drivers}: name two or more, each once")
        return names


def place_of(resume: str) -> Path:
    """The folder to go on with: the one that is named, or the last that was begun."""
    if resume:
        return Path(resume)
    from shaderlab.running.journal import FILE_NAME

    begun = sorted(REPORTS.glob(f"*/{FILE_NAME}"), key=lambda path: path.stat().st_mtime)
    if not begun:
        raise UsageError(f"there is no run in {REPORTS}/", remedy="name its folder")
    return begun[-1].parent
