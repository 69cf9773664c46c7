"""Vulkan as the package `vulkan` declares it: its functions, a device, memory and commands.

Source: Khronos, Vulkan 1.3 Specification.
"""

import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from shaderlab.errors import DeviceLostError, DriverError
from shaderlab.model.frame import Array

from . import environment

try:
    import vulkan
except (ImportError, OSError) as error:  # OSError: there is no loader
    raise DriverError(
        f"no Vulkan loader, or not the package for it ({error})",
        remedy="pip install 'shaderlab[vulkan]' · Debian/Ubuntu: apt-get install libvulkan1",
    ) from error

ffi: Any = vulkan.ffi
lib: Any = vulkan.lib
NULL = ffi.NULL


def constant(name: str) -> int:
    """Return a constant by its name without "VK_"."""
    return int(getattr(vulkan, f"VK_{name}"))


def check(result: int, what: str) -> None:
    """Raise DeviceLostError, MemoryError, or for any other error of a result DriverError."""
    if result >= 0:
        return
    if result == constant("ERROR_DEVICE_LOST"):
        raise DeviceLostError(f"the device was lost: {what}")
    if result in map(constant, ("ERROR_OUT_OF_HOST_MEMORY", "ERROR_OUT_OF_DEVICE_MEMORY")):
        raise MemoryError(f"{what}: the driver ran out of memory")
    error = vulkan.exception_codes.get(result)
    name = error.__name__ if error is not None else f"VkResult {result}"
    raise DriverError(f"{what}: {name}")


class Structs:
    """Makes structures, and keeps all that they point to as long as it is there itself.

    `structs("Viewport", width=8.0)` is a pointer to a new VkViewport, its sType set. A list or an
    array for a pointer becomes a C array, a text a C string, and a pointer to a structure is copied
    where a structure is wanted.
    """

    def __init__(self) -> None:
        self._kept: list[Any] = []

    def __call__(self, name: str, **fields: Any) -> Any:
        made = ffi.new(f"Vk{name} *")
        types = _fields(name)
        if "sType" in types:
            made.sType = _structure_type(name)
        for name_, value in fields.items():
            setattr(made, name_, self._value(types[name_], value))
        self._kept.append(made)
        return made

    def array(self, kind: str, values: Sequence[Any]) -> Any:
        """Return a C array, such as `array("VkBuffer", [a, b])`; NULL for no values."""
        return self._value(ffi.typeof(f"{kind} *"), list(values))

    def _value(self, kind: Any, value: Any) -> Any:
        if kind.kind == "pointer":
            return ffi.cast(kind, self._pointer(kind, value))
        if kind.kind in ("struct", "union") and isinstance(value, ffi.CData):
            return value[0] if ffi.typeof(value).kind == "pointer" else value
        return value

    def _pointer(self, kind: Any, value: Any) -> Any:
        if isinstance(value, str):
            value = ffi.new("char[]", value.encode())
        elif isinstance(value, list | tuple):
            items = [self._value(kind.item, item) for item in value]
            value = ffi.new(f"{kind.item.cname}[]", items) if items else NULL
        elif isinstance(value, np.ndarray | bytes):
            value = ffi.from_buffer(value)
        self._kept.append(value)
        return value


@functools.cache
def _fields(name: str) -> dict[str, Any]:
    return {field: known.type for field, known in ffi.typeof(f"Vk{name}").fields}


@functools.cache
def _structure_type(name: str) -> int:
    words = re.sub(r"(?<=[a-z])(?=[A-Z0-9])|(?<=\d)(?=[A-Z][a-z])", "_", name)
    return constant(f"STRUCTURE_TYPE_{words.upper()}")


REQUIRED_VERSION = (1, 3)
# What the lab can't do without, so that a shader means what it means in OpenGL: the clip volume,
# and the vertex that a flat value comes from. By extension: its structure of features, those used.
_NEEDED = {
    "VK_EXT_depth_clip_control": ("DepthClipControlFeaturesEXT", ("depthClipControl",)),
    "VK_EXT_provoking_vertex": ("ProvokingVertexFeaturesEXT", ("provokingVertexLast",)),
}
_USED = {
    "VK_EXT_line_rasterization": ("LineRasterizationFeaturesEXT", ("bresenhamLines",)),
    "VK_EXT_custom_border_color": (
        "CustomBorderColorFeaturesEXT", ("customBorderColors", "customBorderColorWithoutFormat"),
    ),
    "VK_EXT_non_seamless_cube_map": ("NonSeamlessCubeMapFeaturesEXT", ("nonSeamlessCubeMap",)),
    # The next one is no extension without it.
    "VK_EXT_transform_feedback": ("TransformFeedbackFeaturesEXT", ("transformFeedback",)),
    "VK_EXT_primitives_generated_query": (
        "PrimitivesGeneratedQueryFeaturesEXT", ("primitivesGeneratedQuery",),
    ),
}  # fmt: skip
_CORE = {"DynamicRenderingFeatures": ("dynamicRendering",)}
# Slower, and of no use to shaders that stay inside of their arrays.
_UNWANTED = ("robustBufferAccess",)
# The machine's own device is the most capable one: VkPhysicalDeviceType, best first.
_PREFERRED = [
    constant(f"PHYSICAL_DEVICE_TYPE_{kind}")
    for kind in ("DISCRETE_GPU", "INTEGRATED_GPU", "VIRTUAL_GPU", "CPU", "OTHER")
]


