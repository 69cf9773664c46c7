"""Options that several commands share, and the executor that they describe."""

from __future__ import annotations

import dataclasses
import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from shaderlab.compiler.shader_files import EXTENSIONS
from shaderlab.engine.jobs import WORDS, check_driver
from shaderlab.errors import UsageError, suggest
from shaderlab.model.options import Limits

if TYPE_CHECKING:
    from shaderlab.analysis.requests import ShaderOfFile
    from shaderlab.engine.jobs import Executor, LocalExecutor


Command = TypeVar("Command", bound=Callable[..., Any])

INCLUDE = click.option(
    "--include",
    "-I",
    "includes",
    multiple=True,
    type=click.Path(path_type=Path, exists=True, file_okay=False, resolve_path=True),
    metavar="DIR",
    help='Also search DIR for shaders and for #include "…"; may be repeated.',
)
TARGET = click.option(
    "--target",
    "-t",
    "compile_targets",
    multiple=True,
    metavar="T",
    callback=lambda context, option, names: _check_targets(names),
    help="Compile for this target only (glsl, opengl, vulkan, vulkan-strict); may be repeated.",
)
JSON = click.option(
    "--json", "json_file", metavar="FILE", help="Write results as JSON; - writes to stdout."
)
SCHEDULER = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Run on the Dask cluster of this scheduler, such as tcp://host:8786, instead of -j.",
)
DRIVER = click.option(
    "--driver",
    metavar="NAME",
    callback=lambda context, option, name: name if name is None else check_driver(name),
    help="OpenGL: llvmpipe, softpipe, llvmpipe-spirv (loads SPIR-V modules) or default (the "
    "machine's own driver); Vulkan: lavapipe, swiftshader or vulkan (the machine's own); webgl2 "
    "for headless Chromium.  [default: llvmpipe]",
)


def _check_targets(names: tuple[str, ...]) -> tuple[str, ...]:
    if names:
        from shaderlab.compiler.engines import ALL_TARGETS

        for name in names:
            if name not in ALL_TARGETS:
                raise UsageError(f"there is no target {name!r}", remedy=suggest(name, ALL_TARGETS))
    return tuple(dict.fromkeys(names))


def report_option(help: str) -> Callable[[Command], Command]:
    """Add `--report DIR`, the folder of a run."""
    return click.option("--report", "folder", metavar="DIR", help=help)


def jobs_option(default: str = WORDS) -> Callable[[Command], Command]:
    """Add `--jobs N`, given as `workers`; None leaves the number to the lab."""
    return click.option(
        "-j",
        "--jobs",
        "workers",
        type=click.IntRange(min=0),
        default=int(default) if default.isdigit() else None,
        show_default=default,
        envvar="SHADERLAB_JOBS",
        metavar="N",
        help="Run in N worker processes; 0 runs in-process, without isolation or limits.",
    )


def collect(kind: type[Any], parameter: str) -> Callable[[Command], Command]:
    """Pass the options that are fields of a dataclass to a command as one value, `parameter`."""
    names = [field.name for field in dataclasses.fields(kind)]

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def collected(**values: Any) -> Any:
            value = kind(**{name: values.pop(name) for name in names})
            return command(**values, **{parameter: value})

        decorated: Any = collected
        return decorated  # type: ignore[no-any-return]

    return decorate


def limits_option(help: str, seconds: float = Limits.seconds) -> Callable[[Command], Command]:
    """Add `--timeout S` and `--memory GB`, given as `limits`."""
    timeout = click.option(
        "--timeout",
        "seconds",
        type=click.FloatRange(min=0.0, min_open=True),
        default=seconds,
        show_default=True,
        metavar="S",
        help=help,
    )
    memory = click.option(
        "--memory",
        "gigabytes",
        type=click.FloatRange(min=0.0),
        default=Limits.gigabytes,
        show_default=True,
        metavar="GB",
        help="Limit the memory of each worker; 0 sets no limit.",
    )
    return lambda command: timeout(memory(collect(Limits, "limits")(command)))


