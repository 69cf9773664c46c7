"""Files that are saved: what editors do to them, as one set of paths a moment."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Collection, Iterable
from hashlib import blake2b
from pathlib import Path

from shaderlab.errors import extra
from shaderlab.files import read_regular

_STEP = 15
"""Milliseconds without another event that end a moment: an editor's save is several events."""
_LONGEST = 200
_MISSING = 0.15
"""Seconds that a file may be missing: some editors remove it and write it anew."""
_CLOCK_TICK = 0.02
"""Seconds by which a file's time may lag behind the clock."""


class Changes:
    """Watches folders, in a thread; a context manager.

    Args:
        folders: with everything below them, but for what tools write (.git, __pycache__, …).

    Raises:
        UsageError: the extra "watch" is not installed.
    """

    def __init__(self, folders: Iterable[Path]) -> None:
        with extra("watch", "shaderlab watch"):
            import watchfiles
        self._watch = watchfiles.watch
        self._filter = watchfiles.DefaultFilter()
        self._batches: queue.SimpleQueue[set[Path]] = queue.SimpleQueue()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        self._folders: set[Path] = set()
        self.add(folders)

    def __enter__(self) -> Changes:
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        for thread in self._threads:
            thread.join(2.0)

    def add(self, folders: Iterable[Path], *, below: bool = True) -> None:
        """Watch further folders, unless they lie in those that are watched; with `below` also
        everything below them."""
        for folder in sorted(set(folders)):
            known = any(folder.is_relative_to(one) for one in self._folders)
            if known or not folder.is_dir():
                continue
            if below:
                self._folders.add(folder)
            ready = threading.Event()
            thread = threading.Thread(target=self._serve, args=[folder, ready, below], daemon=True)
            self._threads.append(thread)
            thread.start()
            ready.wait(5.0)

    def next(self, timeout: float | None = None) -> set[Path]:
        """The files of the next moment, and of all that have passed; none after the time."""
        try:
            found = self._batches.get(timeout=timeout)
        except queue.Empty:
            return set()
        while not self._batches.empty():
            found |= self._batches.get()
        return found

    def pending(self) -> bool:
        """Whether something has changed that `next` has not given yet."""
        return not self._batches.empty()

    def settled(self, found: set[Path], known: Collection[Path]) -> set[Path]:
        """The files, and those that change while one that is known is missing for a moment."""
        until = time.monotonic() + _MISSING
        while any(path in known and not path.exists() for path in found):
            rest = until - time.monotonic()
            if rest <= 0:
                break
            found = found | self.next(rest)
        return found

    def _serve(self, folder: Path, ready: threading.Event, below: bool) -> None:
        moments = self._watch(
            folder,
            watch_filter=self._filter,
            debounce=_LONGEST,
            step=_STEP,
            rust_timeout=200,
            yield_on_timeout=True,
            stop_event=self._stop,
            recursive=below,
            raise_interrupt=False,
        )
        ready.set()
        for moment in moments:
            if moment:
                self._batches.put({Path(name) for _, name in moment})


class Contents:
    """What is in files, so that one that was only touched is no change."""

    def __init__(self) -> None:
        self._known: dict[Path, bytes] = {}

    def learn(self, files: Iterable[Path], since: float = math.inf) -> None:
        """Take files that are not known yet as they are now, but for those that were written after
        `since` (seconds as of `time.time`): who read them may have read something else."""
        for path in files:
            if path not in self._known and _written(path) < since - _CLOCK_TICK:
                self._known[path] = _digest(path)

    def changed(self, files: Iterable[Path]) -> set[Path]:
        """Of these files, those that are not known, or have other contents; known as they are
        now from then on."""
        found = set()
        for path in files:
            digest = _digest(path)
            if self._known.get(path) != digest:
                self._known[path] = digest
                found.add(path)
        return found


def _written(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _digest(path: Path) -> bytes:
    try:
        return blake2b(read_regular(path), digest_size=16).digest()
    except OSError:
        return b""
