"""Many lights: light adds up, so each lamp is a function and the picture is their sum.

Six lamps: a moon (directional), four bulbs (point lights, an array of structs) and a spot with a
soft edge. Each is a GLSL function of its own that returns what this lamp adds, and main() only
adds. That is more than tidy: because light is linear, drawing the scene once for each lamp and
adding the images must give the same picture. Forward renderers with many lights rest on it, and so
do these checks.

Look at: how the colours meet. Each bulb tints the balls that face it, between two of them both
colours mix, and the spot's white circle washes them out. In the corners only the moon is left.
"""

from math import cos, radians

from shaderlab import (
    Blend,
    Case,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Output,
    Pass,
    State,
    Target,
    assets,
    compile_fails,
    formula,
    fullscreen,
    value,
)
from shaderlab.assets.order import any_order, both_ways
from shaderlab.glslmath import vec4
from shaderlab.reference import light_sources
from shaderlab.reference.transforms import (
    clip_position,
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

from ..scenes.plaza import plaza
from ..scenes.studio import finished, handed_on

EYE = (4.4, 5.2, 8.6)
CAMERA = {
    "view": look_at(EYE, (0.1, 0.45, 0.0)),
    "projection": perspective(radians(36.0), 1.0, 0.1, 60.0),
}
MODEL = rotate(radians(8.0), (0.0, 1.0, 0.0)) @ scale((1.0, 1.1, 1.0))

# Place and colour of the four bulbs.
BULBS = [
    ((-1.1, 0.75, 2.9), (1.0, 0.32, 0.10)),
    ((1.25, 0.70, 1.0), (0.15, 0.65, 1.0)),
    ((-1.2, 0.90, -0.9), (0.95, 0.15, 0.75)),
    ((1.3, 0.90, -1.4), (0.20, 1.0, 0.35)),
]


def times(factor, color):
    """A colour, brighter or darker."""
    return tuple(factor * channel for channel in color)


def lamp_uniforms():
    """All six lamps: for each, the uniforms that it consists of."""
    lamps = [
        {
            "dirLight.direction": (0.5, -1.0, -0.6),
            "dirLight.ambient": (0.012, 0.016, 0.030),
            "dirLight.diffuse": (0.05, 0.07, 0.13),
            "dirLight.specular": (0.10, 0.12, 0.20),
        }
    ]
    for i, (place, color) in enumerate(BULBS):
        lamps.append(
            {
                f"pointLights[{i}].position": place,
                f"pointLights[{i}].constant": 1.0,
                f"pointLights[{i}].linear": 0.35 + 0.05 * i,
                f"pointLights[{i}].quadratic": 0.90 - 0.08 * i,
                f"pointLights[{i}].ambient": times(0.03, color),
                f"pointLights[{i}].diffuse": times(1.7 + 0.1 * i, color),
                f"pointLights[{i}].specular": times(1.5, color),
            }
        )
    lamps.append(
        {
            "spotLight.position": (-2.6, 5.2, 3.2),
            "spotLight.direction": (2.6, -5.2, -3.0),
            "spotLight.cutOff": cos(radians(9.0)),
            "spotLight.outerCutOff": cos(radians(14.0)),
            "spotLight.constant": 1.0,
            "spotLight.linear": 0.045,
            "spotLight.quadratic": 0.0075,
            "spotLight.ambient": (0.004, 0.004, 0.004),
            "spotLight.diffuse": (1.3, 1.25, 1.1),
            "spotLight.specular": (1.2, 1.1, 1.0),
        }
    )
    return lamps


LAMPS = lamp_uniforms()
ALL = {name: light for lamp in LAMPS for name, light in lamp.items()}


def only(number):
    """All lamps' uniforms, with the colours of all but one black."""
    lit = LAMPS[number]
    return {
        name: light
        if name in lit or name.split(".")[1] not in ("ambient", "diffuse", "specular")
        else (0.0, 0.0, 0.0)
        for name, light in ALL.items()
    }


def lit(mesh, lamps, **state):
    """The plaza in the light of these lamps.

    Back faces are culled: along an outline they may be as near as the front, to all the digits of
    a depth buffer, and a test for equal depth would then add a lamp twice.
    """
    return Draw(
        vertex="ch05_lighting/lit_painted.vert",
        fragment="ch05_lighting/multiple_lights.frag",
        mesh=mesh,
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            **CAMERA,
            "viewPos": EYE,
            "specular": (0.40, 0.38, 0.35),
            "shininess": 32.0,
            **lamps,
        },
        state=State(**{"depth": Depth(), "cull": "back", **state}),
    )


def bulb(place, color):
    """A bulb: a small ball that shines."""
    return Draw(
        vertex="ch05_lighting/lamp.vert",
        fragment="ch05_lighting/lamp.frag",
        mesh=Mesh(**assets.sphere(0.09)).only("aPos"),
        uniforms={
            "model": translate(place),
            "glow": tuple(0.35 + 0.65 * channel for channel in color),
            **CAMERA,
        },
        state=State(depth=Depth()),
    )


BIG, SMALL = Mesh(**plaza()), Mesh(**plaza(tiles=6, segments=16))
NIGHT = (0.002, 0.003, 0.006, 1.0)