@dataclass(frozen=True, kw_only=True)
class RunningOptions:
    """How `run` and `sweep` run jobs, and where their report goes, as `running_options` adds."""

    includes: tuple[Path, ...]
    compile_targets: tuple[str, ...]
    driver: str | None
    scheduler: str | None
    workers: int | None
    limits: Limits
    folder: str | None


def running_options(what: str) -> Callable[[Command], Command]:
    """Add the options that `run` and `sweep` share, given as `running`.

    Args:
        what: the name of one job, for the help.
    """

    def decorate(command: Command) -> Command:
        command = collect(RunningOptions, "running")(command)
        for option in (
            INCLUDE,
            TARGET,
            DRIVER,
            SCHEDULER,
            jobs_option(),
            limits_option(f"Stop a {what} that takes longer than S seconds."),
            report_option("Write the report to DIR instead of a new folder in reports/."),
        ):
            command = option(command)
        return command

    return decorate


def make_executor(
    driver: str | None, limits: Limits, workers: int | None, scheduler: str | None = None
) -> Executor:
    """Return what runs the jobs of a command. Raises UsageError."""
    if scheduler is None:
        return make_local_executor(driver, limits, workers)
    if workers == 0:
        raise UsageError("--scheduler can't be combined with -j 0")
    from shaderlab.cli.cluster import DaskExecutor

    return DaskExecutor(scheduler, driver, limits)


def make_local_executor(
    driver: str | None, limits: Limits, workers: int | None, early: bool = True
) -> LocalExecutor:
    """Return an executor on this machine: in this process for 0 workers."""
    from shaderlab.engine.jobs import InProcessExecutor, ProcessExecutor

    if workers == 0:
        return InProcessExecutor(driver)
    return ProcessExecutor(driver, limits, workers, early=early)


def _parse_range(word: str) -> tuple[str, str]:
    name, equals, values = word.partition("=")
    if not equals:
        raise UsageError(f"--range {word}", remedy="write --range NAME=A:B or NAME=unit")
    return name.strip(), values.strip()


RANGES = click.option(
    "--range", "ranges", multiple=True, metavar="NAME=A:B",
    callback=lambda context, option, words: dict(map(_parse_range, words)),
    help="Take an input from A to B; NAME=unit makes it a unit vector. May be repeated.",
)  # fmt: skip


def resolve_shader(
    path: Path, includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> ShaderOfFile:
    """Return a shader file with the folders that it includes from.

    `then` maps paths to those of an earlier revision.

    Raises:
        UsageError: there is no such file, or it is a folder.
    """
    if path.is_dir():
        raise UsageError("this is a folder; name a shader file", file=path)
    (found,) = resolve_shaders([path], includes, then)
    return found


def has_functions_only(shader: ShaderOfFile, stage: str | None) -> bool:
    """Return whether a file only has functions for others to include: no stage, no `main`."""
    path = Path(shader.file.path)
    if stage is not None or path.suffix in EXTENSIONS or not path.is_file():
        return False
    text = path.read_text(encoding="utf-8", errors="replace")
    return not re.search(r"#pragma\s+shader_stage|\bvoid\s+main\s*\(", text)


def resolve_shaders(
    paths: Sequence[Path], includes: Sequence[Path], then: Callable[[Path], Path] | None = None
) -> list[ShaderOfFile]:
    """Return the shader files at these paths and in these folders, as `resolve_shader` does."""
    from shaderlab.analysis.requests import ShaderOfFile
    from shaderlab.compiler.shader_files import find_shaders
    from shaderlab.engine.catalogue import data_folder
    from shaderlab.engine.settings import load_settings

    shipped = data_folder("shaders").resolve()
    found = []
    for path in paths:
        folder = path if path.is_dir() else path.parent
        own = load_settings(folder).shader_folders(folder)
        folders = tuple(str(then(f) if then else f) for f in [*includes, *own, shipped])
        files = find_shaders([then(path) if then else path], [shipped])
        found += [ShaderOfFile(file, folders) for file in files]
    return found
