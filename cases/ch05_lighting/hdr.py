"""High dynamic range: light has no upper end, a display has one, and a curve leads between them.

A lamp is a hundred times as bright as the wall beside it. A framebuffer of eight bits cuts
everything above 1 at once: twelve times white and three times white become the same white. A
framebuffer of half floats (RGBA16F) keeps the numbers, and a tone curve at the end makes room for
all of them: Reinhard's x / (1 + x), or 1 − exp(−x·e) with an exposure e that one can turn.

Look at: one corridor, drawn once, shown four times. Upper left it is clipped, and its end is a flat
white hole. Upper right Reinhard's curve shows the bricks there. Below is the exponential curve,
on the left with an exposure of 0.25 for the far end, on the right with 4 for what is near.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    Texture,
    across,
    any_order,
    assets,
    both_ways,
    exact,
    formula,
    fullscreen,
    measure,
    reading,
    sweep,
    value,
)
from shaderlab.glslmath import clamp, dot, max as larger, normalize, pow, swizzle, vec4
from shaderlab.reference import tone_mapping
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

from ..scenes.colour_science import delta_e_2000

CLIPPED, REINHARD, EXPOSURE = 0, 1, 2
# Past 1, at 1 and below it; exact in half floats.
BRIGHT = (12.5, 3.0, 0.25)


def corridor(repeat):
    """A corridor along −z, two wide and two high, open towards the viewer."""
    walls = []
    for turn in (0.0, 90.0, 180.0, 270.0):
        wall = assets.moved(assets.plane(2.0), np.diag([1.0, 1.0, 7.0, 1.0]))
        wall["attributes"]["aTexCoords"] *= np.float32((repeat, 7 * repeat))
        wall = assets.moved(wall, translate((0.0, -1.0, 0.0)))
        walls.append(assets.moved(wall, rotate(radians(turn), (0.0, 0.0, 1.0))))
    end = assets.moved(assets.quad(2.0), translate((0.0, 0.0, -7.0)))
    end["attributes"]["aTexCoords"] *= np.float32(repeat)
    return assets.joined(*walls, end)


def room(name, **target):
    """The corridor with a floodlight at its end and two small lamps nearby."""
    model = translate((0.0, 0.0, -1.0)) @ rotate(radians(4.0), (0.0, 0.0, 1.0))
    draw = Draw(
        vertex="ch05_lighting/lit_textured.vert",
        fragment="ch05_lighting/hdr_scene.frag",
        mesh=Mesh(**corridor(1.0)),
        uniforms={
            "model": model,
            "normalMatrix": normal_matrix(model),
            "view": look_at((0.0, 0.0, 5.4), (0.0, 0.0, -1.0)),
            "projection": perspective(radians(42.0), 1.0, 0.1, 60.0),
            "lampPos": [(0.1, 0.2, -6.4), (-0.7, -0.55, 0.6), (0.75, 0.35, 2.9)],
            "lampColor": [(60.0, 52.0, 40.0), (0.9, 0.30, 0.08), (0.05, 0.12, 0.32)],
        },
        textures={"diffuseTexture": Texture(image=lambda: assets.brick_wall(512))},
        state=State(depth=Depth()),
    )
    return Pass(name=name, target=Target(depth="depth24", **target), draws=(draw,))


def shown(column, row, curve, exposure):
    """The corridor through one of the curves, in a quarter of the picture."""
    return Draw(
        fragment="ch05_lighting/hdr.frag",
        domain={"TexCoords": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))},
        uniforms={"curve": curve, "exposure": exposure},
        textures={"hdrBuffer": Output("hdr", "FragColor")},
        state=State(cell=Cell(column=column, row=row, columns=2, rows=2)),
    )


def lit(FragPos, Normal, TexCoords, diffuseTexture, lampPos, lampColor):
    """Diffuse light of all lamps, each fading with the square of its distance."""
    light = 0.01
    for place, color in zip(lampPos, lampColor, strict=True):
        ray = place - FragPos
        diff = larger(dot(normalize(Normal), normalize(ray)), 0.0)
        light = light + color * diff / dot(ray, ray)
    return vec4(light * swizzle(texture(diffuseTexture, TexCoords), "rgb"), 1.0)


def through(curve):
    """A pixel of the picture: the curve on each of four texels, their mean, the gamma."""

    def mean_of_four(hdrBuffer, TexCoords, exposure):
        height, width = hdrBuffer.texels.values.shape[:2]

        def mapped(x, y):
            place = TexCoords + np.array([x / width, y / height])
            return curve(swizzle(texture(hdrBuffer, place), "rgb"), exposure)

        total = mapped(-0.5, -0.5) + mapped(0.5, 0.5) + mapped(-0.5, 0.5) + mapped(0.5, -0.5)
        return vec4(pow(clamp(0.25 * total, 1.0e-6, 1.0), 1.0 / 2.2), 1.0)

    return mean_of_four


def clip(light, exposure):
    """No curve at all."""
    return tone_mapping.clipped(light)


def reinhard(light, exposure):
    """Reinhard's curve; it has no exposure."""
    return tone_mapping.reinhard(light)


def mean_difference(picture, column, row, where_white):
    """The mean ΔE 2000 between the clipped quarter of the picture, upper left, and another one;
    of all pixels, or of those that clipping makes plain white."""
    height, width = picture.shape[0] // 2, picture.shape[1] // 2
    quarters = picture[..., :3].reshape(2, height, 2, width, 3).swapaxes(1, 2)
    clipped, other = quarters[1, 0], quarters[int(row), int(column)]
    found = delta_e_2000(clipped, other)
    return found[(clipped == 1.0).all(axis=-1)].mean() if where_white else found.mean()


