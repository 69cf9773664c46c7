"""Specular light: a glossy surface mirrors the lamp, blurred, towards one side only.

The ray from the lamp is mirrored at the normal. Who stands in its way sees a highlight; the
farther away one stands, the less, by the cosine of the angle to the power of the shininess. It is
the only one of the three parts that depends on the viewer, so it moves when the viewer does. At
the notes' point the cosine is 0.788110, and to the power of 32 next to nothing is left of it.

Look at: the same ring and ball three times. Above is what ambient and diffuse light show: chalk.
In the middle is the specular part alone, a few points of light on black. Below is the sum, and
the chalk has become glazed clay.
"""

from math import radians

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    formula,
    fullscreen,
    sweep,
    value,
)
from shaderlab.assets.order import any_order, both_ways
from shaderlab.reference.lighting import phong_color, specular_factor
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    normal_matrix,
    perspective,
    rotate,
    translate,
    world_normal,
    world_position,
)
from shaderlab.sampling import texture

from ..scenes.studio import finished

CORAL = (1.0, 0.5, 0.31)
EYE, LAMP = (0.0, 1.9, 5.6), (-1.8, 3.4, 2.4)
LEANING = translate((0.85, 0.72, -0.3)) @ rotate(radians(58.0), (1.0, -0.25, 0.3))

# From below: the sum, the specular part alone, ambient and diffuse part.
ROWS = [(0.1, 0.75, 0.9), (0.0, 0.0, 0.9), (0.1, 0.75, 0.0)]


def thing(geometry, model, strengths, row):
    """One thing in one row, with these strengths of the three parts."""
    ambient, diffuse, specular = strengths
    return Draw(
        vertex="ch05_lighting/lit.vert",
        fragment="ch05_lighting/specular.frag",
        mesh=Mesh(**geometry).only("aPos", "aNormal"),
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at(EYE, (0.0, 0.68, 0.0)),
            "projection": perspective(radians(21.5), 3.0, 0.1, 20.0),
            "objectColor": CORAL,
            "lightColor": (1.0, 0.96, 0.90),
            "lightPos": LAMP,
            "viewPos": EYE,
            "ambientStrength": ambient,
            "diffuseStrength": diffuse,
            "specularStrength": specular,
            "shininess": 32.0,
        },
        state=State(depth=Depth(), cell=Cell(column=0, row=row, columns=1, rows=3)),
    )


def rows(name, **target):
    """Ring and ball with the parts apart, and together."""
    ring, ball = assets.torus(0.74, 0.27), assets.sphere(0.62, segments=64, rings=32)
    draws = []
    for row, strengths in enumerate(ROWS):
        draws.append(thing(ball, translate((-1.25, 0.62, 0.3)), strengths, row))
        draws.append(thing(ring, LEANING, strengths, row))
    return Pass(
        name=name,
        target=Target(depth="depth24", clear=(0.01, 0.012, 0.016, 1.0), **target),
        draws=draws,
    )


POINT = {
    "lightColor": (1.0, 1.0, 1.0),
    "FragPos": (0.0, 0.0, 0.0),
    "Normal": (0.0, 0.0, 1.0),
    "lightPos": (1.2, 1.0, 2.0),
    "viewPos": (0.0, 0.0, 3.0),
    "ambientStrength": 0.1,
    "diffuseStrength": 1.0,
    "specularStrength": 0.5,
}

case = Case(
    title="Specular light",
    section="5.2.3",
    math=r"s = \max(R \cdot V,\ 0)^{32}, \qquad R = 2\,(N \cdot L)\,N - L, \qquad "
    r"C = (k_a + k_d\, d + k_s\, s)\, L_c \odot O",
    passes=(
        *both_ways(rows("scene", size=(1024, 1024), colors={"FragColor": "rgba16f"})),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        *both_ways(rows("judged")),
    ),
    picture="picture.FragColor",
    expect=[
        formula("gl_Position", clip_position),
        formula("FragPos", world_position),
        formula("Normal", world_normal),
        formula("spec", specular_factor, name="lobe on the ring"),
        formula("spec", specular_factor, draw=0, name="lobe on the ball"),
        formula("FragColor", phong_color, draw=0, name="ball, all parts"),
        formula("FragColor", phong_color, draw=1, name="ring, all parts"),
        formula("FragColor", phong_color, draw=3, name="ring, specular part"),
        formula("FragColor", phong_color, draw=5, name="ring, ambient and diffuse part"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("judged.FragColor"),
        value(
            "spec",
            at={**POINT, "shininess": 1.0},
            equals=0.788110,
            digits=6,
            name="cosine at the point",
        ),
        value(
            "spec",
            at={**POINT, "shininess": 32.0},
            equals=0.000490666,
            digits=9,
            name="its 32nd power",
        ),
        value(
            "FragColor",
            at=POINT,
            equals=(0.888356, 0.444178, 0.275390, 1.0),
            digits=6,
            name="colour at the point",
        ),
        value(
            "spec",
            at={**POINT, "viewPos": (2.0, 0.0, 1.215), "shininess": 0.5},
            equals=0.071075,
            digits=6,
            name="nearly 90° from the mirrored ray",
        ),
        sweep(
            "spec",
            specular_factor,
            over="shininess",
            values=[2.0 ** (k / 4.0) for k in range(33)],
            at=POINT,
            log_x=True,
            name="the point's highlight over the shininess",
        ),
    ],
)
