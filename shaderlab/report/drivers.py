"""Several drivers side by side: each scene's verdict and distance on each of them."""

from __future__ import annotations

from dataclasses import dataclass

from shaderlab.records import DriverResult, Run


@dataclass(frozen=True)
class DriverRow:
    """One scene; `results` are in the order of the drivers, None where one did not run it."""

    id: str
    variant: str
    anchor: str | None
    results: tuple[DriverResult | None, ...]

    @property
    def agrees(self) -> bool:
        """Whether all verdicts are the same."""
        return len({result and result.status for result in self.results}) == 1


@dataclass(frozen=True)
class DriverTable:
    """`drivers` are (name, renderer); scenes with differing verdicts come first."""

    drivers: tuple[tuple[str, str], ...]
    rows: tuple[DriverRow, ...]

    @property
    def disputed(self) -> int:
        """How many scenes have not the same verdict everywhere."""
        return sum(not row.agrees for row in self.rows)


def driver_table(run: Run, anchors: dict[tuple[str, str], str]) -> DriverTable | None:
    """The table, or None for a single driver."""
    names = {result.driver: result.renderer for result in run.drivers}
    if len(names) < 2:
        return None
    by_scene: dict[tuple[str, str], dict[str, DriverResult]] = {}
    for result in run.drivers:
        by_scene.setdefault((result.id, result.variant), {})[result.driver] = result
    rows = [
        DriverRow(*scene, anchors.get(scene), tuple(results.get(name) for name in names))
        for scene, results in by_scene.items()
    ]
    return DriverTable(tuple(names.items()), tuple(sorted(rows, key=lambda row: row.agrees)))
