"""How many functions of a tree of shaders can be called: each is, with ones for all arguments.

    python -m benchmarks.callable [FOLDER]

Prints a line for each file that can't be read and each function that can't be called, with the
reason; functions that neither return nor write to parameters are counted apart.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from shaderlab import CubeTexture, Texture, TextureArray, glsl
from shaderlab.compiler.shader_files import EXTENSIONS
from shaderlab.engine.catalogue import data_folder
from shaderlab.errors import ShaderlabError
from shaderlab.functions.signatures import DTYPES, Type

SUFFIXES = {*EXTENSIONS, ".glsl", ".fsh", ".vsh"}


def ones(kind: Type) -> Any:
    """A value of a type."""
    if kind.dims and (kind.members or kind.opaque):
        return [ones(kind.element)] * kind.dims[0]
    if kind.members:
        return {name: ones(member) for name, member in kind.members}
    return texture(kind.name) if kind.opaque else np.ones(kind.shape, DTYPES.get(kind.kind))


def texture(sampler: str) -> Any:
    """A white texture that a sampler of this type takes."""
    image, options = np.ones((2, 2, 4), np.float32), {"format": "rgba32f"}
    if sampler.endswith("Shadow"):
        image, options = image[..., :1], {"format": "depth32f", "compare": "lequal"}
    elif sampler[0] in "iu":
        integer = {"i": "rgba32i", "u": "rgba32ui"}[sampler[0]]
        options = {"format": integer, "filter": ("nearest", "nearest")}
        image = image.astype({"i": np.int32, "u": np.uint32}[sampler[0]])
    if "Cube" in sampler:
        return CubeTexture(faces=[image] * 6, **options)
    if "Array" in sampler:
        return TextureArray(layers=[image], **options)
    return Texture(image=image, **options)


def main() -> None:
    """Call all, and print what can't be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=data_folder("shaders"))
    folder = parser.parse_args().folder
    counts: Counter[str] = Counter()
    for file in sorted(f for f in folder.rglob("*") if f.suffix in SUFFIXES and f.is_file()):
        try:
            functions = list(glsl.load(file.absolute()))
        except ShaderlabError as error:
            counts["files that can't be read"] += 1
            print(f"{file}: {error.message}")
            continue
        for function in functions:
            for signature in function.signatures:
                if not signature.outputs:
                    counts["without any value"] += 1
                    print(f"{file}: {signature}: gives nothing")
                    continue
                types = ", ".join(str(p.type) for p in signature.parameters)
                inputs = (*signature.given, *signature.globals)
                try:
                    function[types](**{i.name: ones(i.type) for i in inputs})
                except ShaderlabError as error:
                    counts["not callable"] += 1
                    print(f"{file}: {signature}: {error}")
                else:
                    counts["called"] += 1
    print(", ".join(f"{count} {what}" for what, count in counts.items()))


if __name__ == "__main__":
    main()
