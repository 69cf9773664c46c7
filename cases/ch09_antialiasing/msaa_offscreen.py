"""Multisampling off screen: a framebuffer whose attachments have samples, and its resolve.

A multisampled texture can't be filtered; a shader reads it sample by sample (sampler2DMS and
texelFetch), or glBlitFramebuffer resolves it into a texture of one value a pixel. The driver may
choose how; drivers take the mean of the samples, which the shader works out as well. Depth has as
many samples as colour: the depth test is made for each, so that the edge where two boxes cut
through each other is smoothed like an outline.

Look at: two intersecting boxes, enlarged. On the left of the orange line is only the first of each
pixel's four samples, on the right the mean of all four.

Try: in `ch09_antialiasing/mean_of_samples.frag` write `0.5 + texelFetch(samples, texel, 0) - mean :
mean` for `texelFetch(samples, texel, 0) : mean`: on the left only edges are not grey, where the
first sample is not the mean.
"""

from shaderlab import Case, Output, exact, formula
from shaderlab.glslmath import abs, floor, swizzle, vec4, where
from shaderlab.glslmath.sampling import texelFetch
from shaderlab.reference.transforms import clip_position, translate, world_normal

from ..scenes import painted_solids as solids, stage
from ..scenes.cameras import camera, turned
from ..scenes.figures import each_draw, figures
from ..scenes.panels import panel_pass, picture, rectangle
from ..scenes.studio import handed_on, studio_color

SIZE = (96, 64)
PIXELS, HALF = {"at": rectangle((0.0, 0.0), SIZE)}, {"half_": SIZE[0] / 2.0 + 0.5}
CAMERA = camera((1.3, 1.6, 3.4), (0.06, 0.40, 0.1), 27.5, 1.5)
CUBE = solids.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
FLOOR = solids.painted(solids.box((-1.1, -0.1, -1.1), (1.1, 0.0, 1.1)), (0.62, 0.58, 0.50))
TEAL, RUST = (solids.painted(CUBE, c) for c in ((0.12, 0.42, 0.48), (0.72, 0.30, 0.16)))
DRAWS = (
    stage.prop(FLOOR, CAMERA),
    stage.prop(TEAL, CAMERA, model=translate((-0.12, 0.5, 0.0)) @ turned(20.0)),
    stage.prop(RUST, CAMERA, model=translate((0.30, 0.42, 0.22)) @ turned(52.0, (0.3, 1.0, 0.1))),
)
SOLIDS = {0: "the floor", 1: "the teal box", 2: "the rust box"}

NEAREST = "every sample shows the nearest, in whichever order it is drawn"
TENFOLD = "the picture, enlarged tenfold"
# A grey surface that faces up, and the grey that it has in the studio.
GREYS = {"grey, facing up": (0.5, 0.742866), "black": (0.0, 0.0), "too bright": (4.0, 1.0)}


def scene(name, draws, samples=4):
    """The boxes and the floor, with so many samples a pixel for colour and depth."""
    target = {"samples": samples, "depth": "depth24", "colors": {"FragColor": "rgba32f"}}
    return picture(draws, SIZE, name, clear=stage.SKY, **target)


def read(name, of, size, *outputs):
    """The samples, their mean, and what the resolve made of them; some of it."""
    both = dict.fromkeys(("resolved", "samples"), Output(f"{of}.FragColor"))
    shader, colors = "ch09_antialiasing/mean_of_samples.frag", dict.fromkeys(outputs, "rgba32f")
    return panel_pass(name, shader, PIXELS, HALF, size=size, textures=both, colors=colors)


def shown(at, samples, half):
    """The first sample on the left, the mean on the right, orange between."""
    x = swizzle(at, "x")
    scene = where(x < half, texelFetch(samples, floor(at), 0), mean_of_samples(at, samples))
    line = vec4(0.95, 0.55, 0.10, 1.0)
    return vec4(swizzle(where(abs(x - half) < 0.5, line, scene), "xyz"), 1.0)


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
        scene("scene", DRAWS),
        scene("reordered", DRAWS[::-1]),
        scene("single", DRAWS, samples=0),
        scene("turned", DRAWS[::-1], samples=0),
        read("judged", "scene", SIZE, "FragColor", "mean", "blitted"),
        read("again", "reordered", SIZE, "mean"),
        read("picture", "scene", (960, 640), "FragColor"),
    ),
    picture="picture.FragColor",
    expect=[
        formula("judged.FragColor", shown, name="one sample, and all of them"),
        exact("picture.FragColor", Output("judged.FragColor"), name=TENFOLD),
        formula("judged.mean", mean_of_samples, name="the shader's mean of the samples"),
        formula("judged.blitted", mean_of_samples, name="the resolve is the mean of the samples"),
        exact("judged.mean", Output("again.mean"), name=NEAREST),
        *each_draw("single.FragColor", studio_color, SOLIDS, "colour of {}"),
        *figures(
            "single.FragColor",
            {
                name: ({"Color": (light,) * 3, "Normal": (0.0, 2.0, 0.0)}, (*(shown,) * 3, 1.0))
                for name, (light, shown) in GREYS.items()
            },
            reference=studio_color,
        ),
        exact("single.FragColor", Output("turned.FragColor"), name="one sample, in any order"),
        *each_draw("scene.gl_Position", clip_position, SOLIDS, "{} in clip space"),
        *each_draw("scene.Normal", world_normal, SOLIDS, "normals of {}"),
        *each_draw("scene.Color", handed_on, SOLIDS, "colours of {}"),
    ],
)
