"""`shaderlab diff`: is a rewritten shader the same one?"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from shaderlab.cli import FAILED, OK, USAGE
from shaderlab.cli.files import write_json
from shaderlab.cli.options import INCLUDE, JSON, jobs_option, limits_option, make_local_executor
from shaderlab.compiler.text import STAGES
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.options import Limits

if TYPE_CHECKING:
    from shaderlab.equivalence.answer import Answer
    from shaderlab.equivalence.requests import ShaderOfFile

NO_ANSWER = USAGE
"""The exit status where it can't be said, for whatever reason."""


@click.command("diff", short_help="Is a rewritten shader the same one?")
@click.argument("old", type=click.Path(path_type=Path))
@click.argument("new", type=click.Path(path_type=Path), required=False)
@click.option(
    "--range", "ranges", multiple=True, metavar="NAME=A:B",
    help="An input lies between A and B; NAME=unit: it has length 1. May be repeated.",
)  # fmt: skip
@click.option("--strict", is_flag=True, help="Exit with 1 if only the accuracy changes, too.")
@click.option("--stage", type=click.Choice(STAGES), help="Of both files, whatever they are called.")
@click.option("--inputs", "show_inputs", is_flag=True, help="Print what each input was given.")
@INCLUDE
@limits_option("Give up after S seconds.", seconds=60.0)
@jobs_option("1")
@JSON
def command(
    old: Path,
    new: Path | None,
    ranges: tuple[str, ...],
    strict: bool,
    stage: str | None,
    show_inputs: bool,
    includes: tuple[Path, ...],
    limits: Limits,
    workers: int | None,
    json_file: str | None,
) -> int:
    """Whether the shader NEW computes what OLD does, without a driver: both are interpreted on
    the same inputs, which are made up by the inputs' names and types.

    Say what an input is where a guess won't do: --range distance=0:50, or a comment where it
    is declared, `uniform float distance; // range: 0..50` (or `// range: unit`).

    Exit code: 0 the same mathematics, 1 different, 2 it can't be said, or wrong usage.

    \b
    Examples:
      shaderlab diff lamp.frag lamp_fast.frag
      shaderlab diff old.vert new.vert --range scale=0.1:10 --strict
    """
    from shaderlab.equivalence.comparison import Plan
    from shaderlab.equivalence.requests import CompareFiles

    plan = Plan(ranges=dict(map(_range, ranges)))
    if new is None:
        raise UsageError("name two shaders: OLD and NEW")
    request = CompareFiles(_shader(old, includes), _shader(new, includes), stage, plan)
    try:
        answer = _answer(request, limits, workers)
    except UsageError:
        raise
    except ShaderlabError as error:
        click.echo(f"can't say: {error}", err=True)
        return NO_ANSWER
    for line in answer.lines():
        click.echo(line, err=json_file == "-")
    if show_inputs or answer.same is not True:
        _print_inputs(answer.inputs, err=json_file == "-")
    if json_file is not None:
        write_json(answer.data(), json_file)
    if answer.same is None:
        return NO_ANSWER
    return OK if answer.same and not (strict and not answer.same_numerics) else FAILED


def _range(word: str) -> tuple[str, str]:
    name, equals, values = word.partition("=")
    if not equals:
        raise UsageError(f"--range {word}", remedy="write --range NAME=A:B or NAME=unit")
    return name.strip(), values.strip()


def _shader(path: Path, includes: tuple[Path, ...]) -> ShaderOfFile:
    from shaderlab.compiler.shader_files import find_shaders
    from shaderlab.discovery import data_folder
    from shaderlab.equivalence.requests import ShaderOfFile
    from shaderlab.settings import settings_of

    if path.is_dir():
        raise UsageError("this is a folder: name a shader file", file=path)
    shipped = data_folder("shaders").resolve()
    (file,) = find_shaders([path], [shipped])
    own = settings_of(path.parent).shader_folders(path.parent)
    return ShaderOfFile(file, tuple(map(str, [*includes, *own, shipped])))


def _answer(request: object, limits: Limits, workers: int | None) -> Answer:
    """What a worker answers. Raises ShaderlabError where there is no answer."""
    with contextlib.closing(
        make_local_executor(None, limits, 1 if workers is None else workers, early=False)
    ) as executor:
        (result,) = executor.perform([request])
    if result.status == "done":
        answer: Answer = result.value
        return answer
    if isinstance(result.value, ShaderlabError):
        raise result.value
    message = str(result.value) if result.status == "error" else result.message
    raise ShaderlabError(f"{result.status} while {result.step or 'starting'}: {message}")


def _print_inputs(inputs: Mapping[str, str], err: bool) -> None:
    for name, role in inputs.items():
        click.echo(f"  {name}: {role}", err=err)