@dataclass(frozen=True)
class Device:
    """An open device.

    Attributes:
        driver: a name of `shaderlab.drivers.DRIVERS`.
        features: the names of the features that it has, all of them enabled.
        memory_types: each memory type's VkMemoryPropertyFlags.
        instance, physical, handle, queue, pool: Vulkan's own handles.
    """

    driver: str
    info: Mapping[str, str]
    features: frozenset[str]
    limits: Any
    memory_types: tuple[int, ...]
    instance: Any
    physical: Any
    handle: Any
    queue: Any
    pool: Any
    _structs: Structs = field(repr=False, compare=False)

    def destroy(self, kind: str, handle: Any) -> None:
        """Destroy an object of a kind such as "Buffer"."""
        getattr(lib, f"vkDestroy{kind}")(self.handle, handle, NULL)

    def close(self) -> None:
        """Release the device; nothing that was made on it may be used any more."""
        lib.vkDeviceWaitIdle(self.handle)
        self.destroy("CommandPool", self.pool)
        lib.vkDestroyDevice(self.handle, NULL)
        lib.vkDestroyInstance(self.instance, NULL)


def open_device(driver: str) -> Device:
    """Open a device of "lavapipe", "swiftshader", or "vulkan", the machine's own. Raises
    DriverError: the driver is not there, or lacks what the lab can't do without."""
    structs = Structs()
    with environment(driver):
        version = REQUIRED_VERSION[0] << 22 | REQUIRED_VERSION[1] << 12
        about = structs("ApplicationInfo", pApplicationName="shaderlab", apiVersion=version)
        info = structs("InstanceCreateInfo", pApplicationInfo=about)
        instance = _create_object("vkCreateInstance", "VkInstance", None, info)
    try:
        return _make_device(driver, instance, structs)
    except BaseException:
        lib.vkDestroyInstance(instance, NULL)
        raise


def _make_device(driver: str, instance: Any, structs: Structs) -> Device:
    physical, about = _choose_physical(driver, instance), structs("PhysicalDeviceDriverProperties")
    found = structs("PhysicalDeviceProperties2", pNext=about)
    lib.vkGetPhysicalDeviceProperties2(physical, found)
    properties = found.properties
    name = ffi.string(properties.deviceName).decode()
    version = (properties.apiVersion >> 22 & 127, properties.apiVersion >> 12 & 1023)
    if version < REQUIRED_VERSION:
        raise DriverError(f"{name} has Vulkan {version[0]}.{version[1]}; the lab needs 1.3")
    listed = vulkan.vkEnumerateDeviceExtensionProperties(physical, None)
    extensions = {extension.extensionName for extension in listed}
    for wanted in _NEEDED:
        if wanted not in extensions:
            raise DriverError(f"{name} lacks {wanted}, by which Vulkan draws as OpenGL does")
    used = [wanted for wanted in (*_NEEDED, *_USED) if wanted in extensions]
    chain, chained = _chain_features(used, structs)
    core = structs("PhysicalDeviceFeatures2", pNext=chain)
    lib.vkGetPhysicalDeviceFeatures2(physical, core)
    for unwanted in _UNWANTED:
        setattr(core.features, unwanted, 0)
    groups = [core.features, *(one[0] for one in chained)]
    features = frozenset(word for group in groups for word in _list_enabled(group))
    for group in (*(words for _, words in _NEEDED.values()), *_CORE.values()):
        for word in group:
            if word not in features:
                raise DriverError(f"{name} lacks the feature {word}")
    family = _find_graphics_family(physical, name)
    queue_info = structs(
        "DeviceQueueCreateInfo", queueFamilyIndex=family, queueCount=1, pQueuePriorities=[1.0]
    )
    device = _create_object("vkCreateDevice", "VkDevice", physical, structs(
        "DeviceCreateInfo", pNext=core, queueCreateInfoCount=1, pQueueCreateInfos=[queue_info],
        enabledExtensionCount=len(used), ppEnabledExtensionNames=used,
    ))  # fmt: skip
    queue = vulkan.vkGetDeviceQueue(device, family, 0)
    pool_info = structs("CommandPoolCreateInfo", queueFamilyIndex=family)
    pool = _create_object("vkCreateCommandPool", "VkCommandPool", device, pool_info)
    memory = vulkan.vkGetPhysicalDeviceMemoryProperties(physical)
    kinds = [memory.memoryTypes[k].propertyFlags for k in range(memory.memoryTypeCount)]
    said = ffi.string(about.driverInfo).decode()
    spelt = ".".join(map(str, (*version, properties.apiVersion & 4095)))
    info = {
        "renderer": name if driver in name.lower() else f"{driver}: {name}",
        "vendor": ffi.string(about.driverName).decode(),
        "version": f"Vulkan {spelt}" + (f", {said}" if said else ""),
        "glsl": "4.60",
        "max_texture_size": str(properties.limits.maxImageDimension2D),
        "max_samples": str(max(list_sample_counts(properties.limits))),
    }
    handles = (instance, physical, device, queue, pool)
    return Device(driver, info, features, properties.limits, tuple(kinds), *handles, structs)


