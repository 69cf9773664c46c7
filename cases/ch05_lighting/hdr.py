"""High dynamic range: light has no upper end, a display has one, and a curve leads between them.

A lamp is a hundred times as bright as the wall beside it. A framebuffer of eight bits cuts
everything above 1 at once: twelve times white and three times white become the same white. A
framebuffer of half floats (RGBA16F) keeps the numbers, and a tone curve at the end makes room for
all of them: Reinhard's x / (1 + x), or 1 − exp(−x·e) with an adjustable exposure e.

Look at: one corridor, drawn once, shown four times. Upper left it is clipped, and its end is a flat
white hole. Upper right Reinhard's curve shows the bricks there. Below is the exponential curve, on
the left with an exposure of 0.25 for the far end, on the right with 4 for what is near.

Try: in `lib/tone.glsl` write `min(light, 1.0)` for `light / (1.0 + light)`: Reinhard's picture
clips like the one beside it.
"""

import numpy as np

from shaderlab import (
    Case,
    Output,
    Texture,
    across,
    any_order,
    both_ways,
    exact,
    formula,
    measure,
    reading,
    sweep,
)
from shaderlab.glslmath import dot, max as larger, normalize, swizzle, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import tone_mapping
from shaderlab.reference.transforms import translate

from ..scenes import lit, painted_textures
from ..scenes.cameras import camera, turned
from ..scenes.colour_science import delta_e_2000
from ..scenes.corridor import corridor
from ..scenes.figures import figures
from ..scenes.panels import WHOLE, cell, panel, panel_pass, picture
from ..scenes.studio import mean_of_four

# Past 1, at 1 and below it; exact in half floats.
BRIGHT = (12.5, 3.0, 0.25)
LAMPS = {
    "lampPos": [(0.1, 0.2, -6.4), (-0.7, -0.55, 0.6), (0.75, 0.35, 2.9)],
    "lampColor": [(60.0, 52.0, 40.0), (0.9, 0.30, 0.08), (0.05, 0.12, 0.32)],
}


def room(name, size=None, **target):
    """The corridor with a floodlight at its end and two small lamps nearby."""
    draw = lit.thing(
        "ch05_lighting/hdr_scene.frag",
        corridor(),
        translate((0.0, 0.0, -1.0)) @ turned(4.0, (0.0, 0.0, 1.0)),
        camera((0.0, 0.0, 5.4), (0.0, 0.0, -1.0), 42.0, far=60.0),
        LAMPS,
        vertex=lit.TEXTURED,
        textures={"diffuseTexture": Texture(image=lambda: painted_textures.brick_wall(512))},
    )
    return picture([draw], size, name, depth="depth24", **target)


def shown(quarter, curve, exposure):
    """The corridor through one of the curves, in a quarter of the picture."""
    return panel(
        "ch05_lighting/hdr.frag",
        WHOLE,
        {"curve": curve, "exposure": exposure},
        textures={"hdrBuffer": Output("hdr.FragColor")},
        cell=cell(quarter, 2, 2),
    )


CLIPPED, REINHARD, EXPOSURE = 0, 1, 2
# An exposure of 2 shows where the other curves use it, too.
QUARTERS = [shown(2, CLIPPED, 2.0), shown(3, REINHARD, 2.0)]
QUARTERS += [shown(0, EXPOSURE, 0.25), shown(1, EXPOSURE, 4.0)]


def bright(name, format):
    """A colour past 1 in one format."""
    glow, colors = {"glow": BRIGHT}, {"FragColor": format}
    return panel_pass(name, "ch05_lighting/lamp.frag", {}, glow, size=(4, 4), colors=colors)


def lit_by_lamps(FragPos, Normal, TexCoords, diffuseTexture, lampPos, lampColor):
    """Diffuse light of all lamps, each fading with the square of its distance."""
    light = 0.01
    for place, color in zip(lampPos, lampColor, strict=True):
        ray = place - FragPos
        diff = larger(dot(normalize(Normal), normalize(ray)), 0.0)
        light = light + color * diff / dot(ray, ray)
    return vec4(light * swizzle(texture(diffuseTexture, TexCoords), "rgb"), 1.0)


def through(curve):
    """A pixel of the picture: the curve on each of four texels, their mean, the gamma."""

    def color(hdrBuffer, TexCoords, exposure):
        def mapped(place):
            return curve(swizzle(texture(hdrBuffer, place), "rgb"), exposure)

        return mean_of_four(hdrBuffer, TexCoords, mapped)

    return color


def clip(light, exposure):
    """No curve at all."""
    return tone_mapping.clipped(light)


def reinhard(light, exposure):
    """Reinhard's curve; it has no exposure."""
    return tone_mapping.reinhard(light)


CURVES = {"clipped": clip, "Reinhard": reinhard}
CURVES |= dict.fromkeys(("exposure 0.25", "exposure 4"), tone_mapping.exposed)


