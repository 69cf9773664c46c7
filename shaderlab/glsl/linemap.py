"""From the lines of a text to the author's files and lines, kept as runs of consecutive lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import overload


@dataclass(frozen=True)
class LineMap(Sequence[tuple[str, int]]):
    """For each line of a text, the author's file and line, counted from 1.

    `spans` are runs of lines: the file, the first one's line in it, and how many there are.

    >>> lines = LineMap.of([("main.frag", 1, 2), ("lib.glsl", 1, 1), ("main.frag", 4, 1)])
    >>> len(lines), lines[1], lines[2], lines[-1]
    (4, ('main.frag', 2), ('lib.glsl', 1), ('main.frag', 4))
    """

    spans: tuple[tuple[str, int, int], ...] = ()

    @classmethod
    def of(cls, spans: Iterable[tuple[str, int, int]]) -> LineMap:
        """The map of these runs, those that continue one another put together."""
        joined: list[tuple[str, int, int]] = []
        for file, line, count in spans:
            if joined and joined[-1][0] == file and sum(joined[-1][1:]) == line:
                joined[-1] = (file, joined[-1][1], joined[-1][2] + count)
            else:
                joined.append((file, line, count))
        return cls(tuple(joined))

    def __len__(self) -> int:
        return sum(count for _, _, count in self.spans)

    @overload
    def __getitem__(self, index: int) -> tuple[str, int]: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[tuple[str, int], ...]: ...
    def __getitem__(self, index: int | slice) -> tuple[str, int] | tuple[tuple[str, int], ...]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        left = index if index >= 0 else index + len(self)
        if left >= 0:
            for file, line, count in self.spans:
                if left < count:
                    return file, line + left
                left -= count
        raise IndexError(f"no line {index} in a text of {len(self)}")

    def with_inserted(self, at: int, count: int, place: tuple[str, int]) -> LineMap:
        """The map of the text with `count` lines put before line index `at`, all from `place`."""
        runs: list[tuple[str, int, int]] = []
        start = 0
        for file, line, length in self.spans:
            before = min(max(at - start, 0), length)
            if before:
                runs.append((file, line, before))
            if start <= at < start + length:
                runs += [(*place, 1)] * count
            if before < length:
                runs.append((file, line + before, length - before))
            start += length
        if at >= start:
            runs += [(*place, 1)] * count
        return LineMap.of(runs)
