"""`shaderlab explain`: what each line of a fragment shader computes at one pixel."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from shaderlab.analysis.answer import format_inputs
from shaderlab.cli import FAILED, OK, options as shared
from shaderlab.compiler.shader_files import is_library, is_shader
from shaderlab.engine.jobs import Call, Executor
from shaderlab.errors import UsageError, suggest
from shaderlab.model.options import Limits, RunOptions
from shaderlab.model.records import Explanation, Step

_MOST_INPUTS = 32  # that are shown; --json has all
_MOST = 3  # of the steps that lose most, in words


def _parse_pixel(context: click.Context, option: click.Parameter, text: str | None) -> object:
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2 or not all(part.strip().isdigit() for part in parts):
        raise click.BadParameter("write two numbers, column,row from the lower left, such as 10,20")
    return int(parts[0]), int(parts[1])


@dataclass(frozen=True, kw_only=True)
class ExplainArguments:
    """The arguments and options of `shaderlab explain`, as its help describes them."""

    target: str
    pixel: tuple[int, int] | None
    variant: str | None
    pass_name: str | None
    draw: int
    size: int
    ranges: dict[str, str]
    includes: tuple[Path, ...]
    driver: str | None
    limits: Limits
    workers: int
    json_file: str | None

    @property
    def is_shader(self) -> bool:
        """Whether a shader file was named, and not a case."""
        other = not self.target.endswith(".py") and Path(self.target).is_file()
        return other or is_shader(self.target)


@click.command("explain")
@click.argument("target", metavar="ID | ID[VARIANT] | FILE.py | SHADER")
@click.option(
    "--pixel",
    metavar="X,Y",
    callback=_parse_pixel,
    help="The pixel, counted from 0 at the lower left.  [default: where the band is widest]",
)
@click.option("--variant", metavar="NAME", help="The variant; by default the first.")
@click.option("--pass", "pass_name", metavar="NAME", help="The pass; by default the last.")
@click.option(
    "--draw",
    type=int,
    default=-1,
    help="The draw in that pass, counted from 0; by default the last.",
)
@click.option(
    "--size",
    type=click.IntRange(1, 4096),
    default=RunOptions.size,
    show_default=True,
    help="The side of the rendered frame in pixels.",
)
@shared.RANGES
@shared.INCLUDE
@shared.DRIVER
@shared.jobs_option("1")
@shared.limits_option("Stop after S seconds.")
@shared.JSON
@shared.collect(ExplainArguments, "arguments")
def command(arguments: ExplainArguments) -> int:
    """Show what each line of a case's fragment shader stores at one pixel: the driver's value, the
    float64 value, the band that the precision rules allow, and the precision that the line loses.

    The shader's SPIR-V is interpreted, and the driver renders it again with the value of each
    statement as an output. Where that is impossible (loop iterations between the fourth and the
    last; a shader whose other outputs would change), the value comes from float32 arithmetic and is
    marked. A shader file without a case gets generated inputs; the invocation with the widest band
    is shown.

    \b
    Examples:
      shaderlab explain spotlight
      shaderlab explain pbr --pixel 20,40 --json steps.json
      shaderlab explain my_case.py --variant "at noon" --pass shadow
      shaderlab explain lamp.frag --range distance=0.1:50

    Exit code: 0 shown, 1 the shader can't be interpreted or the driver is outside the shader's
    band, 2 wrong usage.
    """
    a = arguments
    with contextlib.closing(
        shared.make_executor(a.driver, a.limits, a.workers, files_only=a.is_shader)
    ) as executor:
        request = _make_request(arguments, executor)
        explained, inputs = shared.perform_one(executor, request)
    if arguments.json_file is not None:
        from shaderlab.model.store import to_plain

        own = {"inputs": {name: list(values) for name, values in inputs.items()}}
        shared.write_json({**to_plain(explained), **own}, arguments.json_file)
    if arguments.json_file != "-":
        x, y = explained.pixel
        pixel = "" if arguments.is_shader else f"pixel ({x}, {y}), counted from the lower left, "
        show(explained, f"{pixel}with {format_inputs(inputs, _MOST_INPUTS)}")
    return FAILED if any(s.by_driver and not s.inside for s in explained.steps) else OK


def _make_request(arguments: ExplainArguments, executor: Executor) -> Call:
    """Return the request for what was named. Raises UsageError, CaseError."""
    from shaderlab.cli.selecting import select_one

    if arguments.is_shader:
        if is_library(arguments.target):
            raise UsageError(
                "this file has no main to explain",
                file=arguments.target,
                remedy="name the shader that includes it; audit and diff take functions alone",
            )
        shader = shared.resolve_shader(Path(arguments.target), arguments.includes)
        return Call("shaderlab.analysis.steps:explain_file", (shader, arguments.ranges))
    if arguments.ranges:
        raise UsageError("--range can't be combined with a case, whose inputs are known")
    facts, variant = select_one(arguments.target, executor.load)
    if arguments.variant is not None:
        variant = arguments.variant
        if variant not in facts.variants:
            raise UsageError(
                f"{facts.id} has no variant {variant!r}", remedy=suggest(variant, facts.variants)
            )
    a = arguments
    options = RunOptions(size=a.size, driver=a.driver, include=a.includes, limits=a.limits)
    given = (Path(facts.file), variant, a.pass_name, a.draw, a.pixel, options)
    return Call("shaderlab.analysis.explain:explain_in_case", given)


def show(explained: Explanation, where: str) -> None:
    """Print where that is, the table, and where precision goes."""
    from shaderlab.cli.showing import Show, make_table
    from shaderlab.report.text import clean

    console = Show().console
    console.print(where)
    right = ("ulp off", "ulp wide", "lost here")
    left = ("line", "name", "value", "float64", "band")
    table = make_table(*left, *right, right=right, whole=left)
    for step in explained.steps:
        at = step.component
        table.add_row(
            clean(f"{Path(step.file).name}:{step.line}"),
            clean("  " * len(step.calls) + step.label),
            f"{step.value[at]:.9g}" + ("" if step.by_driver else " (float32)"),
            f"{step.exact[at]:.9g}",
            _format_band(step.low[at], step.high[at]),
            _format_number(step.off),
            _format_number(step.width),
            _format_number(step.lost),
            style=None if step.inside else "red",
        )
    console.print(table if explained.steps else "it stores nothing that is rounded")
    if explained.refused:
        console.print(f"values come from float32 arithmetic: {explained.refused}", style="yellow")
    for line in describe_losses(explained.steps):
        console.print(line)


def describe_losses(steps: Sequence[Step]) -> list[str]:
    """A line for each of the statements that lose most, and for one that the driver gets wrong."""
    from shaderlab.files import display_path

    wrong = [step for step in steps if step.by_driver and not step.inside]
    lines = [
        f"the driver is outside the shader's band at {display_path(s.file, s.line)}: {s.name}"
        for s in wrong[:1]
    ]
    losing = sorted((s for s in steps if s.lost > 1.0), key=lambda s: -s.lost)[:_MOST]
    for s in losing:
        place = display_path(s.file, s.line)
        lines.append(f"{_format_number(s.lost)} ULP lost at {place}: {s.name}")
    return lines


def _format_band(low: float, high: float) -> str:
    return f"{low:.9g}" if low == high else f"{low:.9g} … {high:.9g}"


def _format_number(number: float) -> str:
    return f"{number:.3g}"
