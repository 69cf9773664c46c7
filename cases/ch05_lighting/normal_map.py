"""Normal mapping: a flat wall lit as if it had bricks.

A normal map is a picture whose colours are directions, t = (n + 1)/2, so n = 2t − 1. They are told
in the frame of the texture: x along u, y along v, z out of the surface, which is why such maps are
blue. The frame is found from each triangle's positions and texture coordinates. Of its edges
E₁ = Δu₁T + Δv₁B and E₂ = Δu₂T + Δv₂B are known, so T and B can be solved for, and TBN = (T, B, N)
takes the map's normals to the world. Where a picture is mirrored, B has to turn round with it. A
byte has no 0: the flat colour (128, 128, 255) leans by a third of a degree.

Look at: one wall of two triangles, four times. Upper left it is lit as the flat thing that it is.
The other three have the normal map, and a lamp that moves around them: every joint is dark on the
side towards the lamp and bright on the other, and the wall is turned away from the viewer, so the
map's normals had to turn with it.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Draw,
    Mesh,
    Output,
    Pass,
    Pixel,
    State,
    Target,
    Texture,
    assets,
    computed,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import dot, max, mul, normalize, swizzle, vec3, vec4, where
from shaderlab.reference import tangent_space
from shaderlab.reference.blinn_phong import lobe
from shaderlab.reference.transforms import (
    look_at,
    normal_matrix,
    perspective,
    rotate,
    scale,
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.studio import finished

EYE = (0.0, 0.0, 4.0)
TURNED = rotate(radians(-24.0), (0.3, 1.0, 0.0)) @ rotate(radians(4.0), (0.0, 0.0, 1.0))
# Squeezed and moved, so that positions, normals and tangents each need their own way.
SQUEEZED = translate((0.1, -0.05, 0.2)) @ TURNED @ scale((1.0, 0.8, 1.0))
LAMPS = {
    "left": (-1.7, 0.9, 1.1),
    "above": (0.2, 1.7, 0.9),
    "right": (1.5, -0.4, 1.3),
    "behind": (0.8, 0.3, -2.0),
}


def wall(repeat=1.0, bulge=0.0):
    """A square wall; a negative `repeat` mirrors its picture. With a `bulge` its normals lean
    outwards at the corners, as those of a round wall made of few triangles do."""
    made = assets.quad(2.0)
    made["attributes"]["aTexCoords"] *= np.float32((repeat, 1.0))
    lean = np.float32((1.0, 0.6, 0.0)) * made["attributes"]["aPos"]
    made["attributes"]["aNormal"] = made["attributes"]["aNormal"] + np.float32(bulge) * lean
    return Mesh(**made)


def brick_maps(size, **sampling):
    """The bricks' colours and their normals."""
    return {
        "diffuseMap": Texture(image=lambda: assets.brick_wall(size), **sampling),
        "normalMap": Texture(image=lambda: assets.brick_normals(size), **sampling),
    }


def lit_wall(lamp, *, model, mesh, flat=False, cell=None, maps):
    """The wall under one lamp."""
    return Draw(
        vertex="ch05_lighting/normal_map.vert",
        geometry="ch05_lighting/normal_map.geom",
        fragment="ch05_lighting/normal_map.frag",
        mesh=mesh,
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at(EYE, (0.0, 0.0, 0.0)),
            "projection": perspective(radians(33.0), 1.0, 0.1, 20.0),
            "flatWall": flat,
            "lightPos": lamp,
            "viewPos": EYE,
        },
        textures=maps,
        state=State(cell=cell),
    )


def quarter(column, row, lamp, flat=False):
    """One quarter of the picture."""
    cell = Cell(column=column, row=row, columns=2, rows=2)
    smooth = {
        "format": "rgba8",
        "filter": ("linear_mipmap_linear", "linear"),
        "mipmaps": True,
    }
    maps = brick_maps(512, **smooth)
    return lit_wall(LAMPS[lamp], model=TURNED, mesh=wall(), flat=flat, cell=cell, maps=maps)


def frame(place, uv, upright, emitted):
    """T, B and N of a triangle at one of its corners."""
    edges, sides = ([corners[k] - corners[0] for k in (1, 2)] for corners in (place, uv))
    normal = normalize(picked(upright, emitted))
    t = tangent_space.tangent(*edges, *sides, normal)
    return t, tangent_space.bitangent(normal, t, *sides), normal


def axis(which):
    """T, B or N alone."""

    def column(place, uv, upright, emitted):
        return frame(place, uv, upright, emitted)[which]

    return column


def texture_coordinates(aTexCoords):
    """What the vertex shader hands on."""
    return aTexCoords


def world(aPos, model):
    """The vertex shader leaves the camera to the geometry shader."""
    return mul(model, vec4(aPos, 1.0))


def in_picture(gl_in_gl_Position, emitted, view, projection):
    """Clip coordinates of the corner."""
    return mul(projection, mul(view, picked(gl_in_gl_Position, emitted)))


