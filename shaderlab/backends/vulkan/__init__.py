"""Vulkan, without a screen: programs run from the SPIR-V modules that the compilers make.

The loader reads from the environment where a driver's manifest is. It is changed only while an
instance is made, and put back; a process that is the lab's alone is prepared for good. Nothing here
imports a graphics API before a device is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from shaderlab.backends.variables import mesa_variables, variables_set
from shaderlab.backends.vulkan.manifests import manifest_of
from shaderlab.errors import DriverError

if TYPE_CHECKING:
    from shaderlab.backends.vulkan.backend import VulkanBackend

# The second name is what loaders before 1.3.207 read.
_VARIABLES = ("VK_DRIVER_FILES", "VK_ICD_FILENAMES")


def open_backend(driver: str) -> VulkanBackend:
    """Open a Vulkan device.

    Raises:
        DriverError: the package or the driver is not installed, or the device lacks what the lab
            needs.
    """
    from shaderlab.backends.vulkan.backend import VulkanBackend
    from shaderlab.backends.vulkan.device import open_device

    return VulkanBackend(open_device(driver))


def prepare_process(driver: str) -> None:
    """Have the loader find this driver alone, for good; a driver that is not there is reported when
    a device is opened."""
    try:
        os.environ.update(_variables(driver))
    except DriverError:
        return


@contextmanager
def environment(driver: str) -> Iterator[None]:
    """The environment in which the loader finds this driver, for a while.

    Raises:
        DriverError: the driver is not installed; says how to get it.
    """
    wanted = _variables(driver)
    with variables_set(wanted):
        yield


def _variables(driver: str) -> dict[str, str]:
    manifest = manifest_of(driver)
    found = {} if manifest is None else dict.fromkeys(_VARIABLES, str(manifest))
    return found | mesa_variables()
