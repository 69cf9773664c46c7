"""The command line: each command is a module, imported when it is called."""

import importlib
import io
import os
import resource
import sys
from pathlib import Path
from typing import Any

import click

from ..errors import ShaderlabError, UsageError, require_linux, suggest
from ..files import reserve_standard_descriptors, suggest_limit

DEBUG = "SHADERLAB_DEBUG"
OK = 0
FAILED = 1
USAGE = 2
INTERRUPTED = 130
"""Exit statuses; a command returns one."""

# The module and the summary of each command, which `--help` prints without importing it.
COMMANDS = {
    "list": ("list_cases", "List the cases."),
    "run": ("run", "Run cases, judge them, write the report."),
    "watch": ("watch", "Rerun whatever depends on a file as soon as it is saved."),
    "compile": ("compile", "Compile shaders without rendering."),
    "explain": ("explain", "Show what each line of a shader computes at a pixel."),
    "diff": ("diff", "Check whether a rewritten shader computes the same."),
    "audit": ("audit", "Find undefined behaviour in a shader, without a reference."),
    "prove": ("prove", "Prove hazards absent for all inputs of their ranges, or show one."),
    "mutate": ("mutate", "Plant mistakes in shaders; report which ones go unnoticed."),
    "report": ("reporting", "Rebuild the pages of a run."),
    "doctor": ("doctor", "Check the installation, and say how to get what is missing."),
}


class Commands(click.Group):
    """Imports the module of a command when that is called, so that `list` stays quick."""

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
            raise click.UsageError(f"No such command {args[0]!r}; {suggest(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        debug = ctx.params.get("debug")
        before = os.environ.get(DEBUG)
        if debug:
            os.environ[DEBUG] = "1"  # for the lab, and for its workers
        try:
            require_linux()
            _require_limits()
            status = super().invoke(ctx)
        except (ShaderlabError, OSError) as error:
            if debug or isinstance(error, BrokenPipeError):  # click knows a reader who has gone
                raise
            click.echo(f"shaderlab: {_format_error(error)}", err=True)
            status = USAGE if isinstance(error, UsageError) else FAILED
        except KeyboardInterrupt:
            status = INTERRUPTED
        finally:
            if debug and before is None:
                del os.environ[DEBUG]
        if status == INTERRUPTED:
            click.echo("\nshaderlab: interrupted", err=True)
        ctx.exit(status or OK)


# What a process needs at least, by measurements with one small case, and the limit's option.
_LEAST = {"NOFILE": (32, "open files", "-n"), "AS": (768 << 20, "bytes of memory", "-v"),
          "DATA": (256 << 20, "bytes of memory", "-d")}  # fmt: skip


def _require_limits() -> None:
    """Raise UsageError where limits of this system would end every command halfway."""
    for name, (least, what, option) in _LEAST.items():
        allowed = resource.getrlimit(getattr(resource, f"RLIMIT_{name}"))[0]
        if allowed != resource.RLIM_INFINITY and allowed < least:
            raise UsageError(
                f"this system allows {allowed:,} {what}; shaderlab needs {least:,}",
                remedy=f"allow more than `ulimit {option}` says",
            )


def _format_error(error: OSError | ShaderlabError) -> str:
    try:
        os.getcwd()
    except OSError:
        return "the working folder has been removed\n  → change to a folder that exists"
    if isinstance(error, ShaderlabError):
        return str(error)
    said = f"{error.filename}: {error.strerror}" if error.filename else error.strerror or str(error)
    return str(ShaderlabError(said, remedy=suggest_limit(error, None)))


@click.command(
    cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}
)
@click.version_option(None, "-V", "--version", package_name="shaderlab", message="%(version)s")
@click.option(
    "--debug",
    is_flag=True,
    envvar=DEBUG,
    help="Show a traceback for every error, in records as well.",
)
@click.pass_context
def cli(context: click.Context, debug: bool) -> None:
    """Test GLSL shaders: render without a GPU or a screen, compare every pixel with a Python
    formula, and read the results in one HTML page.

    \b
    Start here:
      shaderlab doctor                    check the installation
      shaderlab list                      list the cases
      shaderlab run attenuation           run one of them
      shaderlab run --all                 run all; the last line is the report's path
      shaderlab run ./my_case.py          run a case file of your own
      shaderlab watch                     rerun whatever is saved
      shaderlab compile my_shaders/       compile without rendering
      shaderlab explain spotlight         show what each line computes at a pixel
      shaderlab diff old.frag new.frag    check that a rewrite computes the same
      shaderlab audit lamp.frag           find undefined behaviour
      shaderlab prove lamp.frag           prove that no input causes any
      pytest my_cases/                    run cases as tests

    A project's settings are in [tool.shaderlab] of its pyproject.toml.

    Exit code: 0 all passed, 1 something failed, 2 wrong usage.
    """
    from ..engine.settings import load_settings, option_defaults

    context.default_map = option_defaults(load_settings(Path()))


def main() -> None:
    """Run the command line on `sys.argv`; never returns."""
    # Before NumPy is imported: its library would start a thread a core, all of which wait busily,
    # while no command multiplies large matrices.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    reserve_standard_descriptors()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may lack the character ✓
    try:
        try:
            sys.exit(cli(prog_name="shaderlab", standalone_mode=False))
        except click.ClickException as error:
            error.show()
            sys.exit(error.exit_code)
        except click.Abort:  # what click makes of an interrupt before it comes to the command
            raise KeyboardInterrupt from None
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except OSError as error:
        print(f"shaderlab: can't write to standard output: {error.strerror}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # or Python tries once more as it ends
        sys.exit(FAILED)
