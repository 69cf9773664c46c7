"""Recording commands, and what they need until the device has run them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .api import NULL, Structs, check, ffi, lib
from .device import Device

_ONE_TIME = 1
_ALL_STAGES = 0x10000
_ALL_READS_AND_WRITES = 0x18000
_HOST_STAGE, _HOST_READS = 0x4000, 0x2000
_WHOLE = 0xFFFFFFFF
GENERAL = 1
"""The image layout that every image is in from its first use on."""


class Commands:
    """A command buffer that is being recorded.

    Attributes:
        handle: Vulkan's own.
        structs: keeps what commands point to until they have run.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self.structs = Structs()
        made = ffi.new("VkCommandBuffer *")
        info = self.structs(
            "CommandBufferAllocateInfo", commandPool=device.pool, commandBufferCount=1
        )
        check(lib.vkAllocateCommandBuffers(device.handle, info, made), "recording commands")
        self.handle = made[0]
        begin = self.structs("CommandBufferBeginInfo", flags=_ONE_TIME)
        check(lib.vkBeginCommandBuffer(self.handle, begin), "recording commands")

    def barrier(self) -> None:
        """All that was recorded so far is done, and seen, before what comes next; by the host,
        too."""
        memory = self.structs(
            "MemoryBarrier", srcAccessMask=_ALL_READS_AND_WRITES,
            dstAccessMask=_ALL_READS_AND_WRITES | _HOST_READS,
        )  # fmt: skip
        lib.vkCmdPipelineBarrier(
            self.handle, _ALL_STAGES, _ALL_STAGES | _HOST_STAGE, 0, 1, memory, 0, NULL, 0, NULL
        )

    def make_usable(self, image: Any, aspect: int) -> None:
        """Bring a new image into the layout in which it stays."""
        change = self.structs(
            "ImageMemoryBarrier", dstAccessMask=_ALL_READS_AND_WRITES, newLayout=GENERAL,
            srcQueueFamilyIndex=_WHOLE, dstQueueFamilyIndex=_WHOLE, image=image,
            subresourceRange=(aspect, 0, _WHOLE, 0, _WHOLE),
        )  # fmt: skip
        lib.vkCmdPipelineBarrier(
            self.handle, _ALL_STAGES, _ALL_STAGES, 0, 0, NULL, 0, NULL, 1, change
        )

    def run(self) -> None:
        """Have the device run all of it, and wait until it has.

        Raises:
            DeviceLostError, MemoryError, DriverError: it could not.
        """
        device = self.device
        check(lib.vkEndCommandBuffer(self.handle), "recording commands")
        work = self.structs("SubmitInfo", commandBufferCount=1, pCommandBuffers=[self.handle])
        check(lib.vkQueueSubmit(device.queue, 1, work, NULL), "submitting commands")
        check(lib.vkQueueWaitIdle(device.queue), "running commands")

    def release(self) -> None:
        """Free the command buffer."""
        own = self.structs.array("VkCommandBuffer", [self.handle])
        lib.vkFreeCommandBuffers(self.device.handle, self.device.pool, 1, own)


@contextmanager
def recording(device: Device) -> Iterator[Commands]:
    """Commands that are run at the end, unless something was raised meanwhile."""
    commands = Commands(device)
    try:
        yield commands
        commands.run()
    finally:
        commands.release()
