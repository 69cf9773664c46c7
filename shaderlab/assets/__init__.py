"""Meshes and textures as NumPy arrays, for cases that need something to look at.

A mesh is a mapping that `Mesh` takes as it is: `Mesh(**assets.sphere())`. A texture is an array
(height, width, channels) in 0…1 whose row 0 is the bottom one: `Texture(image=assets.crate)`.
"""

from shaderlab.assets.charts import uv_grid
from shaderlab.assets.compressed import compressed
from shaderlab.assets.meshes import Geometry, cube, joined, moved, plane, quad, sphere, torus
from shaderlab.assets.sky import sky_face
from shaderlab.assets.textures import (
    brick_normals,
    brick_wall,
    checker,
    crate,
    emblem,
    plaster,
    solid,
)

__all__ = [
    "Geometry",
    "brick_normals",
    "brick_wall",
    "checker",
    "compressed",
    "crate",
    "cube",
    "emblem",
    "joined",
    "moved",
    "plane",
    "plaster",
    "quad",
    "sky_face",
    "solid",
    "sphere",
    "torus",
    "uv_grid",
]
