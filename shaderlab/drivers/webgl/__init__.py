"""WebGL2 in a headless browser: programs run from ESSL 3.00, which SPIRV-Cross makes of modules.

One browser is started for each device. Calls of WebGL2 are collected in Python and played by a page
of it (`player.js`). Nothing here imports the browser's library before a device is asked for.
"""

from .. import Backend


def open_backend(driver: str) -> Backend:
    """Start a browser and open a device in it; `driver` has one name. Raises DriverError: there is
    no browser, no package that drives it or no SPIRV-Cross, or the browser has no WebGL2 that draws
    to floats."""
    from .device import open_device
    from .session import WebGLBackend

    return WebGLBackend(open_device())


def prepare_process(driver: str) -> None:
    """Do nothing: a browser runs in separate processes."""
