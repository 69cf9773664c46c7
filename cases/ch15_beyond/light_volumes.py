"""Light volumes: each lamp is drawn as a ball, and costs what the ball covers.

With a G-buffer a lamp can light any pixel, but most lamps light few. So each is drawn as a mesh
around a ball: its back faces, without a depth test, so that each pixel is met once, also with the
camera inside. What they cover reads the buffer, and the light is added up. Beyond the root of Kq r²
+ Kl r + Kc = I/τ less than τ is left, here half a code of the darkest stone at dusk. A well-known
listing cuts at 5/256: on black, encoded for a display, those are 43 codes, and edges are seen. Half
a code wants balls of 1.8 here, a dozen on a pixel, and 72 halves still add up to some codes:
engines make light end at a distance instead.

Look at: 72 candles around nine posts at dusk. A pixel asks only the few that reach it.

Try: in `ch15_beyond/light_volume.vert` write `0.1 * reach * aPos` for `reach * aPos`: the light
ends at the edges of polyhedra.
"""

import math

import numpy as np

from shaderlab import (
    Blend,
    Case,
    Draw,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    any_order,
    assets,
    formula,
    measure,
)
from shaderlab.glslmath import normalize, swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import in_view

from ..scenes import lit
from ..scenes.cameras import camera
from ..scenes.candles import COLORS, CONSTANT, LINEAR, PLACES, QUADRATIC, sum_of
from ..scenes.draws import twins
from ..scenes.figures import results
from ..scenes.laws import unchanged
from ..scenes.panel_checks import smaller_check
from ..scenes.panels import WHOLE, panel_pass
from ..scenes.plaza import MODEL, plaza

FADING = {"lamp.constant": CONSTANT, "lamp.linear": LINEAR, "lamp.quadratic": QUADRATIC}
DUSK, STONE = (0.13, 0.16, 0.30), 0.30
CAMERA = camera((0.0, 6.4, 5.2), (0.0, 0.0, 0.25), 43.0, far=40.0)
SIZES = {"": 480, "small_": 40}
BUFFER = {
    "gPosition": unchanged("FragPos"),
    "gNormal": lambda Normal: normalize(Normal),
    "gAlbedoSpec": lambda Color: vec4(Color, 0.8 * swizzle(Color, "r")),
}


def reach_of(left):
    """Where the brightest lamp has so much light left: the larger root."""
    missing = CONSTANT - COLORS.max() / left
    return (-LINEAR + math.sqrt(LINEAR**2 - 4.0 * QUADRATIC * missing)) / (2.0 * QUADRATIC)


def half_a_code():
    """What light on stone at dusk changes it by half a code; of the channel with least light."""
    before = STONE * min(DUSK) * 0.5
    code = 255.0 * before ** (1.0 / 2.2)
    return (((code + 0.5) / 255.0) ** 2.2 - before) / STONE


REACH = reach_of(half_a_code())
# A sphere of 16 by 8 faces touches the ball in their middles when it is so much larger.
OUTSIDE = 1.0 / (math.cos(math.pi / 16.0) * math.cos(math.pi / 16.0))
BALL = assets.sphere(OUTSIDE, 16, 8)


def buffer(kind):
    """The G-buffer of a plaza."""
    solid = plaza(segments=24 if kind == "" else 16)
    shader, side = "ch05_lighting/deferred_buffer.frag", SIZES[kind]
    draw = lit.thing(shader, solid, MODEL, CAMERA, {}, vertex=lit.PAINTED)
    return Pass(
        name=f"{kind}buffer", target=Target(size=(side, side), depth="depth24"), draws=(draw,)
    )


def volumes(name, kind, count=72):
    """The light of all lamps, or of the first ones."""
    positions = {"aPos": BALL["attributes"]["aPos"]}
    mesh = Mesh(
        attributes=positions,
        indices=BALL["indices"],
        instance_attributes={"lampPlace": PLACES[:count], "lampColor": COLORS[:count]},
    )
    draw = Draw(
        vertex="ch15_beyond/light_volume.vert",
        fragment="ch15_beyond/light_volume.frag",
        mesh=mesh,
        instances=count,
        uniforms={**CAMERA, **FADING, "reach": REACH},
        textures={one: Output(f"{kind}buffer.{one}") for one in BUFFER},
        state=State(cull="front", blend=Blend(source="one", destination="one")),
    )
    return Pass(name=name, target=Target(size=(SIZES[kind],) * 2), draws=(draw,))


