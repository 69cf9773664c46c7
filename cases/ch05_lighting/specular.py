"""Specular light: a glossy surface reflects the lamp, blurred, in one direction only.

The ray from the lamp is reflected about the normal. A viewer in its path sees a highlight; beside
it the cosine of the angle counts, raised to the power of the shininess. Only this one of the three
parts moves when the viewer does. A face turned away from the lamp has no highlight at all.

Look at: the same ring and ball three times. Above, ambient and diffuse light: chalk. In the middle
the specular part alone: a spot, and a thin loop. Below the sum: chalk became glazed clay.

Try: in `ch05_lighting/specular.frag` write `viewDir, 4.0 * shininess);` for `viewDir, shininess);`:
highlights become half as wide.
"""

import numpy as np

from shaderlab import Case, Erratum, assets, sweep
from shaderlab.reference.lighting import mirrored_lobe, phong_color, specular_factor
from shaderlab.reference.transforms import translate

from ..scenes import lit
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figure, results
from ..scenes.panels import cell

EYE = (0.0, 1.9, 5.6)
LIGHT = {"lightColor": (1.0, 0.96, 0.90), "lightPos": (-1.8, 3.4, 2.4), "viewPos": EYE}
CAMERA = camera(EYE, (-0.14, 0.715, 0.0), 21.0, 3.0)
LEANING = translate((0.85, 0.72, -0.3)) @ turned(58.0, (1.0, -0.25, 0.3))
BALL = assets.sphere(0.62, segments=64, rings=32)
THINGS = (BALL, translate((-1.25, 0.62, 0.3))), (assets.torus(0.74, 0.27), LEANING)

# From below: the sum, the specular part alone, ambient and diffuse part.
ROWS = [(0.1, 0.75, 0.9), (0.0, 0.0, 0.9), (0.1, 0.75, 0.0)]


def strengths(ambient, diffuse, specular):
    """How strong each of the three parts is."""
    return {"ambientStrength": ambient, "diffuseStrength": diffuse, "specularStrength": specular}


def thing(geometry, model, row):
    """One thing in one row, with that row's strengths of the three parts."""
    shader, parts = "ch05_lighting/specular.frag", strengths(*ROWS[row])
    uniforms = {**LIGHT, **parts, "objectColor": lit.CORAL, "shininess": 32.0}
    return lit.thing(shader, geometry, model, CAMERA, uniforms, cell=cell(row, 1, 3))


PARTS = ("all parts", "specular part", "ambient and diffuse part")
NAMES = dict(enumerate(f"{what}, {part}" for part in PARTS for what in ("ball", "ring")))
LAMP = {"lightColor": lit.WHITE, "lightPos": lit.POINT_LAMP}
POINT = {**lit.POINT, **LAMP, **strengths(0.1, 1.0, 0.5)}
BEHIND = {**lit.GRAZING, "lightPos": lit.BELOW, "shininess": 8.0}
# What a lobe gives there that does not ask whether the surface faces the lamp.
UNGATED = mirrored_lobe(np.array(POINT["Normal"]), lit.BELOW, BEHIND["viewPos"], 8.0)
MIRRORED = {"viewPos": (-1.2, -1.0, 2.0), "shininess": 32.0}
STRONGEST = "1 for a viewer in the mirrored ray, at (−1.2, −1, 2)"
GREEN_HIGHLIGHT = "a green thing's highlight in white light"
GREEN = {"lightPos": (0.0, 0.0, 2.0), "objectColor": (0.0, 1.0, 0.0)}
HIGHLIGHT = "the point's highlight over the shininess"
QUARTER_STEPS = {"values": [2.0 ** (k / 4.0) for k in range(33)], "log_x": True}
ASIDE = {"viewPos": lit.ASIDE, "shininess": 0.5}

case = Case(
    title="Specular light",
    section="5.2.3",
    math=r"s = [N \cdot L > 0]\,\max(R \cdot V,\ 0)^{32}, \qquad R = 2\,(N \cdot L)\,N - L, \qquad "
    r"C = (k_a + k_d\, d + k_s\, s)\, L_c \odot O",
    passes=lit.photographed(
        [thing(*one, row) for row in range(3) for one in THINGS], clear=(0.01, 0.012, 0.016, 1.0)
    ),
    picture="picture.FragColor",
    rows=("ambient and diffuse", "specular", "all of them"),
    expect=[
        *lit.vertex_stage_checks(),
        *each_draw("spec", specular_factor, {k: f"lobe, {name}" for k, name in NAMES.items()}),
        *each_draw("FragColor", phong_color, {k: NAMES[k] for k in (0, 1, 3, 5)}),
        *lit.picture_checks(),
        figure("spec", "cosine at the point", {**POINT, "shininess": 1.0}, 0.788110),
        figure("spec", "its 32nd power", {**POINT, "shininess": 32.0}, 0.000490666, digits=9),
        figure("FragColor", "colour at the point", POINT, (0.888356, 0.444178, 0.275390, 1.0)),
        figure("spec", lit.TURNED_AWAY, {**POINT, **BEHIND}, 0.0),
        *results({"a highlight without a gate there": (UNGATED, 0.757792)}),
        figure("FragColor", GREEN_HIGHLIGHT, {**POINT, **GREEN}, (0.0, 1.6, 0.0, 1.0)),
        figure("spec", STRONGEST, {**POINT, **MIRRORED}, 1.0),
        figure("spec", "nearly 90° from the mirrored ray", {**POINT, **ASIDE}, 0.071075),
        sweep("spec", specular_factor, over="shininess", at=POINT, name=HIGHLIGHT, **QUARTER_STEPS),
    ],
    errata=[
        Erratum(
            section="5.2.3",
            says="s = max(R·V, 0)ˢ, whatever side of the surface the lamp is on",
            truth="with the lamp 5° below the surface that is 0.757792 for a viewer 10° above; a "
            "face turned away from the lamp has no highlight (OpenGL 1.0, equation 2.1: f = 0)",
            proof=lit.TURNED_AWAY,
        ),
        Erratum(
            section="5.2.3",
            says="highlights tend to the light's colour more than to the object's",
            truth="on plastic they do, but the formula multiplies all by objectColor: a green "
            "thing's highlight in white light is green",
            proof=GREEN_HIGHLIGHT,
        ),
        Erratum(
            section="5.2.3",
            says="the highlight is at its maximum from everywhere",
            truth="from the mirrored direction alone: 1 at (−1.2, −1, 2), 0.000491 at (0, 0, 3)",
            proof=STRONGEST,
        ),
    ],
)