def list_sample_counts(limits: Any) -> list[int]:
    """Return how many samples a pixel may have, in colours and depth alike."""
    both = limits.framebufferColorSampleCounts & limits.framebufferDepthSampleCounts
    return [count for count in (1, 2, 4, 8, 16, 32, 64) if both & count]


def _choose_physical(driver: str, instance: Any) -> Any:
    count = ffi.new("uint32_t *")
    check(lib.vkEnumeratePhysicalDevices(instance, count, NULL), "listing devices")
    found = ffi.new("VkPhysicalDevice[]", count[0])
    check(lib.vkEnumeratePhysicalDevices(instance, count, found), "listing devices")
    if not count[0]:
        raise DriverError(f"the Vulkan driver {driver} has no device")

    def order(physical: Any) -> int:
        return _PREFERRED.index(vulkan.vkGetPhysicalDeviceProperties(physical).deviceType)

    return min(list(found)[: count[0]], key=order)


def _chain_features(used: list[str], structs: Structs) -> tuple[Any, list[Any]]:
    """Return the structures of features beside the core's: the first of the chain, and all."""
    made = [NULL]
    for name in (*_CORE, *({**_NEEDED, **_USED}[extension][0] for extension in used)):
        made.append(structs(f"PhysicalDevice{name}", pNext=made[-1]))
    return made[-1], made[1:]


def _list_enabled(group: Any) -> list[str]:
    """Return the features of a structure that are there."""
    known = [word for word, kind in ffi.typeof(group).fields if kind.type.cname == "uint32_t"]
    return [word for word in known if getattr(group, word)]


def _find_graphics_family(physical: Any, name: str) -> int:
    for number, family in enumerate(vulkan.vkGetPhysicalDeviceQueueFamilyProperties(physical)):
        if family.queueFlags & constant("QUEUE_GRAPHICS_BIT"):
            return number
    raise DriverError(f"{name} does not draw: it has no queue for graphics")


def _create_object(function: str, kind: str, owner: Any, info: Any) -> Any:
    made = ffi.new(f"{kind} *")
    before = () if owner is None else (owner,)
    check(getattr(lib, function)(*before, info, NULL, made), function)
    return made[0]


# Visible to this process, without flushing.
_HOST = constant("MEMORY_PROPERTY_HOST_VISIBLE_BIT") | constant("MEMORY_PROPERTY_HOST_COHERENT_BIT")
_CACHED = constant("MEMORY_PROPERTY_HOST_CACHED_BIT")
_DEVICE_LOCAL = constant("MEMORY_PROPERTY_DEVICE_LOCAL_BIT")


@dataclass(frozen=True)
class Buffer:
    """A buffer, mapped: `bytes` are its contents, which can be read and written."""

    handle: Any
    bytes: Array


