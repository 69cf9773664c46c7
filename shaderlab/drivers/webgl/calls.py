"""Calls of WebGL2, collected and played in order.

Source: Khronos, "WebGL 2.0 Specification".
"""

from __future__ import annotations

import base64
import functools
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shaderlab.errors import DeviceLostError
from shaderlab.model.frame import Array

from .browser import Browser

_ARRAYS = {
    np.dtype(np.uint8): "Uint8Array", np.dtype(np.float16): "Uint16Array",
    np.dtype(np.uint16): "Uint16Array", np.dtype(np.int32): "Int32Array",
    np.dtype(np.uint32): "Uint32Array", np.dtype(np.float32): "Float32Array",
}  # fmt: skip
_ALIGNMENT = 4


@dataclass(frozen=True)
class Object:
    """One of WebGL's objects, by the number that the player knows it by."""

    number: int


class Calls:
    """WebGL2's methods and constants by their names.

    `gl.clear(gl.COLOR_BUFFER_BIT)` is played with the next question. Arguments are numbers, texts,
    lists of them, objects, bytes and arrays.

    Args:
        browser: plays them.
    """

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self._calls: list[tuple[str, int, list[Any]]] = []
        self._data = bytearray()
        self._last = 0
        self._waiting: list[Callable[[Any], object]] = []
        self.about: Mapping[str, Any] = self.ask("about")

    def __getattr__(self, name: str) -> Any:
        if name.isupper():
            return self.about["constants"][name]
        return functools.partial(self._add, name, 0)

    def new(self, name: str, *given: Any) -> Object:
        """The object that a method returns."""
        made = self.number()
        self._add(name, made.number, *given)
        return made

    def number(self) -> Object:
        """A number for an object that a call makes."""
        self._last += 1
        return Object(self._last)

    def ask(self, name: str, *given: Any) -> Any:
        """What a method returns, all calls before it having been played."""
        return self.ask_all([(name, *given)])[0]

    def ask_all(self, questions: Sequence[tuple[Any, ...]]) -> list[Any]:
        """What each of some methods, with its arguments, returns.

        Raises:
            DeviceLostError: the context is lost.
            DriverError: one of the calls can't be made.
        """
        replies: list[Any] = []
        for name, *given in questions:
            self.ask_later(replies.append, name, *given)
        text = json.dumps([self._calls, base64.b64encode(self._data).decode()])
        waiting, self._waiting = self._waiting, []
        self._calls, self._data = [], bytearray()
        answer = json.loads(self._browser.play(text))
        if answer["lost"]:
            raise DeviceLostError("the context of WebGL2 was lost")
        for then, reply in zip(waiting, answer["reply"], strict=True):
            then(reply)
        return replies

    def ask_later(self, then: Callable[[Any], object], name: str, *given: Any) -> None:
        """Have `then` called with what a method returns, once something is asked for. Each question
        takes the way to the browser and back, and a pass may have hundreds of draws."""
        self._add(name, -1, *given)
        self._waiting.append(then)

    def start_afresh(self) -> None:
        """Ignore what is yet to be answered, and errors until here: an exception ended a scene."""
        self._waiting = [_ignore] * len(self._waiting)
        self.ask_later(_ignore, "errors")

    def _add(self, name: str, where: int, *given: Any) -> None:
        self._calls.append((name, where, [self._argument(each) for each in given]))

    def _argument(self, given: Any) -> Any:
        if isinstance(given, Object):
            return {"object": given.number}
        if isinstance(given, bytes):
            given = np.frombuffer(given, np.uint8)
        if not isinstance(given, np.ndarray):
            return given
        at = len(self._data)
        self._data += np.ascontiguousarray(given).tobytes()
        self._data += bytes(-len(self._data) % _ALIGNMENT)
        return {"array": _ARRAYS[given.dtype], "at": at, "count": given.size}


def _ignore(_: object) -> None: ...


def decoded(data: str, kind: Any) -> Array:
    """The numbers of a type that a method of the player returned."""
    return np.frombuffer(base64.b64decode(data), kind).copy()


class Objects:
    """Makes objects, and releases them together. As a context manager it does so in the end."""

    def __init__(self, gl: Calls) -> None:
        self.gl = gl
        self._made: list[tuple[str, Object]] = []

    def new(self, kind: str, *given: Any) -> Object:
        """A new object of a kind such as "Texture"."""
        made = self.gl.new(f"create{kind}", *given)
        self._made.append((kind, made))
        return made

    def release(self) -> None:
        """Release them all."""
        while self._made:
            kind, made = self._made.pop()
            self.gl.release(kind, made.number)

    def __enter__(self) -> Objects:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()
