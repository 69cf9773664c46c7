"""`shaderlab init`: add what a repository needs for shader tests."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path

import click

from shaderlab.cli import OK
from shaderlab.cli.options import write_output
from shaderlab.engine.settings import FILE
from shaderlab.errors import UsageError

_TABLE = """\
[tool.shaderlab]
# Where shaders are found by name, from this folder; by default in all of the repository.
shaders = [{shaders}]
# include = ["third_party/glsl"]                  # more folders for #include
# targets = ["glsl", "opengl", "vulkan"]          # what must accept them
# driver = "llvmpipe"                             # softpipe, or "default" for the machine's own
# timeout = 30                                    # seconds that one variant may take
# memory = 4                                      # gigabytes that one worker may have
# keep = 20                                       # runs that stay in reports/; 0 for all
"""
_WORKFLOW = """\
name: shaders
on: [push, pull_request]
permissions:
  contents: read
  security-events: write  # for code scanning

jobs:
  test:
    runs-on: ubuntu-latest
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with:
          python-version: "3.12"
      - run: sudo apt-get update && sudo apt-get install -y libegl1 libgl1-mesa-dri
      - run: pip install 'shaderlab[pytest]'  # or its wheel, or the address of its repository
      - run: shaderlab compile {shaders}
      - run: pytest --shaderlab-report reports/ci  # cases, and tests of GLSL functions
      - if: always()
        run: >
          test ! -f reports/ci/run.json ||
          shaderlab report reports/ci --sarif shaderlab.sarif
          --junit shaderlab.xml --markdown "$GITHUB_STEP_SUMMARY"
      - if: always()
        continue-on-error: true  # a private repository may have no code scanning
        uses: github/codeql-action/upload-sarif@v3
        with:
          sarif_file: shaderlab.sarif
      - if: always()
        uses: actions/upload-artifact@v4
        with:
          name: shaderlab
          path: |
            reports/
            shaderlab.xml
"""
_WORKFLOW_FILE = Path(".github", "workflows", "shaders.yml")
_IGNORED = "/reports/"


@click.command("init")
def command() -> int:
    """Add what a repository needs for shader tests to this folder: a table [tool.shaderlab] in
    pyproject.toml with the folders of its shaders, a workflow for GitHub Actions, and a line in
    .gitignore that excludes reports/.

    Existing entries are left alone.

    Exit code: 0 everything is in place, 2 something can't be written.
    """
    folders = list(_shader_folders()) or ["."]
    listed = ", ".join(f'"{name}"' for name in folders)
    _add_settings(_TABLE.format(shaders=listed))
    if _WORKFLOW_FILE.exists():
        _report("exists already", _WORKFLOW_FILE)
    else:
        _write(_WORKFLOW_FILE, _WORKFLOW.format(shaders=" ".join(folders)))
    _add_ignore_line()
    click.echo("\nnext: write a test (docs/guide/tutorial.md)")
    return OK


def _shader_folders() -> Iterator[str]:
    """The topmost folders that hold shaders, from here."""
    from shaderlab.compiler.shader_files import Roots

    names = Roots([Path()], {}).names()
    yield from sorted({name.partition("/")[0] if "/" in name else "." for name in names})


def _add_settings(table: str) -> None:
    file = Path(FILE)
    before = _read_text(file)
    try:
        known = tomllib.loads(before)
        if "shaderlab" in known.get("tool", {}):
            _report("has [tool.shaderlab] already", file)
            return
        gap = "" if not before else "\n" if before.endswith("\n") else "\n\n"
        tomllib.loads(before + gap + table)
    except (tomllib.TOMLDecodeError, TypeError, AttributeError) as error:
        raise UsageError(
            f"can't add [tool.shaderlab]: {error}", file=file, remedy="correct the file first"
        ) from error
    _write(file, before + gap + table, added=bool(before))


def _add_ignore_line() -> None:
    file = Path(".gitignore")
    before = _read_text(file)
    if {line.strip().strip("/") for line in before.splitlines()} & {"reports", "reports/*"}:
        _report("excludes reports/ already", file)
        return
    gap = "" if not before or before.endswith("\n") else "\n"
    _write(file, f"{before}{gap}{_IGNORED}\n", added=bool(before))


def _read_text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8") if file.exists() else ""
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"can't read this file: {error}", file=file) from error


def _write(file: Path, text: str, *, added: bool = False) -> None:
    write_output(text, str(file))
    _report("added to" if added else "written", file)


def _report(what: str, file: Path) -> None:
    click.echo(f"{what}: {file}" if what in ("written", "added to") else f"{file} {what}")
