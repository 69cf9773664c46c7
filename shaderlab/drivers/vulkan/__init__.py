"""Vulkan, without a screen: programs run from the SPIR-V modules that the compilers make.

The loader reads from the environment where a driver's manifest is. It is changed only while an
instance is made, and put back; a process that is the lab's alone is prepared for good. Nothing here
imports a graphics API before a device is asked for.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path

from shaderlab.errors import DriverError

from .. import Backend, mesa_variables, set_variables

# The second name is what loaders before 1.3.207 read.
_VARIABLES = ("VK_DRIVER_FILES", "VK_ICD_FILENAMES")


def open_backend(driver: str) -> Backend:
    """Open a Vulkan device. Raises DriverError: the package or the driver is not installed, or the
    device lacks what the lab needs."""
    from .device import open_device
    from .session import VulkanBackend

    return VulkanBackend(open_device(driver))


def prepare_process(driver: str) -> None:
    """Have the loader find this driver alone, for good; opening a device tells if it is there."""
    try:
        os.environ.update(_variables(driver))
    except DriverError:
        return


def environment(driver: str) -> AbstractContextManager[None]:
    """Set the environment in which the loader finds this driver, for a while. Raises DriverError:
    the driver is not installed."""
    return set_variables(_variables(driver))


def _variables(driver: str) -> dict[str, str]:
    manifest = manifest_of(driver)
    found = {} if manifest is None else dict.fromkeys(_VARIABLES, str(manifest))
    return found | mesa_variables()


_NAMES = {"lavapipe": "lvp_icd*.json", "swiftshader": "vk_swiftshader_icd.json"}
_INSTALL = {
    "lavapipe": (
        "Debian/Ubuntu: apt-get install mesa-vulkan-drivers · Fedora: dnf install "
        "mesa-vulkan-drivers · Arch: pacman -S vulkan-swrast"
    ),
    "swiftshader": (
        "it comes with Chromium: Debian: apt-get install chromium · Fedora: dnf install chromium "
        "· Arch: pacman -S chromium"
    ),
}
MANIFEST_FOLDERS = (
    "/etc/vulkan/icd.d", "/usr/share/vulkan/icd.d", "/usr/lib/chromium", "/usr/lib64/chromium",
    "/usr/lib64/chromium-browser", "/opt/google/chrome",
)  # fmt: skip
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def manifest_of(driver: str) -> Path | None:
    """Return the manifest of a software driver; None for "vulkan", whose drivers the loader finds.
    Raises DriverError: the driver is not installed."""
    if driver not in _NAMES:
        return None
    for folder in _folders():
        for found in sorted(folder.glob(_NAMES[driver])):
            return found
    raise DriverError(f"no manifest of the Vulkan driver {driver}", remedy=_INSTALL[driver])


def _folders() -> Iterator[Path]:
    """Yield where drivers are registered, and then where browsers that bring one are."""
    data = os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    config = os.environ.get("XDG_CONFIG_DIRS") or "/etc/xdg"
    for parent in (*config.split(":"), *data.split(":")):
        yield Path(parent) / "vulkan" / "icd.d"
    for name in _BROWSERS:
        command = shutil.which(name)
        if command is not None:
            yield Path(command).resolve().parent
    yield from map(Path, MANIFEST_FOLDERS)
