"""The results of `shaderlab mutate` for the page, read from the run's folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shaderlab.errors import ShaderlabError
from shaderlab.files import read_regular

FILE_NAME = "mutation.json"


@dataclass(frozen=True)
class Survivor:
    """A mistake that no expectation noticed, in a program or (none) in a case's own state."""

    file: str
    line: int
    operator: str
    before: str
    after: str
    program: str = ""

    @property
    def place(self) -> str:
        """`file:line`; the file alone of a mistake in the case's own data."""
        return f"{self.file}:{self.line}" if self.line else self.file


@dataclass(frozen=True)
class Mutants:
    """How many mutants the checks of one or several cases killed, and those that survived."""

    killed: int
    survivors: tuple[Survivor, ...]
    cases: int = 1

    @property
    def judged(self) -> int:
        """How many mutants changed an output."""
        return self.killed + len(self.survivors)

    @property
    def score(self) -> float:
        """The share that was noticed, 0…1; 1 of none."""
        return self.killed / self.judged if self.judged else 1.0


def load(folder: Path) -> dict[str, Mutants]:
    """The results in `folder`/mutation.json by case; none where there is no such file.

    Raises:
        ShaderlabError: the file is damaged, or something else.
    """
    path = folder / FILE_NAME
    try:
        cases = json.loads(read_regular(path))["cases"]
        return {case["id"]: _mutants(case) for case in cases}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ShaderlabError(
            f"these are no results of shaderlab mutate ({type(error).__name__}: {error})",
            file=path,
            remedy="delete the file, or run shaderlab mutate --report again",
        ) from error


def combined(results: Iterable[Mutants]) -> Mutants | None:
    """All results as one; None if there are none."""
    judged = [each for each in results if each.judged]
    if not judged:
        return None
    survivors = tuple(survivor for each in judged for survivor in each.survivors)
    return Mutants(sum(each.killed for each in judged), survivors, len(judged))


def merged(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """The contents of two files as one; `new` results replace those of the same case."""
    cases = {case["id"]: case for each in (old, new) for case in each["cases"]}
    return {"cases": list(cases.values())}


def _mutants(case: Mapping[str, Any]) -> Mutants:
    fields = ("file", "line", "operator", "before", "after")
    survivors = tuple(
        Survivor(**{n: each[n] for n in fields}, program=" + ".join(each.get("program", ())))
        for each in case["survived"]
    )
    return Mutants(int(case["killed"]), survivors)
