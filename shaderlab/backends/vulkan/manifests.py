"""Where software Vulkan drivers keep their manifests, the files by which the loader finds them.

Source: Khronos, "Vulkan Loader Interface", driver discovery on Linux.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from shaderlab.errors import DriverError

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
_ELSEWHERE = (
    "/etc/vulkan/icd.d", "/usr/share/vulkan/icd.d", "/usr/lib/chromium", "/usr/lib64/chromium",
    "/usr/lib64/chromium-browser", "/opt/google/chrome",
)  # fmt: skip
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def manifest_of(driver: str) -> Path | None:
    """The manifest of a software driver; None for "vulkan", whose drivers the loader finds.

    Raises:
        DriverError: the driver is not installed; says how to get it.
    """
    if driver not in _NAMES:
        return None
    for folder in _folders():
        for found in sorted(folder.glob(_NAMES[driver])):
            return found
    raise DriverError(f"no manifest of the Vulkan driver {driver}", remedy=_INSTALL[driver])


def _folders() -> Iterator[Path]:
    """Where drivers are registered, and then where browsers that bring one are."""
    data = os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"
    config = os.environ.get("XDG_CONFIG_DIRS") or "/etc/xdg"
    for parent in (*config.split(":"), *data.split(":")):
        yield Path(parent) / "vulkan" / "icd.d"
    for name in _BROWSERS:
        command = shutil.which(name)
        if command is not None:
            yield Path(command).resolve().parent
    yield from map(Path, _ELSEWHERE)
