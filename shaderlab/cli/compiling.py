"""`shaderlab compile`: ask the compilers about shader files, without running anything."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..errors import ShaderError, UsageError
from ..records import Diagnostic, Verdict
from .files import write_json


@dataclass(frozen=True)
class Shader:
    """A shader file to compile: where it is, and its name inside which root."""

    path: Path
    root: Path
    name: str


@dataclass(frozen=True)
class Result:
    """What every target said of one file."""

    path: Path
    verdicts: tuple[Verdict, ...]

    @property
    def ok(self) -> bool:
        return all(verdict.ok for verdict in self.verdicts)


@click.command("compile", short_help="Only ask the compilers.")
@click.argument("paths", nargs=-1, required=True, metavar="PATH…")
@click.option("--define", "-D", "defines", multiple=True, metavar="NAME[=VALUE]", help="A macro.")
@click.option(
    "--include",
    "-I",
    "includes",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="DIR",
    help='Another folder in which #include "…" looks.',
)
@click.option("--json", "json_file", metavar="FILE", help="Write verdicts as JSON; - for stdout.")
def command(
    paths: tuple[str, ...],
    defines: tuple[str, ...],
    includes: tuple[Path, ...],
    json_file: str | None,
) -> None:
    """Compile shader files, or all those in folders, as plain GLSL, as OpenGL SPIR-V and as
    Vulkan SPIR-V, and validate the SPIR-V.

    Each file is a program of its own here. Messages have the form that editors jump from.

    \b
    Examples:
      shaderlab compile lamp.frag
      shaderlab compile my_shaders/ --define LIGHTS=4 --include common/
    """
    for folder in includes:
        if not folder.is_dir():
            raise UsageError("there is no such folder", file=folder)
    macros = dict(_macro(word) for word in defines)
    shaders = list({s.path: s for path in paths for s in find_shaders(Path(path))}.values())
    results = [check(shader, includes, macros) for shader in shaders]
    to_stderr = json_file == "-"
    for result in results:
        for line in messages(result):
            click.echo(line, err=to_stderr)
    for line in summary(results):
        click.echo(line, err=to_stderr)
    if json_file is not None:
        write_json([_as_data(result) for result in results], json_file)
    if not all(result.ok for result in results):
        raise SystemExit(1)


def find_shaders(path: Path) -> Iterator[Shader]:
    """The shader file `path`, or all below the folder `path` that say which stage they are.

    Raises:
        UsageError: there is nothing of that name, or no shader in the folder.
    """
    from ..catalogue import data_folder
    from ..glsl.sources import Shaders, stage_of

    shipped = data_folder("shaders").resolve()
    if not path.exists():
        raise UsageError("there is no such file or folder", file=path)
    folder = path if path.is_dir() else path.parent
    inside = folder.resolve().is_relative_to(shipped)
    root = shipped if inside else folder
    if not path.is_dir():
        name = path.resolve().relative_to(shipped).as_posix() if inside else path.name
        yield Shader(path, root, name)
        return
    found = False
    for below in Shaders([path]).names():
        file = path / below
        try:
            stage_of(below, file.read_text(encoding="utf-8", errors="replace"))
        except (ShaderError, OSError):
            continue  # a file to be included
        found = True
        name = file.resolve().relative_to(shipped).as_posix() if inside else below
        yield Shader(file, root, name)
    if not found:
        raise UsageError("there is no shader in this folder", file=path)


def check(shader: Shader, includes: Sequence[Path], defines: Mapping[str, str]) -> Result:
    """Compile one file; one that can't even be read is refused by every target."""
    from ..catalogue import data_folder
    from ..glsl.compile import TARGETS, compile_program
    from ..glsl.sources import Shaders

    roots = list(dict.fromkeys([shader.root, *includes, data_folder("shaders")]))
    try:
        source = Shaders(roots, defines=defines).load(shader.name)
        return Result(shader.path, compile_program([source], TARGETS).verdicts)
    except ShaderError as error:
        said = Diagnostic(
            file=error.file or str(shader.path),
            line=error.line,
            severity="error",
            message=error.message + (f" ({error.remedy})" if error.remedy else ""),
        )
        refused = tuple(Verdict(target=t, ok=False, diagnostics=(said,)) for t in TARGETS)
        return Result(shader.path, refused)


def messages(result: Result) -> Iterator[str]:
    """Each message once, with the targets that say it where not all do."""
    from ..terminal import diagnostic_line

    said: dict[str, list[str]] = {}
    for verdict in result.verdicts:
        for diagnostic in dict.fromkeys(verdict.diagnostics):
            said.setdefault(diagnostic_line(diagnostic), []).append(verdict.target)
    for line, targets in said.items():
        few = len(targets) < len(result.verdicts)
        yield f"{line} [{', '.join(targets)}]" if few else line


def summary(results: Sequence[Result]) -> Iterator[str]:
    """A table: for each target, how many files it accepts and how many it refuses."""
    yield f"{'target':<10}{'accepted':>10}{'refused':>10}"
    for verdicts in zip(*(result.verdicts for result in results), strict=True):
        good = sum(verdict.ok for verdict in verdicts)
        yield f"{verdicts[0].target:<10}{good:>10}{len(verdicts) - good:>10}"


def _macro(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    return name, value if equals else "1"


def _as_data(result: Result) -> dict[str, Any]:
    return {
        "file": str(result.path),
        "ok": result.ok,
        "targets": {
            verdict.target: {
                "ok": verdict.ok,
                "spirv_bytes": verdict.spirv_bytes,
                "diagnostics": [
                    {"file": d.file, "line": d.line, "severity": d.severity, "message": d.message}
                    for d in verdict.diagnostics
                ],
            }
            for verdict in result.verdicts
        },
    }