def picked(corners, emitted):
    """What the corner has that is emitted."""
    return where(emitted == 0, corners[0], where(emitted == 1, corners[1], corners[2]))


def mapped_normal(TBN, TexCoords, normalMap, flatWall):
    """The map's normal in the world."""
    told = tangent_space.decoded_normal(swizzle(texture(normalMap, TexCoords), "rgb"))
    return normalize(mul(TBN, where(flatWall == 1, vec3(0.0, 0.0, 1.0), told)))


def color(TBN, TexCoords, FragPos, normalMap, diffuseMap, flatWall, lightPos, viewPos):
    """Diffuse and specular light on the mapped normal."""
    normal = mapped_normal(TBN, TexCoords, normalMap, flatWall)
    to_light, to_eye = normalize(lightPos - FragPos), normalize(viewPos - FragPos)
    lit = max(dot(normal, to_light), 0.0)
    glint = lobe(dot(normal, normalize(to_light + to_eye)), 24.0)
    bricks = swizzle(texture(diffuseMap, TexCoords), "rgb")
    return vec4(bricks * (0.05 + 1.15 * lit) + 0.28 * glint, 1.0)


def judged(name, lamp, repeat=1.0, flat=False):
    """A bulging wall in float textures, whose texels references can read."""
    mesh, maps = wall(repeat, bulge=0.5), brick_maps(64)
    draw = lit_wall(LAMPS[lamp], model=SQUEEZED, mesh=mesh, flat=flat, maps=maps)
    return Pass(name=name, draws=[draw])


def checks(name):
    """What each judged pass has to keep."""
    return (
        formula(f"{name}.gl_Position", in_picture),
        formula(f"{name}.FragPos", corner_of("place"), name=f"{name}: places"),
        formula(f"{name}.TBN[0]", axis(0), name=f"{name}: T"),
        formula(f"{name}.TBN[1]", axis(1), name=f"{name}: B"),
        formula(f"{name}.TBN[2]", axis(2), name=f"{name}: N"),
        formula(f"{name}.normal", mapped_normal, name=f"{name}: normals"),
        formula(f"{name}.FragColor", color, name=f"{name}: colours"),
    )


def corner_of(what):
    """What a corner of the triangle has, handed on."""
    if what == "place":
        return lambda place, emitted: picked(place, emitted)
    return lambda uv, emitted: picked(uv, emitted)


case = Case(
    title="Normal mapping",
    section="5.10",
    math=r"n = 2t - 1, \qquad \begin{pmatrix} T \\ B \end{pmatrix} = "
    r"\begin{pmatrix} \Delta u_1 & \Delta v_1 \\ \Delta u_2 & \Delta v_2 \end{pmatrix}^{-1}"
    r"\begin{pmatrix} E_1 \\ E_2 \end{pmatrix}",
    passes=(
        Pass(
            name="scene",
            target=Target(
                size=(1024, 1024),
                colors={"FragColor": "rgba16f"},
                clear=(0.012, 0.014, 0.02, 1.0),
            ),
            draws=(
                quarter(0, 1, "left", flat=True),
                quarter(1, 1, "left"),
                quarter(0, 0, "above"),
                quarter(1, 0, "right"),
            ),
        ),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *fullscreen(
            "ch05_lighting/normal_map_bytes.frag",
            name="bytes",
            textures={
                "normalMap": Texture(
                    image=np.array([[[128, 127, 255, 255]]]) / 255.0, format="rgba8"
                )
            },
            target=Target(size=(2, 2)),
        ),
        Pass(
            name="corners",
            draws=[
                Draw(
                    vertex="ch05_lighting/normal_map.vert",
                    fragment="ch05_lighting/lamp.frag",
                    mesh=wall(bulge=0.5),
                    uniforms={
                        "model": SQUEEZED,
                        "normalMatrix": normal_matrix(SQUEEZED),
                        "glow": (1.0, 1.0, 1.0),
                    },
                )
            ],
        ),
        judged("mapped", "left"),
        judged("mirrored", "behind", repeat=-1.0),
        judged("flat", "left", flat=True),
    ),
    picture="picture.FragColor",
    expect=[
        formula("corners.place", world_position),
        formula("corners.upright", world_normal),
        formula("corners.uv", texture_coordinates),
        formula("corners.gl_Position", world),
        formula("mapped.TexCoords", corner_of("uv"), name="mapped: texture coordinates"),
        *checks("mapped"),
        *checks("mirrored"),
        formula("flat.normal", mapped_normal, name="flat: normals"),
        formula("flat.FragColor", color, name="flat: colours"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        value(
            "bytes.normal",
            at=Pixel(0, 0),
            equals=(0.003922, -0.003922, 1.0),
            digits=6,
            name="what bytes 128, 127 and 255 stand for",
        ),
        computed(
            "how far the flat colour leans, in degrees",
            tangent_space.tilt_of_flat_bytes,
            equals=0.317755,
            digits=6,
        ),
    ],
)
