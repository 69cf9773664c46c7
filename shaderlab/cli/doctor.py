"""`shaderlab doctor`: what is there, what is missing, and how to get it."""

from __future__ import annotations

import dataclasses

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.files import write_json
from shaderlab.cli.options import JSON


@click.command("doctor")
@JSON
def command(json_file: str | None) -> int:
    """Look at everything shaderlab needs: Python, packages, the compilers, the OpenGL driver.

    Exit code: 0 all there, 1 something necessary is missing.
    """
    from shaderlab.doctor import examine

    findings = examine()
    if json_file is not None:
        write_json([dataclasses.asdict(finding) for finding in findings], json_file)
    if json_file != "-":
        wide = max(len(finding.name) for finding in findings)
        for finding in findings:
            mark = click.style("✓", "green") if finding.ok else click.style("✗", "red")
            if not finding.ok and not finding.necessary:
                mark = click.style("–", "yellow")
            click.echo(f"{mark} {finding.name:<{wide}}  {finding.found}")
            for line in finding.remedy.splitlines() if not finding.ok else ():
                click.echo(f"  {'':<{wide}}  → {line}")
    return FAILED if any(f.necessary and not f.ok for f in findings) else OK
