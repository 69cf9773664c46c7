"""Normal mapping: a flat wall lit as if it had bricks.

A normal map is a picture whose colours are directions, t = (n + 1)/2, so n = 2t − 1. They are given
in the frame of the texture: x along u, y along v, z out of the surface, which is why such maps are
blue. The frame is found from each triangle's positions and texture coordinates. Of its edges E₁ =
Δu₁T + Δv₁B and E₂ = Δu₂T + Δv₂B are known, so T and B can be solved for, and TBN = (T, B, N) takes
the map's normals to the world. Where a picture is mirrored, B has to be reversed with it. A byte
has no 0: the flat colour (128, 128, 255) leans by a third of a degree.

Look at: one wall of two triangles, four times. Upper left it is lit as the flat thing that it is.
The other three have the normal map, and a lamp that moves around them: every joint is dark on the
side towards the lamp and bright on the other, and the wall is turned away from the viewer, so the
map's normals had to turn with it.

Try: in `ch05_lighting/normal_map.frag` write `TBN * vec3(normal.x, -normal.y, normal.z)` for `TBN *
normal`: level joints are lit from the wrong side: some normal maps count green downward.
"""

import numpy as np

from shaderlab import Case, Erratum, Mesh, Texture, assets, formula
from shaderlab.glslmath import mul, normalize, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import tangent_space
from shaderlab.reference.lighting import blinn, diffuse, halfway_lobe
from shaderlab.reference.transforms import (
    normal_matrix,
    scale,
    translate,
    world_normal,
    world_position,
)

from ..scenes import lit, painted_textures
from ..scenes.cameras import camera, turned
from ..scenes.draws import drawn
from ..scenes.figures import figure, results
from ..scenes.laws import entry, gated_or_not, unchanged
from ..scenes.panels import WHOLE, cell, panel_pass, picture

EYE = (0.0, 0.0, 4.0)
CAMERA = camera(EYE, (0.0, 0.0, 0.0), 33.0)
TURNED = turned(-24.0, (0.3, 1.0, 0.0)) @ turned(4.0, (0.0, 0.0, 1.0))
# Squeezed and moved, so that positions, normals and tangents each need their own way.
SQUEEZED = translate((0.1, -0.05, 0.2)) @ TURNED @ scale((1.0, 0.8, 1.0))
LAMPS = {
    "left": (-1.7, 0.9, 1.1),
    "above": (0.2, 1.7, 0.9),
    "right": (1.5, -0.4, 1.3),
    "behind": (0.8, 0.3, -2.0),
}
SMOOTH = {"format": "rgba8", "filter": ("linear_mipmap_linear", "linear"), "mipmaps": True}


def wall(repeat=1.0, bulge=0.0, skew=0.0):
    """A square wall; a negative `repeat` mirrors its picture, a `skew` moves and shears it. With a
    `bulge` its normals lean outwards at the corners, as those of a round wall made of few triangles
    do."""
    made = assets.quad(2.0)
    uv = made["attributes"]["aTexCoords"]
    made["attributes"]["aTexCoords"] = uv * np.float32((repeat, 1.0)) + np.float32(skew) * (
        uv[:, ::-1] + np.float32(1.0)
    )
    lean = np.float32((1.0, 0.6, 0.0)) * made["attributes"]["aPos"]
    made["attributes"]["aNormal"] = made["attributes"]["aNormal"] + np.float32(bulge) * lean
    return Mesh(**made)


def brick_maps(size, **sampling):
    """The bricks' colours and their normals."""
    return {
        "diffuseMap": Texture(image=lambda: painted_textures.brick_wall(size), **sampling),
        "normalMap": Texture(image=lambda: painted_textures.brick_normals(size), **sampling),
    }


BRICKS = brick_maps(512, **SMOOTH)


def lit_wall(lamp, model, mesh, maps, *, flat=False, cell=None):
    """The wall under one lamp."""
    shaders = tuple(f"ch05_lighting/normal_map.{stage}" for stage in ("vert", "geom", "frag"))
    placed = {"model": model, "normalMatrix": normal_matrix(model), **CAMERA}
    seen = {"flatWall": flat, "lightPos": LAMPS[lamp], "viewPos": EYE}
    return drawn(shaders, mesh, {**placed, **seen}, textures=maps, cell=cell)


def quarter(k, lamp, flat=False):
    """One quarter of the picture."""
    return lit_wall(lamp, TURNED, wall(), BRICKS, flat=flat, cell=cell(k, 2, 2))


def judged(name, lamp, repeat=1.0, flat=False):
    """A bulging wall in float textures, whose texels references can read."""
    mesh, maps = wall(repeat, bulge=0.5, skew=0.25), brick_maps(64)
    return picture([lit_wall(lamp, SQUEEZED, mesh, maps, flat=flat)], None, name)


def frame(place, uv, upright, emitted):
    """T, B and N of a triangle at one of its corners."""
    edges, sides = ([corners[k] - corners[0] for k in (1, 2)] for corners in (place, uv))
    normal = normalize(entry(emitted, upright))
    t = tangent_space.tangent(*edges, *sides, normal)
    return t, tangent_space.bitangent(normal, t, *sides), normal


def axis(which):
    """T, B or N alone."""

    def column(place, uv, upright, emitted):
        return frame(place, uv, upright, emitted)[which]

    return column


