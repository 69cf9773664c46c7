"""A model from a file: vertices, texture coordinates and normals by index, and two materials.

An OBJ file lists positions (`v`), texture coordinates (`vt`) and normals (`vn`), each counted from
1, and faces whose corners name one of each. OpenGL has one index for a whole vertex, so a position
that appears with two normals becomes two vertices. A face may have more than three corners, and an
index may count back from where it stands: `-1` is the last one so far. A `usemtl` line begins the
faces of another material, which are drawn by themselves. What is wrong with a file, the lab says
with the file's name and the line.

Look at: the lighthouse. Its plaster (dull, light) and its paint (red, with a highlight) are two
draws of two meshes from one file; the painted half is written with relative indices only. Where
bands meet, the edge is sharp although the corners coincide: they differ in their normals.
"""

from functools import cache
from math import radians
from pathlib import Path

import numpy as np

from shaderlab import (
    Case,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    computed,
    exact,
    formula,
    refused,
    value,
)
from shaderlab.glslmath import clamp, dot, fract, max, normalize, pow, swizzle, vec4, where
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes import stage
from ..scenes.props import tile
from ..scenes.studio import handed_on as same_color
from ..scenes.studio import softened, studio_color

FOLDER = Path(__file__).parent / "obj_model"
EYE = (2.6, 2.1, 4.6)
LIGHT = (-0.36, 0.80, 0.48)
VIEW = look_at(EYE, (0.0, 1.25, 0.0))
PROJECTION = perspective(radians(36.0), 4.0 / 3.0, 0.1, 20.0)
MODEL = rotate(radians(20.0), (0.0, 1.0, 0.0))


@cache
def parts():
    """The file's two parts by material, read once."""
    return {part.material: part for part in assets.load_obj(FOLDER / "lighthouse.obj")}


def draw(material, diffuse, shininess):
    """One material's faces."""
    return Draw(
        vertex="ch12_models/obj_model.vert",
        fragment="ch12_models/obj_model.frag",
        mesh=Mesh.later(lambda: Mesh(**parts()[material].geometry)),
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "view": VIEW,
            "projection": PROJECTION,
            "diffuse": diffuse,
            "shininess": shininess,
            "lightDir": LIGHT,
            "viewPos": EYE,
        },
        state=State(depth=Depth()),
    )


def lit(FragPos, Normal, TexCoords, diffuse, shininess, lightDir, viewPos):
    """Lambert's and Blinn's terms of the material, with a gamma of 2.2."""
    normal = normalize(Normal)
    halfway = normalize(lightDir + normalize(viewPos - FragPos))
    lambert = 0.22 + 0.78 * max(dot(normal, lightDir), 0.0)
    gloss = 0.3 * pow(max(dot(normal, halfway), 0.0), shininess)
    joint = where(fract(12.0 * swizzle(TexCoords, "y")) < 0.125, 0.8, 1.0)
    color = joint * lambert * diffuse + gloss
    return vec4(pow(clamp(color, 1.0e-6, 1.0), 1.0 / 2.2), 1.0)


def handed_on(aTexCoords):
    """Texture coordinates stay as they are."""
    return aTexCoords


def arrays(material):
    """Positions and normals of a part, in float64."""
    geometry = parts()[material].geometry
    found = geometry["attributes"]
    return np.float64(found["aPos"]), np.float64(found["aNormal"]), geometry["indices"]


def positions():
    """Every vertex of both materials."""
    return np.concatenate([arrays(material)[0] for material in ("plaster", "paint")])


def outward():
    """The smallest cosine between a triangle's own normal and those of its corners."""
    found = []
    for material in ("plaster", "paint"):
        place, normal, indices = arrays(material)
        corners = place[indices].reshape(-1, 3, 3)
        own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        own /= np.linalg.norm(own, axis=1, keepdims=True)
        found.append((own[:, None] * normal[indices].reshape(-1, 3, 3)).sum(-1).min())
    return np.min(found)


def bad(name, message, **place):
    """A broken file is refused in exactly these words."""
    return refused(
        lambda: assets.load_obj(FOLDER / "broken" / name),
        message=message,
        file=f"obj_model/broken/{name}",
        name=name,
        **({"remedy": "export the model again"} | place),
    )


