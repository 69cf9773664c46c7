"""`shaderlab new`: first tests for the functions of a shader."""

from __future__ import annotations

import os
from pathlib import Path

import click

from shaderlab.cli import OK
from shaderlab.cli.options import write_output
from shaderlab.engine.settings import load_settings
from shaderlab.errors import UsageError


@click.command("new")
@click.argument("shader", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The test file; by default tests/test_NAME.py in the project, or test_NAME.py here.",
)
def command(shader: Path, output: Path | None) -> int:
    """Write a passing test file for SHADER: for each function, arguments in likely ranges and a
    law that holds there. An existing file is left alone.

    Exit code: 0 written, 2 the file exists, or the shader has no function.
    """
    from shaderlab.functions.first_tests import first_tests
    from shaderlab.functions.library import load

    library = load(shader.absolute())
    root = load_settings(shader.absolute().parent).root
    if output is None:
        tests = root / "tests" if root is not None and (root / "tests").is_dir() else Path()
        output = tests / f"test_{shader.name.replace('.', '_').removesuffix('_glsl')}.py"
    if output.exists():
        raise UsageError("this file exists already", file=output, remedy="name another: -o")
    base = root if root is not None else output.absolute().parent
    path = Path(os.path.relpath(shader.absolute(), base)).as_posix()
    text = first_tests(library, path)
    if "\ndef test_" not in text:
        raise UsageError("no function in this file can be tested", file=shader)
    write_output(text, str(output))
    click.echo(f"{output}: {text.count('def test_')} tests; run them with pytest")
    return OK
