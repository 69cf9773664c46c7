"""Files that are written whole or not at all, and paths as people read them."""

from __future__ import annotations

import errno
import functools
import os
import stat
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from shaderlab.errors import ShaderlabError, UsageError, make_visible

# A file that may be written but not replaced: its folder is someone else's or read-only, or the
# file is a mount of its own, as containers have it.
_HELD = (errno.EACCES, errno.EPERM, errno.EROFS, errno.EBUSY)


# What a limit of the shell's is about, by the error where it is reached.
_LIMITS = {
    errno.EMFILE: "allow more open files than `ulimit -n` says",
    errno.EAGAIN: "allow more processes than `ulimit -u` says",
    errno.EFBIG: "allow larger files than `ulimit -f` says",
    errno.ENOMEM: "allow more memory than `ulimit -v` says",
}


def suggest_limit(
    error: OSError, otherwise: str | None = "see its limits: ulimit -a"
) -> str | None:
    """The remedy where a limit of this system is reached."""
    return _LIMITS.get(error.errno or 0, otherwise)


CACHE_VARIABLE = "SHADERLAB_CACHE_DIR"


def cache_root() -> Path | None:
    """The folder for what is kept from one command to the next: SHADERLAB_CACHE_DIR, or else one
    in the user's cache folder.

    None if the variable is empty or the user has no home folder.
    """
    configured, base = os.environ.get(CACHE_VARIABLE), os.environ.get("XDG_CACHE_HOME", "")
    if configured == "":
        return None
    try:
        if configured is not None:
            return Path(configured).expanduser().absolute()
        caches = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    except (OSError, RuntimeError):  # no such user, no home, no working directory
        return None
    return caches / "shaderlab"


@contextmanager
def replace_file(path: str | Path) -> Iterator[Path]:
    """A path in the same folder to write to, which replaces `path` when the block ends.

    If the block raises, what it wrote is removed and a file that was there stays. The name is
    unique, so that several processes can write at once. The block may also make a symbolic link, or
    a folder where there is none yet. Anything but a folder is replaced, links and devices too: for
    a path that a person gave there is `write_named`. Raises OSError: `path` can't be replaced."""
    target = Path(path)
    # Not mkstemp: only their owner can read its files, and reports are for sharing.
    draft = target.with_name(f".{target.name[:32]}.{os.urandom(6).hex()}")
    try:
        yield draft
        os.replace(draft, target)
    except BaseException:
        if draft.is_dir() and not draft.is_symlink():
            import shutil  # few drafts are folders

            shutil.rmtree(draft, ignore_errors=True)
        else:
            draft.unlink(missing_ok=True)
        raise


def open_regular(path: str | Path, flags: int = os.O_RDONLY) -> int:
    """A descriptor of a regular file, which no other kind of file can make wait. Raises OSError: it
    can't be opened, or is no regular file: a FIFO or a device, which may have no end, or a link to
    one."""
    descriptor = -1
    try:
        descriptor = os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY, 0o666)
        mode = os.fstat(descriptor).st_mode
    except OSError as error:
        if error.errno != errno.ENXIO:  # a FIFO without a reader, or a socket
            raise
        mode = stat.S_IFIFO
    if stat.S_ISREG(mode):
        return descriptor
    if descriptor >= 0:
        os.close(descriptor)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    raise OSError(errno.EINVAL, "this is no regular file", str(path))


def read_regular(path: str | Path, size: int = -1) -> bytes:
    """The bytes of a regular file, at most `size` of them. Raises OSError, as `open_regular`."""
    with open(open_regular(path), "rb") as file:
        return file.read(size)


REPORT_MARK = ".shaderlab"
"""An empty file in each folder of a report, whose files may be replaced."""
_REPORT_FOLDERS = ("cases", "images", "page", "spirv")


def claim_folder(folder: Path) -> None:
    """Make a folder for a report, or take one that is empty or has one already. Raises UsageError:
    it has files of others, or a link, as `refuse_links` says; OSError: it can't be made."""
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()) and not _holds_report(folder):
        raise UsageError(
            "this folder has files that are no report's, and a report might replace them",
            file=folder,
            remedy="name an empty folder, or a new one",
        )
    refuse_links(folder)
    (folder / REPORT_MARK).touch()


def refuse_links(folder: Path) -> None:
    """Raise UsageError where a report in this folder would be written elsewhere, by a link, or
    something else has one of its places."""
    for path in (folder / name for name in (*_REPORT_FOLDERS, "records.jsonl", "mutants.json")):
        is_folder = path.name in _REPORT_FOLDERS
        if path.is_symlink() or (path.exists() and path.is_dir() != is_folder):
            what = "folder" if is_folder else "file"
            raise UsageError(
                f"a report has a {what} of its own here", file=path, remedy="remove what is there"
            )


def _holds_report(folder: Path) -> bool:
    journal = b""  # a copy of a folder may lack hidden files
    with suppress(OSError):
        journal = read_regular(folder / "records.jsonl", 12)
    return (folder / REPORT_MARK).exists() or journal == b'{"started":"'


