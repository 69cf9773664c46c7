"""An open device of WebGL2: a browser, its context and what that offers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from shaderlab.errors import DriverError, UnsupportedError

from .browser import Browser
from .calls import Calls, Object
from .essl import cross_compiler

_NEEDED = "EXT_color_buffer_float"


@dataclass(frozen=True)
class Device:
    """An open device.

    Attributes:
        gl: its calls.
        info: what the browser says of itself.
        extensions: the names of those that it has, all of them enabled.
        own_programs: the lab's own, which read what can't be read otherwise, by their text.
    """

    gl: Calls
    info: Mapping[str, str]
    extensions: frozenset[str]
    _browser: Browser
    own_programs: dict[str, Object] = field(default_factory=dict, compare=False)

    def require(self, extension: str, what: str) -> None:
        """Raise UnsupportedError where the browser lacks an extension that something takes."""
        if extension not in self.extensions:
            raise UnsupportedError(f"{what}: this browser has no {extension}")

    def samples_offered(self, format: int) -> list[int]:
        """How many samples a pixel of a format may have besides one, fewest first."""
        return sorted(self.gl.ask("samples", format))

    def close(self) -> None:
        """End the browser; nothing that was made on the device may be used any more."""
        self._browser.close()


def open_device() -> Device:
    """Start a browser and open a context in it.

    Raises:
        DriverError: something is not installed, or the browser does not draw to floats.
    """
    cross_compiler()
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
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1)
    gl.pixelStorei(gl.PACK_ALIGNMENT, 1)
    return Device(gl, info, frozenset(about["extensions"]), browser)
