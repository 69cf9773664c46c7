"""Files are written whole or not at all; paths read well from the working directory."""

from __future__ import annotations

import errno
import os
import socket
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from shaderlab.errors import ShaderlabError
from shaderlab.files import (
    display_path,
    read_regular,
    replace_file,
    write_bytes,
    write_if_changed,
    write_named,
    write_text,
)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_block_that_fails_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    file = tmp_path / "a.txt"
    file.write_text("old")
    with pytest.raises(KeyError), replace_file(file) as draft:
        draft.write_text("half")
        raise KeyError
    assert file.read_text() == "old" and names(tmp_path) == ["a.txt"]


def test_a_folder_appears_whole_and_never_over_another(tmp_path: Path) -> None:
    for fails in (False, True):
        try:
            with replace_file(tmp_path / "folder") as draft:
                draft.mkdir()
                (draft / str(fails)).write_text("")
        except OSError:
            assert fails
    assert names(tmp_path) == ["folder"] and names(tmp_path / "folder") == ["False"]


def test_a_link_replaces_a_link(tmp_path: Path) -> None:
    for target in ("one", "two"):
        (tmp_path / target).mkdir()
        with replace_file(tmp_path / "latest") as draft:
            draft.symlink_to(target)
    assert (tmp_path / "latest").resolve().name == "two"
    assert names(tmp_path) == ["latest", "one", "two"]


def test_text_comes_in_pieces_and_keeps_the_old_file_if_they_end_early(tmp_path: Path) -> None:
    file = tmp_path / "new" / "a.txt"
    write_text(file, ("é\udcff" for _ in range(100)))
    assert file.read_bytes() == ("é?" * 100).encode()

    def pieces():  # type: ignore[no-untyped-def]
        yield "x"
        raise KeyError

    with pytest.raises(KeyError):
        write_text(file, pieces())
    assert file.read_bytes() == ("é?" * 100).encode() and names(file.parent) == ["a.txt"]


def test_what_cannot_be_written_says_where(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ShaderlabError, match="can't write the file") as caught:
        write_text(tmp_path / "file" / "a.txt", "x")
    assert caught.value.file == str(tmp_path / "file" / "a.txt")
    with pytest.raises(OSError):
        write_bytes(tmp_path / "missing" / "a.bin", b"x")


def test_paths_below_the_working_directory_are_relative(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert display_path(tmp_path / "a" / "b.frag", 3) == "a/b.frag:3"
    assert display_path("lib/light.glsl") == "lib/light.glsl"
    assert display_path("/x.frag", 1) == "/x.frag:1"
    assert display_path(tmp_path.parent / "other.frag") == str(tmp_path.parent / "other.frag")


def test_a_named_file_is_written_whole_and_keeps_its_permissions(tmp_path: Path) -> None:
    file = tmp_path / "new" / "a.json"
    write_named(file, b"first" * 9)
    file.chmod(0o640)
    write_named(file, b"second")
    write_named(file, b", third", append=True)
    assert file.read_bytes() == b"second, third" and file.stat().st_mode & 0o777 == 0o640
    assert names(file.parent) == ["a.json"]


def test_links_to_named_files_stay(tmp_path: Path) -> None:
    for name, target in (("one", "two"), ("two", "sub/file")):
        (tmp_path / name).symlink_to(target)
    for data in (b"through a link that leads nowhere yet", b"again"):
        write_named(tmp_path / "one", data)
        assert (tmp_path / "sub" / "file").read_bytes() == data
    assert (tmp_path / "one").is_symlink() and (tmp_path / "two").is_symlink()
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OSError):
        write_named(tmp_path / "loop", b"")
    assert (tmp_path / "loop").is_symlink()


