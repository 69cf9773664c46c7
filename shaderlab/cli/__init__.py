"""The command line. Each command is a module of its own, imported when it is called."""

from __future__ import annotations

import errno
import importlib
import os
import sys
from pathlib import Path
from typing import Any

import click

from ..errors import ShaderlabError, UsageError, nearest

DEBUG = "SHADERLAB_DEBUG"
OK = 0
FAILED = 1
USAGE = 2
INTERRUPTED = 130
"""Exit statuses; a command returns one."""

# Each command's module in this package, and what it does, which `--help` says without importing it.
COMMANDS = {
    "list": ("list_cases", "The cases there are."),
    "run": ("run", "Run cases, judge them, write the report."),
    "watch": ("watch", "Judge again what depends on a saved file."),
    "sweep": ("sweep", "Run one case over a grid of inputs; a table and plots."),
    "compile": ("compile", "Only ask the compilers."),
    "explain": ("explain", "What each line of a shader computes at a pixel."),
    "diff": ("diff", "Is a rewritten shader the same one?"),
    "audit": ("audit", "What may go wrong in a shader, without a reference."),
    "mutate": ("mutate", "Make mistakes in cases' shaders; see which get by."),
    "report": ("reporting", "Make a run's pages again."),
    "init": ("init", "Settings, a CI workflow and a .gitignore line for a repository."),
    "new": ("new", "First tests for the functions of a shader."),
    "doctor": ("doctor", "What is there, what is missing, how to get it."),
}


class Commands(click.Group):
    """Finds a command's module only when it is needed, so that `list` stays quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module = importlib.import_module(f".{COMMANDS[name][0]}", __name__)
        command: click.Command = module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, does) for name, (_, does) in COMMANDS.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"No such command {args[0]!r}; {nearest(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        debug = ctx.params.get("debug")
        before = os.environ.get(DEBUG)
        if debug:
            os.environ[DEBUG] = "1"  # for the lab, and for its workers
        try:
            status = super().invoke(ctx)
        except ShaderlabError as error:
            if debug:
                raise
            click.echo(f"shaderlab: {_said(error)}", err=True)
            status = USAGE if isinstance(error, UsageError) else FAILED
        except OSError as error:
            if debug or error.errno == errno.EPIPE:  # click knows a reader who has gone
                raise
            click.echo(f"shaderlab: {_said(error)}", err=True)
            status = FAILED
        except KeyboardInterrupt:
            status = INTERRUPTED
        finally:
            if debug and before is None:
                del os.environ[DEBUG]
        if status == INTERRUPTED:
            click.echo("\nshaderlab: interrupted", err=True)
        ctx.exit(status or OK)


def _said(error: OSError | ShaderlabError) -> str:
    try:
        os.getcwd()
    except OSError:
        return "the working folder has been removed\n  → change to one that is there"
    if isinstance(error, ShaderlabError):
        return str(error)
    return f"{error.filename}: {error.strerror}" if error.filename else str(error.strerror or error)


@click.command(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(None, "-V", "--version", package_name="shaderlab", message="%(version)s")
@click.option(
    "--debug",
    is_flag=True,
    envvar=DEBUG,
    help="Show a traceback for every error, in records too.",
)
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Make shader formulas testable: run GLSL without a GPU or a screen, hold every pixel against
    a Python formula, and see it all in one HTML page.

    \b
    Start here:
      shaderlab doctor                    is everything there?
      shaderlab list                      what cases there are
      shaderlab run attenuation           one of them, judged
      shaderlab run --all --open          all of them, then the report in a browser
      shaderlab run ./my_case.py          a case file of your own
      shaderlab watch                     judge again whatever is saved
      shaderlab sweep ID --param …        one case over a grid of inputs
      shaderlab compile my_shaders/       only ask the compilers
      shaderlab explain spotlight         what each line computes at a pixel
      shaderlab diff old.frag new.frag    is a rewritten shader the same one?
      shaderlab audit lamp.frag           what may go wrong in it?
      pytest my_cases/                    the same cases as tests

    Settings of a project are in [tool.shaderlab] of its pyproject.toml.

    Exit code: 0 all passed, 1 something failed, 2 wrong usage.
    """
    from ..settings import defaults, settings_of

    context.default_map = defaults(settings_of(Path()))


def main() -> None:
    """Run the command line on `sys.argv`; never returns."""
    # Before NumPy is imported: its library would start a thread a core, all of which wait busily,
    # while no command multiplies large matrices.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from shaderlab.cli.outputs import final_status, open_streams

    open_streams()
    try:
        cli(prog_name="shaderlab")
    except SystemExit as ended:
        sys.exit(final_status(ended.code))