def mean_difference(picture, column, row, where_white):
    """The mean ΔE 2000 between the clipped quarter of the picture, upper left, and another one;
    of all pixels, or of those that clipping makes plain white."""
    height, width = picture.shape[0] // 2, picture.shape[1] // 2
    quarters = picture[..., :3].reshape(2, height, 2, width, 3).swapaxes(1, 2)
    clipped, other = quarters[1, 0], quarters[int(row), int(column)]
    found = delta_e_2000(clipped, other)
    return found[(clipped == 1.0).all(axis=-1)].mean() if where_white else found.mean()


# About what an eye just notices: Mahy, Van Eycken and Oosterlinck, "Evaluation of Uniform Color
# Spaces", Color Research and Application 19(2), 1994.
NOTICED = 2.3


def difference(label, column, row, where_white=False, **bound):
    """One row of the table of differences."""
    given = {"column": column, "row": row, "where_white": where_white}
    return reading(label, given=given, **(bound or {"at_least": NOTICED}))


def curve_of(output, *rows):
    """Figures of one of the curves: light, exposure, what is shown."""
    named = {
        f"{output} of {light:g} at {exposure:g}": ({"light": light, "exposure": exposure}, equals)
        for light, exposure, equals in rows
    }
    return figures(output, named)


SHADER = "ch05_lighting/hdr_curves.frag"
FACING = (0.344580, 0.286686, 0.246223, 1.0)
HERE = {"FragPos": (0.0, 0.0, 4.0), "Normal": (0.0, 0.0, 1.0), "TexCoords": (0.5, 0.5)}

case = Case(
    title="High dynamic range",
    section="5.11",
    math=r"\text{Reinhard: } \frac{x}{1 + x}, \qquad \text{exposure: } 1 - e^{-x\,e}",
    passes=(
        *both_ways(room("hdr", size=(512, 512), colors={"FragColor": "rgba16f"})),
        picture(QUARTERS, None),
        *both_ways(room("judged")),
        bright("half-floats", "rgba16f"),
        bright("bytes", "rgba8"),
        panel_pass("curves", SHADER, {"light": across(0.0, 8.0)}, {"exposure": 2.0}),
    ),
    picture="picture.FragColor",
    rows=("clipped, Reinhard", "exposure 0.25, exposure 4"),
    expect=[
        any_order("hdr.FragColor"),
        any_order("judged.FragColor"),
        *lit.vertex_stage_checks(
            "gl_Position", "FragPos", "Normal", "TexCoords", pass_name="judged"
        ),
        formula("judged.FragColor", lit_by_lamps, name="light in the corridor"),
        *figures(
            "judged.FragColor",
            {
                "turned away from all lamps": ({}, (0.005253, 0.005078, 0.004728, 1.0)),
                "facing the lamps, its normal not of length 1": ({"Normal": (0, 0, -2)}, FACING),
            },
            at=HERE,
        ),
        exact("half-floats.FragColor", (*BRIGHT, 1.0), name="half floats keep what is past 1"),
        exact("bytes.FragColor", (255, 255, 64, 255), name="eight bits cut it"),
        *(
            formula("picture.FragColor", through(curve), draw=k, name=name)
            for k, (name, curve) in enumerate(CURVES.items())
        ),
        # Every curve is seen to differ, but a long exposure where clipping is white as well.
        measure(
            "mean ΔE 2000 from clipping",
            mean_difference,
            reads={"picture": "picture.FragColor"},
            readings=[
                difference("Reinhard", 1, 1),
                difference("Reinhard, where clipping is white", 1, 1, True),
                difference("exposure 0.25", 0, 0),
                difference("exposure 4", 1, 0),
                difference("exposure 4, where clipping is white", 1, 0, True, at_most=NOTICED),
            ],
        ),
        formula("curves.byReinhard", tone_mapping.reinhard),
        formula("curves.byExposure", tone_mapping.exposed),
        formula("curves.clipped", tone_mapping.clipped),
        *curve_of("curves.byReinhard", (1.0, 1.0, 0.5), (3.0, 1.0, 0.75), (12.5, 1.0, 0.925926)),
        *curve_of(
            "curves.byExposure", (1.0, 1.0, 0.632121), (3.0, 0.5, 0.776870), (12.5, 0.1, 0.713495)
        ),
        *curve_of("curves.clipped", (12.5, 1.0, 1.0), (3.0, 1.0, 1.0)),
        *(
            sweep(
                f"curves.{output}",
                curve,
                over="light",
                values=np.geomspace(0.01, 100.0, 65),
                log_x=True,
                name=name,
            )
            for output, curve, name in (
                ("byReinhard", tone_mapping.reinhard, "Reinhard's curve"),
                ("byExposure", tone_mapping.exposed, "the exponential curve"),
            )
        ),
    ],
)
