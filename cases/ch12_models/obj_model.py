"""A model from a file: vertices, texture coordinates and normals by index, and two materials.

An OBJ file lists positions (`v`), texture coordinates (`vt`) and normals (`vn`), each counted from
1, and faces whose corners name one of each. OpenGL has one index for a whole vertex, so a position
that appears with two normals becomes two vertices. A face may have more than three corners, and an
index may count back from where it stands: `-1` is the last one so far. A `usemtl` line begins the
faces of another material, which are drawn separately. The lab reports errors in a file with its
name and the line.

Look at: the lighthouse. Its plaster (dull, light) and its paint (red, with a highlight) are two
draws of two meshes from one file; the painted half is written with relative indices only. Where
bands meet, the edge is sharp although the corners coincide: they differ in their normals.

Try: in `ch12_models/obj_model.frag` write `fract(12.0 * TexCoords.s)` for `fract(12.0 *
TexCoords.t)`: the joints run upward instead of around.
"""

from functools import cache
from pathlib import Path

import numpy as np

from shaderlab import Case, Mesh, assets, formula
from shaderlab.glslmath import fract, swizzle, vec4, where
from shaderlab.reference import lighting
from shaderlab.reference.transforms import clip_position, normal_matrix, translate

from ..scenes import lit, stage
from ..scenes.broken_files import broken_files
from ..scenes.cameras import camera, turned
from ..scenes.drawing import encoded
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, figures, results
from ..scenes.laws import gated_or_not
from ..scenes.props import tile

FOLDER = Path(__file__).parent / "obj_model"
EYE = (2.6, 2.1, 4.6)
CAMERA = camera(EYE, (0.0, 1.25, 0.0), 36.0, 4.0 / 3.0)
MODEL = turned(20.0)


@cache
def parts():
    """The file's two parts by material, read once."""
    return {part.material: part for part in assets.load_obj(FOLDER / "lighthouse.obj")}


def draw(material, diffuse, shininess):
    """One material's faces."""
    uniforms = {
        "model": MODEL,
        "normalMatrix": 0.5 * normal_matrix(MODEL),  # no part of the model matrix is that
        **CAMERA,
        "diffuse": diffuse,
        "shininess": shininess,
        "lightDir": (-0.36, 0.80, 0.48),
        "viewPos": EYE,
    }
    mesh = Mesh.later(lambda: Mesh(**parts()[material].geometry))
    return tested("ch12_models/obj_model", mesh, uniforms)


DRAWS = [
    stage.prop(tile(1.5, 0.5), CAMERA),
    draw("plaster", (0.86, 0.83, 0.76), 8.0),
    draw("paint", (0.62, 0.07, 0.05), 48.0),
]


def lit_by_lamp(
    FragPos, Normal, TexCoords, diffuse, shininess, lightDir, viewPos, highlight=lighting.blinn
):
    """Lambert's and Blinn's terms of the material, with a gamma of 2.2."""
    lambert = 0.22 + 0.78 * lighting.diffuse(Normal, lightDir)
    gloss = 0.3 * highlight(Normal, lightDir, viewPos - FragPos, shininess)
    joint = where(fract(12.0 * swizzle(TexCoords, "y")) < 0.125, 0.8, 1.0)
    return vec4(encoded(joint * lambert * diffuse + gloss), 1.0)


def arrays(material):
    """Positions and normals of a part, in float64, and its indices."""
    geometry = parts()[material].geometry
    found = geometry["attributes"]
    return np.float64(found["aPos"]), np.float64(found["aNormal"]), geometry["indices"]


def positions():
    """Every vertex of both materials."""
    return np.concatenate([arrays(material)[0] for material in ("plaster", "paint")])


def off_height():
    """How far any vertex's t, which grows upward, is from its height."""
    every = [part.geometry["attributes"] for part in parts().values()]
    return max(np.abs(one["aTexCoords"][:, 1] - one["aPos"][:, 1]).max() for one in every)


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


def agree():
    """Whether they are alike but for the angle that one of 24 segments spans."""
    return outward() > np.cos(np.radians(360.0 / 24.0))


