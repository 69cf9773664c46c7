"""Normals made visible: each corner of each triangle grows a line.

The mesh is drawn twice. The first time as it is; the second time its triangles go through a
geometry shader that emits, for each corner, a strip of two vertices: the corner, and the corner
moved along its normal. The move is made in view space, where normals are turned by the inverse
transpose of view · model and nothing is distorted by perspective yet; the projection comes last.
Triangles come in and lines go out, so primitives of both kinds need not agree.

Look at: the box, which has three normals at each corner because its faces do not share vertices,
and the ring, which has one. Lines go from yellow at the surface to red.

Try: in `ch08_techniques/geometry_normals.geom` write `float(end) * -gs_in[i].normal` for
`float(end) * gs_in[i].normal`: the lines grow inwards, where the solids hide them.
"""

import numpy as np

from shaderlab import Case, any_order, both_ways, formula, query
from shaderlab.assets import meshes
from shaderlab.glslmath import floor, mix, mul, normalize, vec3, vec4
from shaderlab.reference.rasterisation import samples_passed
from shaderlab.reference.transforms import normal_matrix, translate

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.draws import tested
from ..scenes.figures import figure
from ..scenes.laws import entry
from ..scenes.panels import picture
from ..scenes.studio import studio_color

CAMERA = camera((0.4, 2.3, 4.2), (0.04, 0.02, 0.0), 36.5)
VIEW, PROJECTION = CAMERA["view"], CAMERA["projection"]
BLUE = (0.30, 0.45, 0.75)
TURN = turned(25.0, (0.2, 1.0, 0.1))
SOLIDS = {
    "box": (meshes.cube(0.8), (0.16, 0.52, 0.20), translate((-0.6, 0.42, -0.3)) @ TURN),
    "ring": (meshes.torus(0.5, 0.2, 20, 10), BLUE, translate((0.5, -0.42, 0.3)) @ TURN),
}
SIDE = 64  # at which targets without a size are judged
SURFACES = [
    stage.prop(solids.painted(geometry, color), CAMERA, model=model)
    for geometry, color, model in SOLIDS.values()
]


def in_front():
    """How many samples of the solids pass the depth test, at least and at most: from the mesh."""
    clip = []
    for geometry, _, model in SOLIDS.values():
        positions = geometry["attributes"]["aPos"]
        corners = np.column_stack([positions, np.ones(len(positions))])
        triangles = geometry["indices"].reshape(-1, 3)
        clip.append((corners @ (PROJECTION @ VIEW @ model).T)[triangles])
    return samples_passed(clip, (SIDE, SIDE))


def normals(name):
    """A solid's normals as lines."""
    geometry, _, model = SOLIDS[name]
    shaders = (f"ch08_techniques/geometry_normals.{stage}" for stage in ("vert", "geom", "frag"))
    uniforms = {"normalMatrix": normal_matrix(VIEW @ model), "magnitude": 0.3}
    only = ("aPos", "aNormal")
    return tested(tuple(shaders), geometry, {"model": model, **CAMERA, **uniforms}, only=only)


def in_view(aPos, model, view):
    """A vertex in view space."""
    return mul(view, mul(model, vec4(aPos, 1.0)))


def turned_normal(aNormal, normalMatrix):
    """Its normal there, of length 1."""
    return normalize(mul(normalMatrix, aNormal))


def at_tip(emitted):
    """1 for every second vertex that is emitted, 0 for those on the surface."""
    return emitted - 2.0 * floor(0.5 * emitted)  # no quotient, which could fall short of a whole


def of_corner(values, emitted):
    """The corner's own value: each corner emits two vertices."""
    return entry(floor(0.5 * emitted + 0.25), values)


def grown(gl_in_gl_Position, VS_OUT_normal, emitted, projection, magnitude):
    """A corner in view space, its tip moved along the normal, then projected."""
    offset = magnitude * at_tip(emitted) * of_corner(VS_OUT_normal, emitted)
    return mul(projection, of_corner(gl_in_gl_Position, emitted) + vec4(offset, 0.0))


def faded(fraction):
    """From yellow to red."""
    return vec4(mix(vec3(0.95, 0.75, 0.15), vec3(0.85, 0.15, 0.1), fraction), 1.0)


def counted(counter, draw, name, **bounds):
    """How many of something the driver counts in one draw."""
    return query(counter, pass_name="judged", draw=draw, name=name, **bounds)


DRAWS = (*SURFACES, normals("box"), normals("ring"))

case = Case(
    title="Normals as lines",
    section="8.6",
    math=r"p_{\text{tip}} = P\,(V M p + m\, \hat n), \qquad "
    r"\hat n = \frac{((V M)^{-1})^{\mathsf T} n}{\lVert ((V M)^{-1})^{\mathsf T} n \rVert}",
    passes=(*both_ways(picture(DRAWS, None, "judged", depth="depth24", clear=stage.SKY)),),
    picture="judged.FragColor",
    expect=[
        *stage.prop_checks(),
        formula("judged.FragColor", studio_color, draw=1, name="the ring in the light"),
        *(
            formula(f"judged.{output}", reference, draw=draw, name=f"{solid}: {what}")
            for draw, solid in ((2, "box"), (3, "ring"))
            for output, reference, what in (
                ("gl_in.gl_Position", in_view, "vertices in view space"),
                ("VS_OUT.normal", turned_normal, "normals in view space"),
                ("gl_Position", grown, "feet and tips"),
                ("fraction", at_tip, "which end"),
                ("FragColor", faded, "colour"),
            )
        ),
        counted("geometry_primitives_emitted", 2, "12 · 3 lines", equals=36),
        counted("geometry_primitives_emitted", 3, "400 · 3 lines", equals=1200),
        *(
            counted("samples_passed", draw, f"samples in front, {name}", at_least=low, at_most=high)
            for draw, (name, (low, high)) in enumerate(zip(SOLIDS, in_front(), strict=True))
        ),
        any_order("judged.FragColor"),
        figure(
            "judged.VS_OUT.normal",
            "a normal of any length has length 1 in view space",
            {"aNormal": (1.0, 2.0, 3.0), "normalMatrix": stage.SHEAR[:3, :3]},
            (0.759072, 0.552052, 0.345033),
            reference=turned_normal,
        ),
        figure(
            "judged.FragColor",
            "judged.FragColor",
            {"fraction": 0.25},
            (0.925, 0.6, 0.1375, 1.0),
            reference=faded,
            draw=2,
        ),
    ],
)
