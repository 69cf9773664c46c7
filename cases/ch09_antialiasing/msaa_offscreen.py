"""Multisampling off the screen: a framebuffer whose attachments have samples, and its resolve.

A multisampled texture can't be filtered; a shader reads it sample by sample (sampler2DMS and
texelFetch), or glBlitFramebuffer resolves it into a texture of one value a pixel. For colours the
resolve is the mean of the samples, which the shader works out as well, to compare. Depth has as
many samples as colour: the depth test is made for each, so that the edge where two boxes cut
through each other is smoothed like an outline.

Look at: two boxes that stand in each other, enlarged. On the left of the orange line is only the
first of each pixel's four samples, on the right the mean of all four.
"""

from math import radians

from shaderlab import Case, Output, Pass, Ramp, Target, exact, formula, fullscreen, value
from shaderlab.assets import solids
from shaderlab.glslmath import floor
from shaderlab.reference.transforms import (
    clip_position,
    look_at,
    perspective,
    rotate,
    translate,
    world_normal,
)
from shaderlab.sampling import texelFetch

from ..scenes import stage
from ..scenes.props import tile
from ..scenes.studio import handed_on, studio_color

SIZE = (96, 64)
VIEW = look_at((1.3, 1.5, 3.4), (0.0, 0.35, 0.0))
PROJECTION = perspective(radians(36.0), 1.5, 0.1, 20.0)
MODELS = (
    translate((-0.12, 0.5, 0.0)) @ rotate(radians(20.0), (0.0, 1.0, 0.0)),
    translate((0.30, 0.42, 0.22)) @ rotate(radians(52.0), (0.3, 1.0, 0.1)),
)
COLORS = ((0.12, 0.42, 0.48), (0.72, 0.30, 0.16))


def box(k):
    """One of the two boxes."""
    solid = solids.painted(solids.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), COLORS[k])
    return stage.prop(solid, VIEW, PROJECTION, model=MODELS[k])


def scene(order):
    """The boxes and the floor, in an order, with four samples a pixel."""
    draws = (stage.prop(tile(1.5, 0.5), VIEW, PROJECTION), box(0), box(1))
    return tuple(draws[k] for k in order)


def target(samples=4):
    """So many samples a pixel, for colour and depth."""
    colors = {"FragColor": "rgba32f"}
    return Target(size=SIZE, samples=samples, depth="depth24", colors=colors, clear=stage.SKY)


def read(name, of, size):
    """The samples, their mean, and what the resolve made of them."""
    (drawn,) = fullscreen(
        "ch09_antialiasing/mean_of_samples.frag",
        name=name,
        domain={"at": Ramp((0.0, 0.0), (float(SIZE[0]), 0.0), (0.0, float(SIZE[1])))},
        uniforms={"half_": SIZE[0] / 2.0},
        textures={"resolved": Output(of, "FragColor"), "samples": Output(of, "FragColor")},
        target=Target(size=size),
    )
    return drawn


def mean_of_samples(at, samples):
    """A quarter of each of the four."""
    texel = floor(at)
    one, two, three, four = (texelFetch(samples, texel, k) for k in range(4))
    return (one + two + three + four) * 0.25


case = Case(
    title="Multisampling off the screen",
    section="9.3",
    math=r"C = \frac 1n \sum_{i=1}^{n} C_i",
    passes=(
        Pass(name="scene", target=target(), draws=scene((0, 1, 2))),
        Pass(name="reordered", target=target(), draws=scene((2, 1, 0))),
        Pass(name="single", target=target(0), draws=scene((0, 1, 2))),
        Pass(name="turned", target=target(0), draws=scene((2, 1, 0))),
        read("judged", "scene", SIZE),
        read("again", "reordered", SIZE),
        read("picture", "scene", (960, 640)),
    ),
    picture="picture.FragColor",
    expect=[
        formula("judged.mean", mean_of_samples, name="the shader's mean of the samples"),
        formula("judged.blitted", mean_of_samples, name="the resolve is the mean of the samples"),
        exact(
            "judged.mean",
            Output("again", "mean"),
            name="every sample shows the nearest, in whichever order it is drawn",
        ),
        *(
            formula("single.FragColor", studio_color, draw=k, name=f"colour of draw {k}")
            for k in range(3)
        ),
        *(
            value(
                "single.FragColor",
                at={"Color": (light, light, light), "Normal": (0.0, 2.0, 0.0)},
                equals=(shown, shown, shown, 1.0),
                digits=6,
                reference=studio_color,
                name=name,
            )
            for name, light, shown in (
                ("grey, facing up", 0.5, 0.742866),
                ("black", 0.0, 0.001874),
                ("too bright", 4.0, 1.0),
            )
        ),
        exact("single.FragColor", Output("turned", "FragColor"), name="one sample, in any order"),
        formula("scene.gl_Position", clip_position),
        formula("scene.Normal", world_normal),
        formula("scene.Color", handed_on),
    ],
)