def test_what_is_no_regular_file_is_written_to(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    write_named(fifo, b"through")
    assert os.read(reader, 99) == b"through" and stat.S_ISFIFO(fifo.stat().st_mode)
    os.close(reader)


def test_an_open_descriptor_is_written_where_it_stands(tmp_path: Path) -> None:
    ours, theirs = os.pipe()
    write_named(f"/dev/fd/{theirs}", b"a shell's >(...)")
    assert os.read(ours, 99) == b"a shell's >(...)"
    for descriptor in (ours, theirs):
        os.close(descriptor)
    with pytest.raises(OSError, match="descriptor"):
        write_named(f"/dev/fd/{theirs}", b"")
    # As `--json /dev/stdout >> log` has it: what is in the file, and whoever writes next, stays.
    (tmp_path / "log").write_bytes(b"earlier, ")
    with (tmp_path / "log").open("ab", buffering=0) as file:
        write_named(f"/dev/fd/{file.fileno()}", b"now, ")
        file.write(b"later")
    assert (tmp_path / "log").read_bytes() == b"earlier, now, later"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="devices of Linux")
def test_devices_stay_devices(tmp_path: Path) -> None:
    full = tmp_path / "full"
    try:
        os.mknod(full, stat.S_IFCHR | 0o666, os.makedev(1, 7))
    except PermissionError:  # not root: the machine's own, which nobody can replace
        full.symlink_to("/dev/full")
    for data, append in ((b"x", False), (b"x" * (1 << 20), False), (b"x", True)):
        with pytest.raises(OSError, match="No space left"):
            write_named(full, data, append=append)
    assert stat.S_ISCHR(full.stat().st_mode)


@pytest.mark.parametrize("append", [False, True])
def test_a_pipe_that_nobody_reads_makes_no_one_wait(tmp_path: Path, append: bool) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(OSError) as raised:
        write_named(pipe, b"lost", append=append)
    assert raised.value.errno == errno.ENXIO
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_named(pipe, b"read", append=append)
    assert os.read(reader, 9) == b"read" and pipe.is_fifo()
    os.close(reader)


@pytest.mark.parametrize(("code", "option"), [(errno.EMFILE, "-n"), (errno.EFBIG, "-f")])
def test_a_limit_that_is_reached_is_named(tmp_path: Path, code: int, option: str) -> None:
    def pieces() -> Iterator[str]:
        raise OSError(code, os.strerror(code))
        yield ""

    with pytest.raises(ShaderlabError, match=f"→ allow more .* than `ulimit {option}` says|larger"):
        write_text(tmp_path / "page", pieces())


def test_a_file_that_can_not_be_replaced_is_written_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a.json"
    file.write_bytes(b"x" * 99)

    def busy(*_: object) -> None:
        raise OSError(errno.EBUSY, "as of a file that a container mounts")

    monkeypatch.setattr(os, "replace", busy)
    write_named(file, b"short")
    assert file.read_bytes() == b"short" and names(tmp_path) == ["a.json"]
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(errno.ENOSPC, "")))
    with pytest.raises(OSError):
        write_named(file, b"lost")
    assert file.read_bytes() == b"short" and names(tmp_path) == ["a.json"]


def test_only_regular_files_are_read_and_no_other_makes_wait(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"12345")
    (tmp_path / "link").symlink_to("file")
    assert read_regular(tmp_path / "link") == b"12345"
    assert read_regular(tmp_path / "file", 2) == b"12"
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "endless").symlink_to("/dev/zero")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(os.path.relpath(tmp_path / "socket"))
        for name in ("fifo", "endless", "socket"):
            with pytest.raises(OSError, match="this is no regular file"):
                read_regular(tmp_path / name)
    with pytest.raises(IsADirectoryError):
        read_regular(tmp_path)
    with pytest.raises(FileNotFoundError):
        read_regular(tmp_path / "gone")


def test_a_file_that_has_these_bytes_already_is_not_replaced(tmp_path: Path) -> None:
    file = tmp_path / "a.png"
    for data, changed in ((b"old", True), (b"old", False), (b"new", True), (b"longer", True)):
        before = file.stat().st_ino if file.exists() else 0
        write_if_changed(file, data)
        assert file.read_bytes() == data and (file.stat().st_ino != before) is changed