scene = Pass(
    name="scene",
    target=Target(size=(1024, 1024), colors={"FragColor": "rgba16f"}, depth="depth24", clear=NIGHT),
    draws=(*(bulb(*lamp) for lamp in BULBS), lit(BIG, ALL)),
)
bulbs = Pass(
    name="bulbs",
    target=Target(depth="depth24"),
    draws=(bulb(*BULBS[0]),),
)
together = Pass(name="together", target=Target(depth="depth24"), draws=(lit(SMALL, ALL),))
ADD = Blend(source="one", destination="one", source_alpha="zero", destination_alpha="one")
added = Pass(
    name="added",
    target=Target(colors={"FragColor": "rgba32f"}, depth="depth24"),
    draws=(
        lit(SMALL, only(0)),
        *(lit(SMALL, only(k), depth=Depth(func="equal"), blend=ADD) for k in range(1, 6)),
    ),
)


def by_moon(
    FragPos, Normal, Color, viewPos, specular, shininess,
    dirLight_direction, dirLight_ambient, dirLight_diffuse, dirLight_specular,
):  # fmt: skip
    """The directional light's part."""
    return light_sources.directional(
        FragPos, Normal, Color, viewPos, specular, shininess,
        dirLight_direction, dirLight_ambient, dirLight_diffuse, dirLight_specular,
    )  # fmt: skip


def by_spot(
    FragPos, Normal, Color, viewPos, specular, shininess,
    spotLight_position, spotLight_direction, spotLight_cutOff, spotLight_outerCutOff,
    spotLight_constant, spotLight_linear, spotLight_quadratic,
    spotLight_ambient, spotLight_diffuse, spotLight_specular,
):  # fmt: skip
    """The spot's part."""
    return light_sources.soft_spot(
        FragPos, Normal, Color, viewPos, specular, shininess,
        spotLight_position, spotLight_direction, spotLight_cutOff, spotLight_outerCutOff,
        spotLight_constant, spotLight_linear, spotLight_quadratic,
        spotLight_ambient, spotLight_diffuse, spotLight_specular,
    )  # fmt: skip


def by_all(
    FragPos, Normal, Color, viewPos, specular, shininess,
    dirLight_direction, dirLight_ambient, dirLight_diffuse, dirLight_specular,
    pointLights_position, pointLights_constant, pointLights_linear, pointLights_quadratic,
    pointLights_ambient, pointLights_diffuse, pointLights_specular,
    spotLight_position, spotLight_direction, spotLight_cutOff, spotLight_outerCutOff,
    spotLight_constant, spotLight_linear, spotLight_quadratic,
    spotLight_ambient, spotLight_diffuse, spotLight_specular,
):  # fmt: skip
    """The sum of all six, with an alpha of 1."""
    surface = (FragPos, Normal, Color, viewPos, specular, shininess)
    moon = by_moon(
        *surface, dirLight_direction, dirLight_ambient, dirLight_diffuse, dirLight_specular
    )
    four = light_sources.points(
        *surface,
        pointLights_position, pointLights_constant, pointLights_linear, pointLights_quadratic,
        pointLights_ambient, pointLights_diffuse, pointLights_specular,
    )  # fmt: skip
    spot = by_spot(
        *surface,
        spotLight_position, spotLight_direction, spotLight_cutOff, spotLight_outerCutOff,
        spotLight_constant, spotLight_linear, spotLight_quadratic,
        spotLight_ambient, spotLight_diffuse, spotLight_specular,
    )  # fmt: skip
    return vec4(moon + four + spot, 1.0)


def glowing(glow):
    """A bulb's own light."""
    return vec4(glow, 1.0)


case = Case(
    title="Multiple lights",
    section="5.6",
    math=r"C = C_{\text{dir}} + \sum_{i=1}^{4} C_{\text{point},i} + C_{\text{spot}}",
    passes=(
        *both_ways(scene),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        bulbs,
        *both_ways(together),
        added,
    ),
    picture="picture.FragColor",
    expect=[
        formula("together.gl_Position", clip_position),
        formula("together.FragPos", world_position),
        formula("together.Normal", world_normal),
        formula("together.Color", handed_on),
        formula("together.directional", by_moon, name="the moon"),
        formula("together.points", light_sources.points, name="the four bulbs"),
        formula("together.spot", by_spot, name="the spot"),
        formula("together.FragColor", by_all, name="all six at once"),
        formula("added.FragColor", by_all, given=ALL, name="one by one, added"),
        formula("bulbs.gl_Position", clip_position, name="where a bulb is"),
        formula("bulbs.FragColor", glowing, name="colour of a bulb"),
        formula("picture.FragColor", finished(texture), name="the picture"),
        any_order("scene.FragColor"),
        any_order("together.FragColor"),
        compile_fails(
            "ch05_lighting/errata/output.frag",
            (7, "'output' : Reserved word."),
            name="a variable called output is refused",
        ),
        value(
            "together.directional",
            at={
                "FragPos": (0.0, 0.0, 0.0),
                "Normal": (0.0, 0.0, 1.0),
                "Color": (1.0, 0.5, 0.31),
                "viewPos": (2.0, 0.0, 1.215),
                "specular": (0.5, 0.5, 0.5),
                "shininess": 0.5,
                "dirLight.direction": (-1.2, -1.0, -2.0),
                "dirLight.ambient": (0.2, 0.2, 0.2),
                "dirLight.diffuse": (0.5, 0.5, 0.5),
                "dirLight.specular": (1.0, 1.0, 1.0),
            },
            equals=(0.629593, 0.332565, 0.219695),
            digits=6,
            reference=by_moon,
            name="nearly 90° from the mirrored ray",
        ),
    ],
    errata=[
        Erratum(
            section="5.6",
            says="vec3 output = vec3(0.0);",
            truth="output is reserved for the future in GLSL: a variable can't be called so",
            proof="a variable called output is refused",
        )
    ],
)