def composed(name, kind):
    """Lamps and dusk."""
    textures = {
        "lamps": Output(f"{kind}lamps.FragColor"),
        "gNormal": Output(f"{kind}buffer.gNormal"),
        "gAlbedoSpec": Output(f"{kind}buffer.gAlbedoSpec"),
    }
    of = {"textures": textures, "size": (SIZES[kind],) * 2}
    return panel_pass(name, "ch15_beyond/light_volumes.frag", WHOLE, {"dusk": DUSK}, **of)


def corner(aPos, lampPlace, view, projection, reach):
    """A corner of a lamp's mesh."""
    return in_view(lampPlace + reach * aPos, view, projection)


def dusk_and_lamps(TexCoords, lamps, gNormal, gAlbedoSpec, dusk):
    """What is seen, in light."""
    ambient = dusk * (0.75 + 0.25 * swizzle(texture(gNormal, TexCoords), "y"))
    stone = swizzle(texture(gAlbedoSpec, TexCoords), "rgb")
    return vec4(swizzle(texture(lamps, TexCoords), "rgb") + ambient * stone, 1.0)


def from_sum(light, place, normal, stone):
    """The largest difference of the volumes' light from the sum, by the sum's largest value."""
    truth = sum_of(place, normal, stone[..., :3], REACH)
    return np.abs(light[..., :3] - truth).max() / truth.max()


def codes_missing(count):
    """How many codes of eight bits the first lamps would add if their light had no end."""

    def codes(light, place, normal, stone):
        dusk = np.array(DUSK) * (0.75 + 0.25 * normal[..., 1:2]) * stone[..., :3]
        truth = sum_of(place, normal, stone[..., :3], np.inf, count)
        shown = [np.minimum(dusk + one, 1.0) ** (1.0 / 2.2) for one in (light[..., :3], truth)]
        return 255.0 * (shown[1] - shown[0])[np.any(normal, axis=-1)].max()

    return codes


def read(light):
    """A light, and the small buffer that it is made of."""
    names = zip(("place", "normal", "stone"), BUFFER, strict=True)
    return {"light": f"{light}.FragColor", **{a: f"small_buffer.{b}" for a, b in names}}


LIGHT = {"light": "small_lamps.FragColor"}

case = Case(
    title="Light volumes",
    section="15.13",
    math=r"\frac{I}{K_c + K_l\,r + K_q\,r^2} = \tau, \qquad "
    r"r = \frac{-K_l + \sqrt{K_l^2 - 4 K_q (K_c - I / \tau)}}{2 K_q}",
    passes=(
        buffer(""),
        volumes("lamps", ""),
        composed("scene", ""),
        *lit.picture(size=(240, 240)),
        *twins(buffer("small_"), "gAlbedoSpec"),
        volumes("small_lamps", "small_"),
        volumes("one_lamp", "small_", 1),
        composed("small", "small_"),
    ),
    picture="picture.FragColor",
    expect=[
        *lit.vertex_stage_checks(pass_name="small_buffer"),
        *(formula(f"small_buffer.{name}", law) for name, law in BUFFER.items()),
        any_order("small_buffer.gAlbedoSpec"),
        formula("small_lamps.gl_Position", corner, name="corners of the balls"),
        measure(
            "from the sum over all lamps", from_sum, reads=read("small_lamps"), at_most=2.0**-16
        ),
        measure("codes that one lamp lacks", codes_missing(1), reads=read("one_lamp"), at_most=0.5),
        measure("codes that all lack", codes_missing(72), reads=read("small_lamps"), at_most=8.0),
        measure("lamps a pixel", lambda light: light[..., 3].mean(), reads=LIGHT, at_most=25.0),
        formula("small.FragColor", dusk_and_lamps, name="dusk and lamps"),
        smaller_check("small", edges=0.06),
        lit.picture_check(),
        *results(
            {
                "the reach of the brightest lamp": (REACH, 1.835),
                "light of 5/256 on black, in codes": (255.0 * (5.0 / 256.0) ** (1.0 / 2.2), 42.619),
            },
            digits=3,
        ),
    ],
)