FIGURES = [
    ("vertices of the plaster", lambda: len(arrays("plaster")[0]), 400),
    ("triangles of the plaster", lambda: len(arrays("plaster")[2]) // 3, 384),
    ("vertices of the paint", lambda: len(arrays("paint")[0]), 199),
    ("triangles of the paint", lambda: len(arrays("paint")[2]) // 3, 168),
]

DRAWS = [
    stage.prop(tile(1.5, 0.5), VIEW, PROJECTION),
    draw("plaster", (0.86, 0.83, 0.76), 8.0),
    draw("paint", (0.62, 0.07, 0.05), 48.0),
]

case = Case(
    title="A model from an OBJ file",
    section="12",
    math=r"f\ v_1/t_1/n_1\ v_2/t_2/n_2\ v_3/t_3/n_3\ \dots, \qquad -k \mapsto \text{count} - k + 1",
    passes=(
        *stage.photographed(DRAWS, (800, 600)),
        Pass(
            name="reversed",
            target=Target(size=(96, 72), depth="depth24", clear=stage.SKY),
            draws=tuple(reversed(DRAWS)),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        *(computed(label, count, equals=n, digits=0) for label, count, n in FIGURES),
        computed(
            "lowest corner of the bounds",
            lambda: positions().min(axis=0),
            equals=(-0.62, 0.0, -0.62),
            digits=6,
        ),
        computed(
            "highest corner of the bounds",
            lambda: positions().max(axis=0),
            equals=(0.62, 2.8, 0.62),
            digits=6,
        ),
        computed(
            "Kd of the paint", lambda: parts()["paint"].color, equals=(0.62, 0.07, 0.05), digits=6
        ),
        computed("Ns of the paint", lambda: parts()["paint"].shininess, equals=48.0, digits=6),
        computed(
            "triangle normals agree with vertex normals",
            lambda: outward() > np.cos(radians(360.0 / 24.0)),
            equals=1.0,
            digits=0,
            note="within one of 24 segments, so all faces wind counter-clockwise",
        ),
        formula("judged.gl_Position", clip_position, name="the paint in clip space"),
        formula("judged.gl_Position", clip_position, draw=1, name="the plaster in clip space"),
        formula("judged.FragPos", world_position),
        formula("judged.Normal", world_normal),
        formula("judged.TexCoords", handed_on),
        formula("judged.FragColor", lit, draw=1, name="the plaster in the light"),
        formula("judged.FragColor", lit, draw=2, name="the paint in the light"),
        value(
            "judged.FragColor",
            at={
                "FragPos": (0.0, 0.0, 0.0),
                "Normal": (0.0, 2.0, 0.0),
                "TexCoords": (0.5, 0.05),
                "diffuse": (0.5, 0.25, 0.125),
                "shininess": 4.0,
                "lightDir": (0.0, 0.6, 0.8),
                "viewPos": (0.0, 3.0, 4.0),
            },
            equals=(0.646373, 0.492882, 0.388432, 1.0),
            digits=6,
            name="a stone's middle, seen aslant",
        ),
        *stage.prop_checks(clip_position, world_normal, same_color, studio_color),
        exact("judged.FragColor", Output("reversed", "FragColor"), name="the order of drawing"),
        formula("soft.FragColor", softened(texture), name="four texels a pixel"),
        bad("truncated.obj", "a face has 2 corners; it needs three", line=8),
        bad("out_of_range.obj", "a face names v 5, but there are 4", line=8),
        bad("not_a_number.obj", "a position holds nan", line=5),
        bad(
            "no_library.obj",
            "its material library is not there: lighthouse.mtl",
            line=1,
            remedy="put it beside the OBJ file",
        ),
        bad(
            "no_normals.obj",
            "a face's corner has no normal",
            line=8,
            remedy="export the model with normals",
        ),
        bad("empty.obj", "the file is empty"),
        bad(
            "absent.obj",
            "there is no such file (an OBJ file was asked for)",
            remedy="check the path and its spelling",
        ),
    ],
)