def difference(label, column, row, low, high, where_white=False):
    """One row of the table of differences."""
    given = {"column": column, "row": row, "where_white": where_white}
    return reading(label, given=given, between=(low, high))


def curve_of(which, light, exposure, equals):
    """A figure of one of the curves."""
    return value(
        which,
        at={"light": light, "exposure": exposure},
        equals=equals,
        digits=6,
        name=f"{which} of {light:g} at {exposure:g}",
    )


BRIGHT_PASS = {"domain": {}, "uniforms": {"glow": BRIGHT}}

case = Case(
    title="High dynamic range",
    section="5.11",
    math=r"\text{Reinhard: } \frac{x}{1 + x}, \qquad \text{exposure: } 1 - e^{-x\,e}",
    passes=(
        *both_ways(room("hdr", size=(512, 512), colors={"FragColor": "rgba16f"})),
        Pass(
            name="picture",
            draws=(
                shown(0, 1, CLIPPED, 1.0),
                shown(1, 1, REINHARD, 1.0),
                shown(0, 0, EXPOSURE, 0.25),
                shown(1, 0, EXPOSURE, 4.0),
            ),
        ),
        *both_ways(room("judged")),
        *fullscreen(
            "ch05_lighting/lamp.frag",
            name="half-floats",
            target=Target(size=(4, 4), colors={"FragColor": "rgba16f"}),
            **BRIGHT_PASS,
        ),
        *fullscreen(
            "ch05_lighting/lamp.frag",
            name="bytes",
            target=Target(size=(4, 4), colors={"FragColor": "rgba8"}),
            **BRIGHT_PASS,
        ),
        *fullscreen(
            "ch05_lighting/hdr_curves.frag",
            name="curves",
            domain={"light": across(0.0, 8.0)},
            uniforms={"exposure": 1.0},
        ),
    ),
    picture="picture.FragColor",
    expect=[
        any_order("hdr.FragColor"),
        any_order("judged.FragColor"),
        formula("judged.gl_Position", clip_position),
        formula("judged.FragPos", world_position),
        formula("judged.Normal", world_normal),
        formula("judged.FragColor", lit, name="light in the corridor"),
        value(
            "judged.FragColor",
            at={
                "FragPos": (0.0, 0.0, 4.0),
                "Normal": (0.0, 0.0, 1.0),
                "TexCoords": (0.5, 0.5),
            },
            equals=(0.005253, 0.005078, 0.004728, 1.0),
            digits=6,
            name="turned away from all lamps",
        ),
        value(
            "judged.FragColor",
            at={
                "FragPos": (0.0, 0.0, 4.0),
                "Normal": (0.0, 0.0, -2.0),
                "TexCoords": (0.5, 0.5),
            },
            equals=(0.344580, 0.286686, 0.246223, 1.0),
            digits=6,
            name="facing the lamps, its normal not of length 1",
        ),
        exact("half-floats.FragColor", (*BRIGHT, 1.0), name="half floats keep what is past 1"),
        exact("bytes.FragColor", (255, 255, 64, 255), name="eight bits cut it"),
        formula("picture.FragColor", through(clip), draw=0, name="clipped"),
        formula("picture.FragColor", through(reinhard), draw=1, name="Reinhard"),
        formula("picture.FragColor", through(tone_mapping.exposed), draw=2, name="exposure 0.25"),
        formula("picture.FragColor", through(tone_mapping.exposed), draw=3, name="exposure 4"),
        measure(
            "mean ΔE 2000 from clipping",
            mean_difference,
            reads={"picture": "picture.FragColor"},
            readings=[
                difference("Reinhard", 1, 1, 3.0, 3.6),
                difference("Reinhard, where clipping is white", 1, 1, 6.0, 7.0, True),
                difference("exposure 0.25", 0, 0, 15.0, 16.0),
                difference("exposure 4", 1, 0, 19.0, 20.2),
                difference("exposure 4, where clipping is white", 1, 0, 0.0, 0.5, True),
            ],
        ),
        formula("curves.byReinhard", tone_mapping.reinhard),
        formula("curves.byExposure", tone_mapping.exposed),
        formula("curves.clipped", tone_mapping.clipped),
        curve_of("curves.byReinhard", 1.0, 1.0, 0.5),
        curve_of("curves.byReinhard", 3.0, 1.0, 0.75),
        curve_of("curves.byReinhard", 12.5, 1.0, 0.925926),
        curve_of("curves.byExposure", 1.0, 1.0, 0.632121),
        curve_of("curves.byExposure", 3.0, 0.5, 0.776870),
        curve_of("curves.byExposure", 12.5, 0.1, 0.713495),
        curve_of("curves.clipped", 12.5, 1.0, 1.0),
        curve_of("curves.clipped", 3.0, 1.0, 1.0),
        sweep(
            "curves.byReinhard",
            tone_mapping.reinhard,
            over="light",
            values=np.geomspace(0.01, 100.0, 65),
            log_x=True,
            name="Reinhard's curve",
        ),
        sweep(
            "curves.byExposure",
            tone_mapping.exposed,
            over="light",
            values=np.geomspace(0.01, 100.0, 65),
            log_x=True,
            name="the exponential curve",
        ),
    ],
)
