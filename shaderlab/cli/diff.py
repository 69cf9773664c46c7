"""`shaderlab diff`: does a rewritten shader compute the same?"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import click

from shaderlab.analysis.answer import Answer, Plan, gather_elements
from shaderlab.cli import FAILED, OK, USAGE, options as shared
from shaderlab.compiler.shader_files import is_library, is_shader
from shaderlab.compiler.translation import has_no_entry
from shaderlab.engine.jobs import Call, Executor, make_jobs
from shaderlab.errors import ShaderlabError, UsageError
from shaderlab.model.options import Limits, RunOptions

NO_ANSWER = USAGE
"""The exit status of an undetermined comparison."""
ONLY_IF = 3
"""The exit status where shaders are the same only under conditions."""


@click.command("diff")
@click.argument("old", type=click.Path(path_type=Path))
@click.argument("new", type=click.Path(path_type=Path), required=False)
@click.option(
    "--against", metavar="REV", help="Compare one file with its version at this Git revision."
)
@click.option(
    "--case",
    metavar="ID | FILE.py",
    help="Use the inputs that this case gives OLD, which may be an included file.",
)
@shared.RANGES
@click.option("--strict", is_flag=True, help="Exit with 1 also if only the accuracy changes.")
@click.option(
    "--assume", is_flag=True, help="Exit with 0 also if they are the same only under conditions."
)
@shared.stage_option("The stage of both files, whatever their names.")
@click.option("--inputs", "show_inputs", is_flag=True, help="Print the values of each input.")
@shared.INCLUDE
@shared.limits_option("Stop after S seconds.", seconds=60.0)
@shared.jobs_option("1")
@shared.JSON
def command(
    old: Path, new: Path | None, against: str | None, case: str | None, ranges: dict[str, str],
    strict: bool, assume: bool, stage: str | None, show_inputs: bool, includes: tuple[Path, ...],
    limits: Limits, workers: int, json_file: str | None,
) -> int:  # fmt: skip
    """Check whether the shader NEW computes what OLD does, without a formula: both are interpreted
    on the same inputs. Inputs are generated from names and types, or taken from a case and varied.

    State the range of an input where a guess is not enough: --range distance=0:50, or a comment at
    its declaration, `uniform float distance; // range: 0..50` (or `// range: unit`). In files
    without `main`, each function is compared.

    Exit code: 0 the same mathematics, 1 different, 2 undetermined, or wrong usage, 3 the same only
    under conditions, which are printed with inputs that do not meet them.

    \b
    Examples:
      shaderlab diff lamp.frag lamp_fast.frag
      shaderlab diff old.vert new.vert --range scale=0.1:10 --strict
      shaderlab diff lamp.frag --against HEAD~1
      shaderlab diff lib/phong.glsl my_phong.glsl --case specular
    """
    if (new is None) == (against is None):
        raise UsageError("name two shaders, OLD and NEW, or one shader and --against REV")
    if case is not None and (ranges or stage):
        raise UsageError(
            "--range and --stage can't be combined with --case, whose inputs are known"
        )
    plan = Plan(ranges=ranges, rounds=2 if case else Plan.rounds)
    comparison = _Comparison(case, stage, includes, plan, limits, workers)
    try:
        if against is None:
            assert new is not None
            answers = comparison.compare(old, new)
        else:
            answers = _compare_with_revision(comparison, old, against)
    except UsageError:
        raise
    except ShaderlabError as error:
        click.echo(f"undetermined: {error}", err=True)
        return NO_ANSWER
    to_stderr = json_file == "-"
    for answer in answers:
        plain = answer.same is True and not answer.conditional
        _print(answer, show_inputs or not plain, to_stderr, len(answers) > 1)
    if json_file is not None:
        shared.write_json([answer.data() for answer in answers], json_file)
    return _status(answers, strict=strict, assume=assume)


def _status(answers: Sequence[Answer], *, strict: bool, assume: bool) -> int:
    found = {answer.same for answer in answers}
    found |= {answer.same_numerics for answer in answers if strict}
    if False in found:
        return FAILED
    if None in found:
        return NO_ANSWER
    return ONLY_IF if not assume and any(answer.conditional for answer in answers) else OK


@dataclass(frozen=True)
class _Comparison:
    """How two shaders are compared, whichever they are."""

    case: str | None
    stage: str | None
    includes: tuple[Path, ...]
    plan: Plan
    limits: Limits
    workers: int

    def compare(
        self, old: Path, new: Path, then: Callable[[Path], Path] | None = None
    ) -> list[Answer]:
        """The answers on two files; `then` says where the old one and what it includes is. Raises
        ShaderlabError: there is none."""
        with contextlib.closing(
            shared.make_executor(None, self.limits, self.workers, files_only=self.case is None)
        ) as executor:
            request = self._make_request(old, new, then, executor)
            answers: list[Answer] = shared.perform_one(executor, request)
        return answers

    def _make_request(
        self, old: Path, new: Path, then: Callable[[Path], Path] | None, executor: Executor
    ) -> object:
        if self.case is None:
            shaders = (
                shared.resolve_shader(old, self.includes, then),
                shared.resolve_shader(new, self.includes),
            )
            paths = [Path(shader.file.path) for shader in shaders]
            functions = all(is_library(path) or has_no_entry(path) for path in paths)
            if self.stage is None and functions and any(map(is_library, paths)):
                work = "shaderlab.functions.interpreting:compare_functions"
                return Call(work, (*shaders, self.plan))
            work = "shaderlab.analysis.comparison:compare_files"
            return Call(work, (*shaders, self.stage, self.plan))
        from shaderlab.cli.selecting import resolve_replacements, select_one

        facts, _ = select_one(self.case, executor.load)
        mine, other = (old, new) if then is None else (new, then(old))
        if not other.is_file():
            raise UsageError("there is no such file", file=other)
        name = _name_in_cases(mine, Path(facts.file).parent, self.includes)
        files = resolve_replacements({name: other}, make_jobs(facts), self.includes)
        options = RunOptions(include=self.includes, limits=self.limits)
        work = "shaderlab.analysis.invocations:compare_in_case"
        return Call(work, (Path(facts.file), files, then is not None, self.plan, options))


def _compare_with_revision(comparison: _Comparison, file: Path, name: str) -> list[Answer]:
    """The answers on a file and what it was at a revision. Raises ShaderlabError."""

    if not file.is_file():
        raise UsageError("there is no such file", file=file)
    with check_out(file, name) as before:
        try:
            answers = comparison.compare(file, file, before.find_path)
        except ShaderlabError as error:
            error.file = error.file and before.format_path(error.file)
            raise
    return [replace(answer, old=before.format_path(answer.old)) for answer in answers]


def _name_in_cases(path: Path, folder: Path, includes: Sequence[Path]) -> str:
    """A shader's name as the cases of a folder know it; what was typed where it is no file."""
    from shaderlab.engine.catalogue import shaders_of

    if path.is_file():
        for root in shaders_of(folder, {}, includes).folders:
            if path.resolve().is_relative_to(root.resolve()):
                return path.resolve().relative_to(root.resolve()).as_posix()
    return path.as_posix()


