"""`shaderlab doctor`: what is there, what is missing, and how to get it."""

from __future__ import annotations

import dataclasses
import json

import click


@click.command("doctor", short_help="What is there, what is missing, how to get it.")
@click.option("--json", "as_json", is_flag=True, help="As a JSON array on standard output.")
def command(as_json: bool) -> None:
    """Look at everything shaderlab needs: Python, packages, the compilers, the OpenGL driver.

    Exit code: 0 all there, 1 something necessary is missing.
    """
    from shaderlab.doctor import examine

    findings = examine()
    if as_json:
        found = [dataclasses.asdict(finding) for finding in findings]
        click.echo(json.dumps(found, indent=2, ensure_ascii=False))
    else:
        wide = max(len(finding.name) for finding in findings)
        for finding in findings:
            mark = click.style("✓", "green") if finding.ok else click.style("✗", "red")
            if not finding.ok and not finding.necessary:
                mark = click.style("–", "yellow")
            click.echo(f"{mark} {finding.name:<{wide}}  {finding.found}")
            for line in finding.remedy.splitlines() if not finding.ok else ():
                click.echo(f"  {'':<{wide}}  → {line}")
    missing = [f.name for f in findings if f.necessary and not f.ok]
    if missing:
        raise SystemExit(1)