class Resources(ExitStack):
    """Makes objects on the device; `close` releases all of them, the last one first, as does the
    end of a `with`. The device must be done with them."""

    def __init__(self, device: Device) -> None:
        super().__init__()
        self.device = device

    def create(self, kind: str, info: Any) -> Any:
        """Make a new object, such as `create("Sampler", info)`."""
        made = _create_object(f"vkCreate{kind}", f"Vk{kind}", self.device.handle, info)
        return self.own(kind, made)

    def own(self, kind: str, handle: Any) -> Any:
        """Release this object, too, in the end."""
        self.callback(self.device.destroy, kind, handle)
        return handle

    def buffer(self, usage: str, data: bytes | Array | None = None, *, size: int = 0) -> Buffer:
        """Return a buffer of `size` zeros, or of `data`, for a usage such as "uniform_buffer"."""
        given = np.frombuffer(b"" if data is None else data, np.uint8)
        length = max(size, given.nbytes, 16)
        structs = Structs()
        bits = constant(f"BUFFER_USAGE_{usage.upper()}_BIT")
        handle = self.create("Buffer", structs("BufferCreateInfo", size=length, usage=bits))
        needs = vulkan.vkGetBufferMemoryRequirements(self.device.handle, handle)
        memory = self._allocate(needs, _HOST, _CACHED)
        check(lib.vkBindBufferMemory(self.device.handle, handle, memory, 0), "binding a buffer")
        at = ffi.new("void **")
        check(lib.vkMapMemory(self.device.handle, memory, 0, length, 0, at), "mapping a buffer")
        contents = np.frombuffer(ffi.buffer(at[0], length), np.uint8)
        contents[: given.nbytes] = given
        contents[given.nbytes :] = 0
        return Buffer(handle, contents)

    def bind_image_memory(self, image: Any) -> None:
        needs = vulkan.vkGetImageMemoryRequirements(self.device.handle, image)
        memory = self._allocate(needs, 0, _DEVICE_LOCAL)
        check(lib.vkBindImageMemory(self.device.handle, image, memory, 0), "binding an image")

    def _allocate(self, needs: Any, required: int, preferred: int) -> Any:
        kinds = enumerate(self.device.memory_types)
        usable = [(number, flags) for number, flags in kinds if needs.memoryTypeBits >> number & 1]
        fitting = [kind for kind in usable if kind[1] & required == required]
        number = max(fitting, key=lambda kind: bool(kind[1] & preferred))[0]
        info = Structs()("MemoryAllocateInfo", allocationSize=needs.size, memoryTypeIndex=number)
        made = ffi.new("VkDeviceMemory *")
        what = f"allocating {needs.size} bytes"
        check(lib.vkAllocateMemory(self.device.handle, info, NULL, made), what)
        self.callback(lib.vkFreeMemory, self.device.handle, made[0], NULL)
        return made[0]


_ONE_TIME = constant("COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT")
_ALL_STAGES = constant("PIPELINE_STAGE_ALL_COMMANDS_BIT")
_ALL_READS_AND_WRITES = constant("ACCESS_MEMORY_READ_BIT") | constant("ACCESS_MEMORY_WRITE_BIT")
_HOST_STAGE = constant("PIPELINE_STAGE_HOST_BIT")
_HOST_READS = constant("ACCESS_HOST_READ_BIT")
_REMAINING = constant("REMAINING_MIP_LEVELS")  # array layers have the same number
_SAME_FAMILY = constant("QUEUE_FAMILY_IGNORED")
GENERAL = constant("IMAGE_LAYOUT_GENERAL")
"""The image layout that every image is in from its first use on."""


class Commands:
    """A command buffer that is being recorded: `handle` is Vulkan's own, `structs` keeps what
    commands point to until they have run."""

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
        """Finish all that was recorded before what comes next and before the host reads."""
        before, after = _ALL_READS_AND_WRITES, _ALL_READS_AND_WRITES | _HOST_READS
        memory = self.structs("MemoryBarrier", srcAccessMask=before, dstAccessMask=after)
        lib.vkCmdPipelineBarrier(
            self.handle, _ALL_STAGES, _ALL_STAGES | _HOST_STAGE, 0, 1, memory, 0, NULL, 0, NULL
        )

    def make_usable(self, image: Any, aspect: int) -> None:
        """Bring a new image into the layout in which it stays."""
        change = self.structs(
            "ImageMemoryBarrier",
            dstAccessMask=_ALL_READS_AND_WRITES,
            newLayout=GENERAL,
            srcQueueFamilyIndex=_SAME_FAMILY,
            dstQueueFamilyIndex=_SAME_FAMILY,
            image=image,
            subresourceRange=(aspect, 0, _REMAINING, 0, _REMAINING),
        )
        lib.vkCmdPipelineBarrier(
            self.handle, _ALL_STAGES, _ALL_STAGES, 0, 0, NULL, 0, NULL, 1, change
        )

    def run(self) -> None:
        """Have the device run all of it, and wait until it has. Raises as `check` does."""
        device = self.device
        check(lib.vkEndCommandBuffer(self.handle), "recording commands")
        work = self.structs("SubmitInfo", commandBufferCount=1, pCommandBuffers=[self.handle])
        check(lib.vkQueueSubmit(device.queue, 1, work, NULL), "submitting commands")
        check(lib.vkQueueWaitIdle(device.queue), "running commands")

    def release(self) -> None:
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
