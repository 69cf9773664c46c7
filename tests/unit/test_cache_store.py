"""The store behind the compile cache: whole entries or none, a bounded size, no exceptions."""

import errno
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from shaderlab.compiler.compile_cache import Store

KEY = "0a" * 32
OTHER = "1b" * 32
CONTENT = b"verdicts and modules \0\xff" * 100


def usage(store: Store) -> tuple[int, int]:
    """How many entries there are, and the bytes of disk that they take in blocks of 4096."""
    sizes = [file.stat().st_size for file in store.folder.rglob("*") if file.is_file()]
    return len(sizes), sum(-(-size // 4096) * 4096 for size in sizes)


def file_of(store: Store, key: str) -> Path:
    (found,) = store.folder.glob(f"*/{key[1:]}")
    return found


def entries(store: Store) -> list[str]:
    return sorted(file.parent.name + file.name for file in store.folder.glob("?/*"))


def test_what_was_put_can_be_read(tmp_path: Path) -> None:
    store = Store(tmp_path / "deep" / "down")
    assert store.get(KEY) is None
    store.put(KEY, CONTENT)
    store.put(OTHER, b"")
    assert store.get(KEY) == CONTENT
    assert store.get(OTHER) == b""
    assert Store(store.folder).get(KEY) == CONTENT
    store.put(KEY, b"another")
    assert store.get(KEY) == b"another"


def test_the_folder_says_that_it_is_a_cache(tmp_path: Path) -> None:
    store = Store(tmp_path / "cache")
    store.put(KEY, CONTENT)
    tag = (store.folder / "CACHEDIR.TAG").read_text()
    assert tag.startswith("Signature: 8a477f597d28d172789f06886806bc55")


@pytest.mark.parametrize(
    "damaged",
    [
        b"",
        b"\0" * 31,
        pytest.param(lambda data: data[:-1], id="cut"),
        pytest.param(lambda data: data[: len(data) // 2], id="half"),
        pytest.param(lambda data: data + b"\0", id="longer"),
        pytest.param(lambda data: data[:40] + bytes([data[40] ^ 1]) + data[41:], id="one bit"),
        pytest.param(lambda data: bytes([data[0] ^ 1]) + data[1:], id="its checksum"),
    ],
)
def test_a_damaged_entry_is_absent_and_can_be_written_again(
    tmp_path: Path, damaged: object
) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    file = file_of(store, KEY)
    file.write_bytes(damaged(file.read_bytes()) if callable(damaged) else damaged)  # type: ignore[arg-type]
    assert store.get(KEY) is None
    store.put(KEY, CONTENT)
    assert store.get(KEY) == CONTENT


def test_an_entry_in_another_ones_place_is_absent(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    store.put(OTHER, b"other")
    file_of(store, KEY).replace(file_of(store, OTHER))
    assert store.get(OTHER) is None


def test_a_folder_in_an_entrys_place_is_absent(tmp_path: Path) -> None:
    store = Store(tmp_path)
    (store.folder / KEY[0] / KEY[1:]).mkdir(parents=True)
    assert store.get(KEY) is None
    store.put(KEY, CONTENT)
    assert store.get(KEY) is None
    assert entries(store) == [KEY]  # and no draft beside it


def test_a_fifo_in_an_entrys_place_is_absent(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    file = file_of(store, KEY)
    file.unlink()
    os.mkfifo(file)
    assert store.get(KEY) is None  # and nobody waits for a writer
    store.put(KEY, CONTENT)
    assert store.get(KEY) == CONTENT


def test_a_link_to_what_has_no_end_is_absent(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    file = file_of(store, KEY)
    file.unlink()
    file.symlink_to("/dev/zero")
    assert store.get(KEY) is None
    store.put(KEY, CONTENT)
    assert store.get(KEY) == CONTENT and not file.is_symlink()


def test_below_a_file_nothing_is_stored(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    store = Store(tmp_path / "file" / "cache")
    store.put(KEY, CONTENT)
    assert store.get(KEY) is None
    assert usage(store) == (0, 0)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_can_be_read(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    shelf = file_of(store, KEY).parent
    shelf.chmod(0o500)
    try:
        store.put(KEY, b"new")
        assert store.get(KEY) == CONTENT
    finally:
        shelf.chmod(0o700)


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EACCES])
def test_a_full_or_read_only_disk_leaves_no_drafts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)

    def refuse(*_: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "replace", refuse)
    store.put(OTHER, CONTENT)
    store.put(OTHER[:1] + "c" * 63, CONTENT)
    assert entries(store) == [KEY]
    assert store.get(KEY) == CONTENT


def key(number: int) -> str:
    """A key whose folder is trimmed whenever it is put."""
    return f"000{number:061x}"


def test_the_size_is_bounded_and_the_least_recently_used_goes_first(tmp_path: Path) -> None:
    store = Store(tmp_path, limit=16 * 8 * 4096)
    for number in range(7):
        store.put(key(number), CONTENT)
        used = time.time() - 7200 + number
        os.utime(file_of(store, key(number)), (used, used))
    assert len(entries(store)) == 7
    assert store.get(key(0)) == CONTENT  # which is a use
    store.put(key(7), CONTENT)
    assert entries(store) == [key(number) for number in (0, 2, 3, 4, 5, 6, 7)]
    for number in range(100, 200):
        store.put(key(number), CONTENT)
        assert usage(store)[1] <= 7 * 4096
    assert store.get(key(199)) == CONTENT


def test_folders_are_trimmed_now_and_then(tmp_path: Path) -> None:
    share = 2048
    store = Store(tmp_path, limit=16 * share * 4096)
    for number in range(2 * share):  # keys of one folder; one in 256 trims it
        store.put(f"0{number % 256:02x}{number:061x}", b"")
        assert number % 64 or usage(store)[0] <= share
    assert usage(store)[0] > share * 3 // 4


def test_an_entry_larger_than_a_folders_share_is_not_stored(tmp_path: Path) -> None:
    store = Store(tmp_path, limit=16 * 4 * 4096)
    store.put(KEY, b"x" * (4 * 4096))
    assert store.get(KEY) is None
    store.put(KEY, b"x" * (3 * 4096))
    assert store.get(KEY) is not None
    file_of(store, KEY).write_bytes(b"x" * 10**6)  # nor read, if something else put it there
    assert store.get(KEY) is None


def test_drafts_of_processes_that_died_are_removed(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(key(1), CONTENT)
    old, new = (file_of(store, key(1)).with_name(name) for name in (".old", ".new"))
    for draft, age in ((old, 7200), (new, 60)):
        draft.write_bytes(b"half")
        os.utime(draft, (time.time() - age,) * 2)
    store.put(key(2), CONTENT)
    assert not old.exists()
    assert new.exists()
    assert store.get(key(1)) == store.get(key(2)) == CONTENT


def test_the_time_of_use_is_known_to_the_hour(tmp_path: Path) -> None:
    store = Store(tmp_path)
    store.put(KEY, CONTENT)
    for age, noted in ((60, False), (7200, True)):
        then = time.time() - age
        os.utime(file_of(store, KEY), (then, then))
        assert store.get(KEY) == CONTENT
        assert (file_of(store, KEY).stat().st_mtime > then + 1) == noted


MANY = """
import sys
from pathlib import Path
from shaderlab.compiler.compile_cache import Store
store = Store(Path(sys.argv[1]), limit=16 * 64 * 4096)
for turn in range(3):
    for number in range(300):
        key = f"0{number % 4:02x}{number:061x}"
        content = store.get(key)
        assert content in (None, str(number).encode() * 500), content
        store.put(key, str(number).encode() * 500)
"""


def test_processes_read_write_and_remove_at_once(tmp_path: Path) -> None:
    command = [sys.executable, "-c", MANY, str(tmp_path)]
    running = [subprocess.Popen(command, stderr=subprocess.PIPE) for _ in range(3)]
    for process in running:
        _, said = process.communicate(timeout=120)
        assert process.returncode == 0, said.decode()
    store = Store(tmp_path)
    stored = entries(store)
    assert stored
    assert all(store.get(one) is not None for one in stored)  # whole, and no drafts
