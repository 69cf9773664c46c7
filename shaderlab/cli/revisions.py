"""A shader as it was: its file, and all others, at a revision of a Git repository."""

from __future__ import annotations

import io
import subprocess
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from shaderlab.compiler.shader_files import is_shader
from shaderlab.errors import UsageError


@dataclass(frozen=True)
class Revision:
    """The shaders of a repository at one of its revisions, in a folder of their own.

    Attributes:
        name: as it was given: "HEAD~1".
        top: the repository's folder.
        folder: the one that has the shaders as they were.
    """

    name: str
    top: Path
    folder: Path

    def then(self, path: Path) -> Path:
        """Where a file or folder of the repository is as it was; others are where they are."""
        real = path.resolve()
        return self.folder / real.relative_to(self.top) if real.is_relative_to(self.top) else path

    def shown(self, path: str) -> str:
        """A file of the revision's as Git writes it: "HEAD~1:shaders/lamp.frag"."""
        inside = Path(path)
        if not inside.is_relative_to(self.folder):
            return path
        return f"{self.name}:{inside.relative_to(self.folder).as_posix()}"


@contextmanager
def revision(path: Path, name: str) -> Iterator[Revision]:
    """The revision `name` of the repository that the file is in.

    Raises:
        UsageError: there is no Git, no repository or no such revision, or the file was not in it.
    """
    here = path.resolve().parent
    top = Path(_git(here, "rev-parse", "--show-toplevel").decode().rstrip("\n"))
    commit = _git(here, "rev-parse", "--verify", "--end-of-options", f"{name}^{{commit}}")
    hash_ = commit.decode().strip()
    files = _git(top, "ls-tree", "-r", "-z", "--name-only", hash_).decode().split("\0")
    shaders = [file for file in files if is_shader(file)]
    own = path.resolve().relative_to(top.resolve()).as_posix()
    if own not in shaders:
        raise UsageError(f"{own} is not in revision {name}", file=path)
    with tempfile.TemporaryDirectory(prefix="shaderlab-") as folder:
        archive = _git(top, "archive", "--format=tar", hash_, "--", *shaders)
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(folder, filter="data")
        yield Revision(name, top.resolve(), Path(folder).resolve())


def _git(folder: Path, *words: str) -> bytes:
    try:
        done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, check=False)
    except FileNotFoundError:
        raise UsageError("--against needs git, which is not installed") from None
    if done.returncode:
        said = done.stderr.decode(errors="replace").strip().splitlines()
        raise UsageError(f"git: {said[-1] if said else 'failed'}")
    return done.stdout
