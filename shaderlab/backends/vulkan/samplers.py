"""Samplers: filters, wraps, borders and comparisons. Source: Vulkan 1.3, Samplers."""

from __future__ import annotations

from typing import Any

from shaderlab.backends.vulkan.api import Structs
from shaderlab.backends.vulkan.device import Device
from shaderlab.backends.vulkan.memory import Resources
from shaderlab.errors import UnsupportedError
from shaderlab.model.state import COMPARISONS
from shaderlab.model.textures import WRAPS, Sampling

_NOT_SEAMLESS = 4
_BORDERS = {(0.0, 0.0, 0.0, 0.0): 0, (0.0, 0.0, 0.0, 1.0): 2, (1.0, 1.0, 1.0, 1.0): 4}
_CUSTOM_BORDER = 1000287003
# A texture without mipmaps has no level but the first; up to here its filters are told apart by
# the level of detail, as the specification recommends for OpenGL's two filters without mipmaps.
_ONE_LEVEL = 0.25


def new_sampler(resources: Resources, sampling: Sampling, *, seamless: bool = True) -> Any:
    """A sampler of these filters and wraps.

    Raises:
        UnsupportedError: the device has no such border, or filters every cube across its edges.
    """
    device, structs = resources.device, Structs()
    smaller, larger = sampling.filter
    mipmaps = "mipmap" in smaller
    lod = sampling.lod if mipmaps else tuple(min(max(v, 0.0), _ONE_LEVEL) for v in sampling.lod)
    if not seamless and "nonSeamlessCubeMap" not in device.features:
        raise UnsupportedError("seamless=False: this device has no VK_EXT_non_seamless_cube_map")
    chain, border = {}, _BORDERS.get(sampling.border, 0)
    if "clamp_to_border" in sampling.wrap and sampling.border not in _BORDERS:
        chain, border = {"pNext": _custom_border(device, structs, sampling)}, _CUSTOM_BORDER
    across, up, *along_r = (WRAPS.index(word) for word in sampling.wrap)
    return resources.create("Sampler", structs(
        "SamplerCreateInfo", **chain, flags=0 if seamless else _NOT_SEAMLESS,
        magFilter=larger.startswith("linear"), minFilter=smaller.startswith("linear"),
        mipmapMode=smaller.endswith("mipmap_linear"), addressModeU=across, addressModeV=up,
        addressModeW=(*along_r, up)[0], minLod=lod[0], maxLod=lod[1], borderColor=border,
        compareEnable=sampling.compare is not None,
        compareOp=COMPARISONS.index(sampling.compare or "lequal"),
    ))  # fmt: skip


def _custom_border(device: Device, structs: Structs, sampling: Sampling) -> Any:
    needed = ("customBorderColors", "customBorderColorWithoutFormat")
    if not device.features.issuperset(needed):
        raise UnsupportedError(
            f"a border of {sampling.border}: this device has no VK_EXT_custom_border_color"
        )
    return structs(
        "SamplerCustomBorderColorCreateInfoEXT", customBorderColor={"float32": sampling.border}
    )