def _print(answer: Answer, inputs: bool, err: bool, heading: bool) -> None:
    if heading:
        click.echo(f"{answer.old} → {answer.new}", err=err)
    for line in answer.lines():
        click.echo(line, err=err)
    roles = answer.inputs.items()  # "same" holds of those alone that are assumed
    shown = (f"  {n}: {role}" for n, role in roles if inputs or role.endswith("(assumed)"))
    for line in gather_elements(shown):
        click.echo(line, err=err)


@dataclass(frozen=True)
class Revision:
    """The shaders of a repository, whose folder is `top`, at its revision `name`, as that was given
    ("HEAD~1"), in a `folder` of their own."""

    name: str
    top: Path
    folder: Path

    def find_path(self, path: Path) -> Path:
        """Where a file or folder of the repository is as it was; others are where they are."""
        real = path.resolve()
        return self.folder / real.relative_to(self.top) if real.is_relative_to(self.top) else path

    def format_path(self, path: str) -> str:
        """A file of the revision's as Git writes it: "HEAD~1:shaders/lamp.frag"."""
        inside = Path(path)
        if not inside.is_relative_to(self.folder):
            return path
        return f"{self.name}:{inside.relative_to(self.folder).as_posix()}"


@contextmanager
def check_out(path: Path, name: str) -> Iterator[Revision]:
    """The revision `name` of the repository that the file is in. Raises UsageError: there is no
    Git, no repository or no such revision, or the file was not in it."""
    here = path.resolve().parent
    top = Path(_git(here, "rev-parse", "--show-toplevel").decode().rstrip("\n"))
    commit = _git(here, "rev-parse", "--verify", "--end-of-options", f"{name}^{{commit}}")
    hash_ = commit.decode().strip()
    files = _git(top, "ls-tree", "-r", "-z", "--name-only", hash_).decode().split("\0")
    shaders = [file for file in files if is_shader(file)]
    own = path.resolve().relative_to(top.resolve()).as_posix()
    if own not in shaders:
        raise UsageError(f"{own} is not in revision {name}", file=path)
    import tarfile  # few ask for a revision
    import tempfile

    with tempfile.TemporaryDirectory(prefix="shaderlab-") as folder:
        archive = _git(top, "archive", "--format=tar", hash_, "--", *shaders)
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(folder, filter="data")
        yield Revision(name, top.resolve(), Path(folder).resolve())


def _git(folder: Path, *words: str) -> bytes:
    import subprocess

    try:
        done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, check=False)
    except FileNotFoundError:
        raise UsageError("--against needs git, which is not installed") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise UsageError(f"git: {said[-1] if said else 'failed'}")
    return done.stdout