def open_memory_file() -> BinaryIO:
    """A file without a name that takes no room on any disk."""
    return open(os.memfd_create("shaderlab"), "w+b")


def reserve_standard_descriptors() -> None:
    """Keep the numbers of standard streams that are closed from being given to files."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def write_bytes(path: str | Path, data: bytes) -> None:
    """Write a file whole or not at all. Raises OSError: it can't be written."""
    with replace_file(path) as draft:
        draft.write_bytes(data)


def write_if_changed(path: str | Path, data: bytes) -> None:
    """As `write_bytes`, where the file has other bytes: replacing one waits for the disk, and most
    of a report's pictures are those of the run before."""
    with suppress(OSError):
        if os.lstat(path).st_size == len(data) and read_regular(path) == data:
            return
    write_bytes(path, data)


def write_named(path: str | Path, data: bytes, *, append: bool = False) -> None:
    """Write a file that a person named, whole or not at all where it is a regular file.

    Links stay: the file that they lead to is written. A pipe, a terminal or another device is
    written to, and so is an open descriptor (/dev/stdout, /dev/fd/3, a shell's `>(…)`). A regular
    file keeps its permissions; one that can't be replaced, since only the file itself may be
    written, is written in place; or with `append` after what is in it already. Missing folders are
    made. Raises OSError: it can't be written."""
    target, descriptor = _follow_links(Path(path))
    if descriptor is not None:
        with os.fdopen(os.dup(descriptor), "wb") as file:
            file.write(data)
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if append or (target.exists() and not target.is_file()):
        # A FIFO that nobody reads is an error at once.
        descriptor = os.open(target, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NONBLOCK, 0o666)
        os.set_blocking(descriptor, True)
        with os.fdopen(descriptor, "ab") as file:
            file.write(data)
        return
    try:
        with replace_file(target) as draft:
            draft.write_bytes(data)
            if target.exists():
                there = target.stat()
                with suppress(OSError):  # root's file would lock out the one whose file it was
                    os.chown(draft, there.st_uid, there.st_gid)
                draft.chmod(stat.S_IMODE(there.st_mode))
    except OSError as error:
        if error.errno not in _HELD:
            raise
        target.write_bytes(data)


def _follow_links(path: Path) -> tuple[Path, int | None]:
    """Where symbolic links lead, and which of this process's descriptors that stands for.

    The links of /proc's descriptors are not followed: they may lead to what has no name, and a
    file that is open is to be written, not to be replaced.
    """
    own = f"/proc/{os.getpid()}/fd"
    for _ in range(40):  # as many as Linux follows
        if path.name.isdecimal() and os.path.realpath(path.parent) == own:
            return path, int(path.name)
        if not path.is_symlink():
            return path, None
        path = path.parent / os.readlink(path)
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))


def write_text(path: str | Path, text: str | Iterable[str]) -> None:
    """Write UTF-8 text, in one string or piece by piece, whole or not at all.

    Missing folders are made. Lone surrogates (file names in another encoding) are written as
    question marks. Raises ShaderlabError: the folder or the file can't be written."""
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with (
            replace_file(target) as draft,
            draft.open("w", encoding="utf-8", errors="replace", newline="") as file,
        ):
            file.writelines((text,) if isinstance(text, str) else text)
    except OSError as error:
        raise ShaderlabError(
            f"can't write the file ({error.strerror or error})",
            file=target,
            remedy=suggest_limit(error, "check that the folder may be written to and has room"),
        ) from error


def display_path(path: str | Path, line: int | None = None) -> str:
    """A path, or `path:line`, as people read it: relative if it is below the working directory.

    A relative path stays as it is, but for characters that can't be seen.
    """
    shown = str(path)
    if os.path.isabs(shown):
        relative = os.path.relpath(shown)
        if not relative.startswith(os.pardir):
            shown = relative
    shown = make_visible(shown).replace("\n", "[U+000A]")
    return shown if line is None else f"{shown}:{line}"


_STANDARD_LIBRARY = os.path.dirname(os.__file__)


def sort_search_path(path: Sequence[str]) -> list[str]:
    """Return a search path like `sys.path`, as absolute folders, Python's own first.

    So a random.py of a project is not taken for the standard library's.
    """
    folders = [os.path.abspath(entry) if entry else os.getcwd() for entry in path]
    return sorted(folders, key=lambda folder: not _is_pythons(folder))  # stable


@contextmanager
def search_folder(folder: str) -> Iterator[None]:
    """Look for modules in `folder` too: after Python's own, before installed packages."""
    entry = folder + os.sep  # another object than an equal entry that stays
    first = (sys.path.index(known) for known in set(filter(_is_pythons, sys.path)))
    sys.path.insert(max(first, default=-1) + 1, entry)
    try:
        yield
    finally:
        sys.path.remove(entry)


@functools.lru_cache(256)
def _is_pythons(folder: str) -> bool:
    name = os.path.basename(folder)
    return (
        folder == _STANDARD_LIBRARY
        or (name == "lib-dynload" and os.path.dirname(folder) == _STANDARD_LIBRARY)
        or name == f"python{sys.version_info.major}{sys.version_info.minor}.zip"
    )
