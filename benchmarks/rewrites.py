"""How many right rewrites of the catalogue's shaders are rejected, and how many wrong ones pass.

    python -m benchmarks.rewrites [--driver softpipe] [--only right|wrong]

`rewrites.toml` has the rewrites: each replaces one piece of one shipped shader or library file, and
is judged by one case. A right one that fails is a false alarm, a wrong one that passes a miss.
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.shipped import load_cases
from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Case
from shaderlab.model.options import RunOptions


@dataclass(frozen=True)
class Rewrite:
    """A piece of a shader, and what is written in its place."""

    file: str
    case: str
    old: str
    new: str

    def text(self) -> str:
        """The file with the piece replaced. Raises ValueError unless it is there."""
        before = (data_folder("shaders") / self.file).read_text(encoding="utf-8")
        if self.old not in before:
            raise ValueError(f"{self.file} does not have {self.old!r}")
        return before.replace(self.old, self.new)

    def __str__(self) -> str:
        old, new = (" ".join(part.split()) for part in (self.old, self.new))
        return f"{self.case}, {self.file}: {old} → {new}"


def rewrites(kind: str) -> list[Rewrite]:
    """The "right" or the "wrong" ones."""
    data = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
    return [Rewrite(*row) for row in data[kind]]


def noticed(lab: SceneRunner, case: Case, rewrite: Rewrite) -> str:
    """What fails with the rewritten shader, or "". Raises ValueError where the case has no such
    shader."""
    used: set[str] = set()
    lab.configure(RunOptions(texts={rewrite.file: rewrite.text()}, driver=lab.options.driver))
    for scene in case.scenes():
        record = lab.run(scene)
        used.update(file for program in record.programs for file in program.files)
        if record.status != "pass":
            failing = [o.name for o in record.expectations if o.status != "pass"]
            return f"{scene.variant}: {', '.join(failing) or record.message}"
    if not any(file.endswith(rewrite.file) for file in used):
        raise ValueError(f"{rewrite.case} does not use {rewrite.file}")
    return ""


def surprises(lab: SceneRunner, kind: str) -> Iterator[tuple[Rewrite, str]]:
    """Right rewrites that fail, with what fails, or wrong ones that do not."""
    cases = load_cases()
    for rewrite in rewrites(kind):
        found = noticed(lab, cases[rewrite.case], rewrite)
        if bool(found) == (kind == "right"):
            yield rewrite, found


def main() -> None:
    """Judge, and print what is surprising."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--driver")
    parser.add_argument("--only", choices=("right", "wrong"))
    options = parser.parse_args()
    with SceneRunner(RunOptions(driver=options.driver)) as lab:
        for kind in ("right", "wrong") if options.only is None else (options.only,):
            count = 0
            for rewrite, found in surprises(lab, kind):
                count += 1
                print(f"  {rewrite}{f'  [{found}]' if found else ''}", flush=True)
            verb = "rejected" if kind == "right" else "unnoticed"
            print(f"{count} of {len(rewrites(kind))} {kind} ones {verb}", flush=True)


if __name__ == "__main__":
    main()
