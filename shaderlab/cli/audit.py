"""`shaderlab audit`: what may go wrong in a shader, without a reference."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from shaderlab.analysis.answer import gather_elements
from shaderlab.analysis.hazards import Audit, Plan
from shaderlab.analysis.requests import AuditCase, AuditFile
from shaderlab.cli import FAILED, USAGE, options as shared
from shaderlab.compiler.shader_files import EXTENSIONS, is_library
from shaderlab.engine.jobs import Call, describe_failure
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model.options import Limits, RunOptions

if TYPE_CHECKING:
    from shaderlab.report.findings import Finding


@click.command("audit")
@click.argument("targets", nargs=-1, required=True, metavar="FILE | FOLDER | ID | CASE.py…")
@shared.RANGES
@click.option(
    "--possible", is_flag=True, help="Also print possible hazards for which no input was found."
)
@click.option(
    "--precision",
    is_flag=True,
    help="Show how far conforming devices may differ at each output, at highp and mediump.",
)
@click.option(
    "--prove",
    is_flag=True,
    help="Prove for each hazard that no input in the ranges causes it, or find one that does.",
)
@click.option(
    "--assume",
    multiple=True,
    metavar="'A > B'",
    help="A condition in GLSL that the inputs meet; repeatable.",
)
@click.option("--inputs", "show_inputs", is_flag=True, help="Print the values of each input.")
@shared.stage_option("The stage of all files, whatever their names.")
@shared.INCLUDE
@shared.DRIVER
@shared.limits_option("Stop a shader that takes longer than S seconds.", seconds=60.0)
@shared.jobs_option("1")
@shared.JSON
@shared.finding_options
def command(
    targets: tuple[str, ...], ranges: dict[str, str], possible: bool, precision: bool, prove: bool,
    assume: tuple[str, ...], show_inputs: bool, stage: str | None, includes: tuple[Path, ...],
    driver: str | None, limits: Limits, workers: int, json_file: str | None,
    outputs: Mapping[str, str],
) -> int:  # fmt: skip
    """Search for inputs at which a shader divides by 0, takes the square root of a negative number,
    reads an uninitialised value, or does anything else that GLSL leaves undefined, and for outputs
    that depend on it. No formula is needed.

    A case provides the inputs of its draws. The inputs of a shader file are generated from names
    and types; state a range where a guess is not enough: --range distance=0:50, or a comment at the
    declaration, `uniform float distance; // range: 0..50`. In a file without `main`, each function
    is audited.

    Exit code: 0 no hazard found, 1 a hazard found, 2 undetermined, or wrong usage.

    \b
    Examples:
      shaderlab audit lamp.frag
      shaderlab audit shaders/ --range exposure=0:8 --sarif hazards.sarif
      shaderlab audit lighting.glsl --prove --range roughness=0.05:1
      shaderlab audit specular my_case.py
    """
    to_stderr = shared.uses_stdout({**outputs, "json": json_file})
    audits: list[Audit] = []
    files_only = not prove and all(map(_is_shader, targets))
    with contextlib.closing(
        shared.make_executor(driver, limits, workers, files_only=files_only)
    ) as executor:
        options = RunOptions(driver=driver, include=includes, limits=limits)
        plan = Plan(ranges=ranges, precision=precision, prove=prove, assume=assume)
        requests = list(_make_requests(targets, plan, stage, options))
        for audit in _collect_audits(executor.perform(requests)):
            audits.append(audit)
            for line in audit.lines(possible):
                click.echo(line, err=to_stderr)
            assumes = len(requests) == 1 and any("assumed" in i for i in audit.inputs.values())
            if show_inputs or prove or audit.clean is False or assumes:
                for line in gather_elements(f"  {n}: {role}" for n, role in audit.inputs.items()):
                    click.echo(line, err=to_stderr)
    if json_file is not None:
        shared.write_json([audit.data() for audit in audits], json_file)
    findings = [finding for audit in audits for finding in _make_findings(audit)]
    unwritten = shared.report_problems(list(shared.write_findings(findings, "audit", outputs)))
    found = {audit.clean for audit in audits}
    if False in found:
        return FAILED
    return USAGE if None in found or not audits else unwritten


def _make_requests(
    targets: Sequence[str], plan: Plan, stage: str | None, options: RunOptions
) -> Iterator[Any]:
    """What is asked of workers: one request for each shader file, and for each case."""
    from shaderlab.cli.selecting import find_files

    shaders = [Path(t) for t in targets if _is_shader(t)]
    for shader in shared.resolve_shaders(shaders, options.include):
        request = AuditFile(shader, stage, plan)
        functions = stage is None and is_library(request.name)
        if plan.prove:
            yield Call("shaderlab.functions.proving:prove_file", (request, functions), request.name)
        elif functions:
            work = "shaderlab.functions.interpreting:audit_functions"
            yield Call(work, (shader, plan), request.name)
        else:
            yield request
    cases = [target for target in targets if not _is_shader(target)]
    if cases and (plan.ranges or plan.assume):
        raise UsageError(
            "--range and --assume can't be combined with a case, whose inputs are known"
        )
    for file in find_files(cases):
        yield AuditCase(file, plan, options)


def _is_shader(target: str) -> bool:
    path = Path(target)
    is_other_file = path.suffix != ".py" and path.is_file()
    return path.is_dir() or path.suffix in EXTENSIONS or is_other_file


def _collect_audits(results: Iterable[Any]) -> Iterator[Audit]:
    """The audits of requests; one that was refused where there is no answer."""
    for result in results:
        if result.status == "done":
            yield from result.value
            continue
        if isinstance(result.value, UsageError):
            raise result.value
        if isinstance(result.value, ShaderlabError):
            why = str(result.value)
        else:
            why = describe_failure(result)
            why = why if result.item.name in why else f"{result.item.name}: {why}"
        yield Audit(file=result.item.name, hazards=(), tried=0, refused=why)


def _make_findings(audit: Audit) -> Iterator[Finding]:
    """An audit's hazards as what reviews show at their lines."""
    from shaderlab.report.findings import Finding

    for hazard in audit.hazards:
        text = str(hazard)
        yield Finding(
            rule="hazard",
            file=hazard.file,
            line=hazard.line,
            subject=hazard.kind,
            message=text.partition(": ")[2],
            severity="error" if hazard.evident else "info",
        )
    if audit.refused:
        yield Finding(
            rule="not-audited", file=audit.file, line=0, message=audit.refused, severity="warning"
        )
