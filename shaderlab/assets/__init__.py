"""Meshes and textures as NumPy arrays, made by arithmetic or read from files.

A mesh is a mapping that `Mesh` takes as it is: `Mesh(**assets.sphere())`. A texture is an array
(height, width, channels) in 0…1 whose row 0 is the bottom one: `Texture(image=assets.checker)`.
`load_obj` and `load_pcd` read models and point clouds from files.
"""

from shaderlab.assets.meshes import (
    Geometry as Geometry,
    cube as cube,
    ellipsoid as ellipsoid,
    joined as joined,
    moved as moved,
    plane as plane,
    quad as quad,
    sphere as sphere,
    torus as torus,
)
from shaderlab.assets.models import (
    Cloud as Cloud,
    Part as Part,
    load_obj as load_obj,
    load_pcd as load_pcd,
)
from shaderlab.assets.textures import (
    checker as checker,
    solid as solid,
)
