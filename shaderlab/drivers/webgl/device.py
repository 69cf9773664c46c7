"""Calls of WebGL2, collected and played in order.

Source: Khronos, "WebGL 2.0 Specification".
"""

import base64
import functools
import json
import os
import resource
import shutil
import subprocess
import threading
from collections.abc import Callable, Container, Coroutine, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from importlib import import_module
from importlib.resources import files
from typing import Any, TypeVar

import numpy as np

from shaderlab.errors import DeviceLostError, DriverError, UnsupportedError
from shaderlab.model.frame import Array

ARRAYS = {
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
    """WebGL2's methods and constants by their names, played by a browser.

    `gl.clear(gl.COLOR_BUFFER_BIT)` is played with the next question. Arguments are numbers, texts,
    lists of them, objects, bytes and arrays.
    """

    def __init__(self, browser: "Browser") -> None:
        self._browser = browser
        self._calls: list[tuple[str, int, list[Any]]] = []
        self._data = bytearray()
        self._last = 0
        self._waiting: list[Callable[[Any], object]] = []
        self.about: Mapping[str, Any] = self.ask("about")

    def __getattr__(self, name: str) -> Any:
        if name.isupper():
            return self.about["constants"][name]
        return functools.partial(self.add, name, 0)

    def make(self, name: str, *given: Any) -> None:
        """Make a call that `drivers.gl_state` describes."""
        words = (getattr(self, g.upper()) if isinstance(g, str) else g for g in given)
        self.add(name[0].lower() + name[1:], 0, *words)

    def new(self, name: str, *given: Any) -> Object:
        """Return the object that a method returns."""
        made = self.number()
        self.add(name, made.number, *given)
        return made

    def number(self) -> Object:
        """Return a number for an object that a call makes."""
        self._last += 1
        return Object(self._last)

    def ask(self, name: str, *given: Any) -> Any:
        """Return what a method returns, all calls before it having been played."""
        return self.ask_all([(name, *given)])[0]

    def ask_all(self, questions: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Return what each of some methods, with its arguments, returns. Raises DeviceLostError:
        the context is lost; DriverError: one of the calls can't be made."""
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
        """Call `then` with what a method returns when the next `ask` gets its reply: each `ask` is
        a round trip to the browser, and a pass may have hundreds of draws."""
        self.add(name, -1, *given)
        self._waiting.append(then)

    def start_afresh(self) -> None:
        """Ignore what is yet to be answered, and errors until here: an exception ended a scene."""
        self._waiting = [_ignore] * len(self._waiting)
        self.ask_later(_ignore, "errors")

    def add(self, name: str, where: int, *given: Any) -> None:
        self._calls.append((name, where, [self._argument(each) for each in given]))

    def _argument(self, given: Any) -> Any:
        if isinstance(given, Object):
            return {"object": given.number}
        if isinstance(given, bytes):
            given = np.frombuffer(given, np.uint8)
        if not isinstance(given, np.ndarray):
            return given
        at = self._store(np.ascontiguousarray(given).tobytes())
        return {"array": ARRAYS[given.dtype], "at": at, "count": given.size}

    def _store(self, values: bytes) -> int:
        """Return where bytes stand in the data from now on."""
        at = len(self._data)
        self._data += values + bytes(-len(values) % _ALIGNMENT)
        return at


def _ignore(_: object) -> None: ...


def decode(data: str, kind: Any) -> Array:
    """Return the numbers of a type that a method of the player returned."""
    return np.frombuffer(base64.b64decode(data), kind).copy()


class Objects(ExitStack):
    """Makes objects, which `close` releases together, as does the end of a `with`."""

    def __init__(self, gl: Calls) -> None:
        super().__init__()
        self.gl = gl

    def new(self, kind: str, *given: Any) -> Object:
        """Make a new object of a kind such as "Texture"."""
        made = self.gl.new(f"create{kind}", *given)
        self.callback(self.gl.release, kind, made.number)
        return made


PATIENCE = 60.0
"""Seconds that the browser has for an answer."""
_NAMES = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome")
_FLAGS = (
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
_INSTALL = (
    "SHADERLAB_CHROMIUM=… · Debian: apt-get install chromium · Fedora: dnf install chromium · "
    "Arch: pacman -S chromium"
)
Result = TypeVar("Result")


class Browser:
    """A running browser. Raises DriverError: there is none, or it has no WebGL2."""

    def __init__(self) -> None:
        try:
            self._api = import_module("playwright.async_api")
        except ImportError as error:
            raise DriverError(
                f"no package that drives a browser ({error})",
                remedy="pip install 'shaderlab[webgl]'",
            ) from error
        import asyncio  # takes as long as all else here, and recorders of calls need none

        self._path = _find_chromium()
        # In a separate thread: the caller may run an event loop itself, as a notebook does.
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        try:
            with _lift_memory_limit():
                self._wait(self._start())
        except BaseException:
            self.close()
            raise

    _playwright: Any = None
    _browser: Any = None
    _guard: subprocess.Popen[bytes] | None = None

    def play(self, text: str) -> str:
        """Return what the player answers. Raises DeviceLostError: the browser is gone, or gives no
        answer in time; DriverError: a call can't be made."""
        return str(self._wait(self._page.evaluate("text => player.play(text)", text)))

    def close(self) -> None:
        """End the browser, whatever state it is in."""
        with suppress(Exception):
            if self._browser is not None:
                self._run(self._browser.close(), 5.0)
        with suppress(Exception):
            if self._playwright is not None:
                self._run(self._playwright.stop(), 5.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        if self._guard is not None:
            assert self._guard.stdin is not None
            self._guard.stdin.close()
            self._guard.wait()

    async def _start(self) -> None:
        try:
            self._playwright = await self._api.async_playwright().start()
        except Exception as error:  # of no class of its own
            raise DriverError(f"Playwright does not start: {error}") from error
        # Where a screen is named that is not there, Chromium has no WebGL2.
        env = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        self._browser = await self._playwright.chromium.launch(
            executable_path=self._path, args=_FLAGS, env=env
        )
        session = await self._browser.new_browser_cdp_session()
        running = (await session.send("SystemInfo.getProcessInfo"))["processInfo"]
        self._guard = _start_guard(next(one["id"] for one in running if one["type"] == "browser"))
        self._page = await self._browser.new_page()
        player = files(__package__).joinpath("player.js").read_text(encoding="utf-8")
        await self._page.evaluate(f"{player}\nwindow.player = makePlayer();")
        if not await self._page.evaluate("player !== null && 'fromBase64' in Uint8Array"):
            raise DriverError(
                f"{self._path} has no WebGL2, or is older than version 140", remedy=_INSTALL
            )

    def _run(self, work: Coroutine[Any, Any, Result], seconds: float) -> Result:
        from asyncio import run_coroutine_threadsafe, wait_for

        return run_coroutine_threadsafe(wait_for(work, seconds), self._loop).result()

    def _wait(self, work: Coroutine[Any, Any, Result]) -> Result:
        try:
            return self._run(work, PATIENCE)
        except TimeoutError:
            raise DeviceLostError(f"the browser gave no answer in {PATIENCE:g} s") from None
        except self._api.Error as error:
            if self._browser is not None and self._browser.is_connected():
                if "crashed" not in error.message and "closed" not in error.message:
                    raise DriverError(
                        f"the browser: {error.message.partition(chr(10))[0]}"
                    ) from error
            elif self._browser is None:
                raise DriverError(
                    f"{self._path} does not start: {error.message.partition(chr(10))[0]}"
                ) from error
            raise DeviceLostError("the browser is gone") from error


def _start_guard(browser: int) -> subprocess.Popen[bytes]:
    """Return a process that kills a browser and its processes, which are a group of their own, when
    this one lets go of it or is gone. A shader that does not end would outlive both."""
    command = ("sh", "-c", 'read -r _; kill -9 "-$0" 2>/dev/null', str(browser))
    return subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)


def _find_chromium() -> str:
    """Return the browser's command. Raises DriverError if there is none."""
    found = os.environ.get("SHADERLAB_CHROMIUM") or next(
        filter(None, map(shutil.which, _NAMES)), None
    )
    if found is None:
        raise DriverError("no Chromium, which this driver draws in", remedy=_INSTALL)
    return found


@contextmanager
def _lift_memory_limit() -> Iterator[None]:
    """Processes that are started meanwhile may reserve what they like, which is more than all
    memory; a worker's own limit is a soft one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def find_cross_compiler() -> str:
    """Return the command of SPIRV-Cross. Raises DriverError if it is not there."""
    found = shutil.which("spirv-cross")
    if found is None:
        raise DriverError(
            "no spirv-cross, which makes ESSL of modules",
            remedy="Debian/Ubuntu: apt-get install spirv-cross · Fedora: dnf install spirv-tools · "
            "Arch: pacman -S spirv-cross",
        )
    return found


_NEEDED = "EXT_color_buffer_float"


@dataclass(frozen=True)
class Device:
    """An open device: `extensions` are the names of those that it has, all of them enabled,
    `own_programs` the lab's own, which read what can't be read otherwise, by their text."""

    gl: Calls
    info: Mapping[str, str]
    extensions: Container[str]
    _browser: "Browser | None"
    own_programs: dict[str, Object] = field(default_factory=dict, compare=False)

    def require(self, extension: str, what: str) -> None:
        """Raise UnsupportedError where the browser lacks an extension that something takes."""
        if extension not in self.extensions:
            raise UnsupportedError(f"{what}: this browser has no {extension}")

    def close(self) -> None:
        """End the browser; nothing that was made on the device may be used any more."""
        if self._browser is not None:
            self._browser.close()


def open_device() -> Device:
    """Start a browser and open a context in it. Raises DriverError: something is not installed, or
    the browser does not draw to floats."""
    find_cross_compiler()
    browser = Browser()
    try:
        gl = Calls(browser)
    except BaseException:
        browser.close()
        raise
    about = gl.about
    info = {
        "renderer": f"webgl2: {about['renderer']}",
        "vendor": about["vendor"],
        "version": about["version"],
        "glsl": about["glsl"],
        "max_texture_size": str(about["texture"]),
    }
    if _NEEDED not in about["extensions"]:
        browser.close()
        raise DriverError(f"{about['renderer']} lacks {_NEEDED}, by which WebGL2 draws to floats")
    return Device(gl, info, frozenset(about["extensions"]), browser)
