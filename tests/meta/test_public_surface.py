"""The names that a case file may rely on. A change here is a change of the public interface."""

from __future__ import annotations

import importlib.metadata
import re

import shaderlab

PUBLIC = {
    # a case and what it is made of
    "Case", "Variant", "Erratum", "Pass", "Draw", "Target", "Mesh", "Texture", "Output",
    "TextureArray", "Texture3D", "CubeTexture", "CompressedTexture",
    "UniformBuffer",
    "State", "Depth", "Stencil", "Blend", "Cell",
    "fullscreen", "mesh_pass", "compute", "Ramp", "across", "up",
    # what must hold
    "formula", "value", "sweep", "boundaries", "exact", "coverage", "computed", "compile_fails",
    "gl_error", "gl_call", "gl_calls", "query", "cost", "attribute_layout", "block_layout",
    "refused", "inactive_uniforms",
    "monotone", "bounded", "even", "odd", "symmetric",
    "measure", "reading", "any_order", "both_ways",
    "Pixel", "Rules",
    # the rest
    "ShaderlabError", "__version__",
}  # fmt: skip


def test_exactly_these_names_are_public() -> None:
    assert {*shaderlab.__all__, "__version__"} == PUBLIC
    assert len(shaderlab.__all__) == len(PUBLIC) - 1


def test_every_public_name_is_there_and_explains_itself() -> None:
    for name in PUBLIC - {"__version__"}:
        assert (getattr(shaderlab, name).__doc__ or "").strip(), f"{name} has no docstring"


def test_nothing_else_looks_public() -> None:
    """Only submodules, which importing makes visible, may be there besides."""
    import types

    others = {
        name
        for name, value in vars(shaderlab).items()
        if not name.startswith("_") and not isinstance(value, types.ModuleType)
    }
    assert others <= PUBLIC


def test_version_is_the_installed_one() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", shaderlab.__version__)
    assert importlib.metadata.version("shaderlab") == shaderlab.__version__