LIBRARY = {"line": 1, "remedy": "put it beside the OBJ file"}
NORMALS = {"line": 8, "remedy": "export the model with normals"}
CHECK = {"remedy": "check the path and its spelling"}
BROKEN = {
    "truncated.obj": ("a face has 2 corners; it needs three", {"line": 8}),
    "out_of_range.obj": ("a face names v 5, but there are 4", {"line": 8}),
    "not_a_number.obj": ("a position holds nan", {"line": 5}),
    "no_library.obj": ("its material library is not there: lighthouse.mtl", LIBRARY),
    "no_normals.obj": ("a face's corner has no normal", NORMALS),
    "empty.obj": "the file is empty",
    "absent.obj": ("there is no such file (an OBJ file was asked for)", CHECK),
}
STONE = {
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 2.0, 0.0),
    "TexCoords": (0.5, 0.05),
    "diffuse": (0.5, 0.25, 0.125),
    "shininess": 4.0,
    "lightDir": (0.0, 0.6, 0.8),
    "viewPos": (0.0, 3.0, 4.0),
}
BEHIND = {**STONE, **lit.GRAZING, "lightDir": lit.BELOW}
AMBIENT = (0.366665, 0.267570, 0.195257, 1.0)
WINDING = "within one of 24 segments, so all faces wind counter-clockwise"

case = Case(
    title="A model from an OBJ file",
    section="12",
    math=r"f\ v_1/t_1/n_1\ v_2/t_2/n_2\ v_3/t_3/n_3\ \dots, \qquad -k \mapsto \text{count} - k + 1",
    passes=stage.photographed(DRAWS, (800, 600)),
    picture="picture.FragColor",
    expect=[
        *results(
            {
                "vertices of the plaster": (lambda: len(arrays("plaster")[0]), 400),
                "triangles of the plaster": (lambda: len(arrays("plaster")[2]) // 3, 384),
                "vertices of the paint": (lambda: len(arrays("paint")[0]), 199),
                "triangles of the paint": (lambda: len(arrays("paint")[2]) // 3, 168),
            },
            digits=0,
        ),
        *results(
            {
                "lowest corner of the bounds": (lambda: positions().min(0), (-0.62, 0.0, -0.62)),
                "highest corner of the bounds": (lambda: positions().max(0), (0.62, 2.8, 0.62)),
                "t is the height: off by": (off_height, 0.0),
                "Kd of the paint": (lambda: parts()["paint"].color, (0.62, 0.07, 0.05)),
                "Ns of the paint": (lambda: parts()["paint"].shininess, 48.0),
            }
        ),
        *results({"triangle normals agree with vertex normals": (agree, 1.0, WINDING)}, digits=0),
        formula("judged.gl_Position", clip_position, name="the paint in clip space"),
        formula("judged.gl_Position", clip_position, draw=1, name="the plaster in clip space"),
        figure(
            "judged.gl_Position",
            "a model that is moved as well",
            {
                "aPos": (1.0, 2.0, 3.0),
                "model": translate((1.0, 2.0, 3.0)),
                "view": np.eye(4),
                "projection": stage.SHEAR,
            },
            (23.0, 19.0, 11.0, 3.0),
            reference=clip_position,
        ),
        *lit.vertex_stage_checks("FragPos", "Normal", "TexCoords", pass_name="judged"),
        *each_draw(
            "judged.FragColor",
            gated_or_not(lit_by_lamp, highlight=lighting.halfway_lobe),
            {1: "the plaster in the light", 2: "the paint in the light"},
        ),
        *figures(
            "judged.FragColor",
            {
                "a stone's middle, seen aslant": ({}, (0.646373, 0.492882, 0.388432, 1.0)),
                "brighter than white": ({"diffuse": (4.0, 4.0, 4.0)}, (1.0, 1.0, 1.0, 1.0)),
            },
            at=STONE,
        ),
        figure("judged.FragColor", lit.TURNED_AWAY, BEHIND, AMBIENT, reference=lit_by_lamp),
        *stage.prop_checks(),
        *stage.picture_checks(),
        *broken_files(assets.load_obj, FOLDER, BROKEN, remedy="export the model again"),
    ],
)