def place_of(place, emitted):
    """A corner's place in the world."""
    return entry(emitted, place)


def uv_of(uv, emitted):
    """A corner's place in the texture."""
    return entry(emitted, uv)


def world(aPos, model):
    """The vertex shader leaves the camera to the geometry shader."""
    return mul(model, vec4(aPos, 1.0))


def in_picture(gl_in_gl_Position, emitted, view, projection):
    """Clip coordinates of the corner."""
    return mul(projection, mul(view, entry(emitted, gl_in_gl_Position)))


def mapped_normal(TBN, TexCoords, normalMap, flatWall):
    """The map's normal in the world."""
    told = tangent_space.decoded_normal(swizzle(texture(normalMap, TexCoords), "rgb"))
    return normalize(mul(TBN, where(flatWall == 1, vec3(0.0, 0.0, 1.0), told)))


def color(
    TBN, TexCoords, FragPos, normalMap, diffuseMap, flatWall, lightPos, viewPos, highlight=blinn
):
    """Diffuse and specular light on the mapped normal."""
    normal = mapped_normal(TBN, TexCoords, normalMap, flatWall)
    lambert = diffuse(normal, lightPos - FragPos)
    glint = highlight(normal, lightPos - FragPos, viewPos - FragPos, 24.0)
    bricks = swizzle(texture(diffuseMap, TexCoords), "rgb")
    return vec4(bricks * (0.05 + 1.15 * lambert) + 0.28 * glint, 1.0)


leaking_or_not = gated_or_not(color, highlight=halfway_lobe)


def checks(name, shaded=leaking_or_not):
    """What must hold of a judged pass."""
    return (
        formula(f"{name}.place", world_position, name=f"{name}: corners"),
        formula(f"{name}.upright", world_normal, name=f"{name}: their normals"),
        formula(f"{name}.uv", unchanged("aTexCoords"), name=f"{name}: their places in the texture"),
        formula(f"{name}.gl_in.gl_Position", world, name=f"{name}: corners in the world"),
        formula(f"{name}.gl_Position", in_picture),
        formula(f"{name}.FragPos", place_of, name=f"{name}: places"),
        *(formula(f"{name}.TBN[{k}]", axis(k), name=f"{name}: {'TBN'[k]}") for k in range(3)),
        formula(f"{name}.normal", mapped_normal, name=f"{name}: normals"),
        formula(f"{name}.FragColor", shaded, name=f"{name}: colours"),
    )


BYTES_SHADER = "ch05_lighting/normal_map_bytes.frag"
BYTES = Texture(image=np.array([[[128, 127, 255, 255]]]) / 255.0, format="rgba8")

QUARTERS = (quarter(2, "left", flat=True), quarter(3, "left"), quarter(0, "above"))
QUARTERS += (quarter(1, "right"),)
# Level, before the viewer, the lamp below its horizon.
AWAY = {
    "TexCoords": (0.5, 0.5),
    "FragPos": (0.0, 0.0, 0.0),
    "TBN": np.eye(3),
    "lightPos": lit.BELOW,
    "viewPos": lit.GRAZING["viewPos"],
}
TILT = tangent_space.tilt_of_flat_bytes

case = Case(
    title="Normal mapping",
    section="5.10",
    math=r"n = 2t - 1, \qquad \begin{pmatrix} T \\ B \end{pmatrix} = "
    r"\begin{pmatrix} \Delta u_1 & \Delta v_1 \\ \Delta u_2 & \Delta v_2 \end{pmatrix}^{-1}"
    r"\begin{pmatrix} E_1 \\ E_2 \end{pmatrix}",
    passes=(
        picture(
            QUARTERS,
            (1024, 1024),
            "scene",
            colors={"FragColor": "rgba16f"},
            clear=(0.012, 0.014, 0.02, 1.0),
        ),
        *lit.picture(),
        panel_pass("bytes", BYTES_SHADER, WHOLE, size=(2, 2), textures={"normalMap": BYTES}),
        judged("mapped", "left"),
        judged("mirrored", "behind", repeat=-1.0),
        judged("flat", "left", flat=True),
    ),
    picture="picture.FragColor",
    rows=("flat; the normal map", "the lamp elsewhere"),
    expect=[
        formula("mapped.TexCoords", uv_of, name="mapped: texture coordinates"),
        *checks("mapped"),
        *checks("mirrored"),
        *checks("flat", color),
        lit.picture_check(),
        figure("flat.FragColor", lit.TURNED_AWAY, AWAY, (0.027162, 0.024812, 0.022822, 1.0)),
        figure(
            "bytes.normal",
            "what bytes 128, 127 and 255 stand for",
            {"TexCoords": (0.5, 0.5)},
            (0.003922, -0.003922, 1.0),
        ),
        *results({"how far the flat colour leans, in degrees": (TILT, 0.317755)}),
    ],
    errata=[
        Erratum(
            section="5.10",
            says="normal mapping and bump mapping are one thing; nothing is said of a TBN matrix",
            truth="a bump map holds heights, whose slopes tilt the normal (Blinn 1978); a normal "
            "map holds directions in the texture's own frame, which TBN takes to the world",
            proof="mapped: normals",
        )
    ],
)
