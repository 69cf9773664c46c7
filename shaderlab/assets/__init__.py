"""Meshes and textures as NumPy arrays, made by arithmetic or read from files.

A mesh is a mapping that `Mesh` takes as it is: `Mesh(**assets.sphere())`. A texture is an array
(height, width, channels) in 0…1 whose row 0 is the bottom one: `Texture(image=assets.crate)`.
`load_obj` and `load_pcd` read models and point clouds from files.
"""

from shaderlab.assets.meshes import (
    Geometry,
    cube,
    ellipsoid,
    joined,
    moved,
    plane,
    quad,
    sphere,
    torus,
)
from shaderlab.assets.obj import Part, load_obj
from shaderlab.assets.pcd import Cloud, load_pcd
from shaderlab.assets.textures import (
    brick_normals,
    brick_wall,
    checker,
    crate,
    emblem,
    plaster,
    solid,
    uv_grid,
)

__all__ = [
    "Cloud",
    "Geometry",
    "Part",
    "brick_normals",
    "brick_wall",
    "checker",
    "crate",
    "cube",
    "ellipsoid",
    "emblem",
    "joined",
    "load_obj",
    "load_pcd",
    "moved",
    "plane",
    "plaster",
    "quad",
    "solid",
    "sphere",
    "torus",
    "uv_grid",
]
