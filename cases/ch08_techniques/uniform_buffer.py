"""Uniform buffers: one block of memory that several programs read, at fixed offsets.

Four programs that share projection and view take eight calls a frame to set them. A uniform block
is a piece of a buffer instead: it is written once, and every program that declares it reads the
same bytes. Both sides must agree on where a member lies, so std140 defines it: numbers are aligned
to 4 bytes, a vec3 to 16 like a vec4, elements of an array stand 16 bytes apart even if they are
single floats, and a matrix is an array of its columns. Two mat4 lie at 0 and 64, 128 together.

Look at: four cubes, four programs, one buffer for the matrices and one for the light. The second
has gaps: a float, a vec3, three floats, a vec3 and a mat2 take 56 bytes, and lie in 128.

Try: in `lib/block_light.glsl` write `lights.gains[2], lights.gains[1], lights.gains[0]` for
`lights.gains[0], lights.gains[1], lights.gains[2]`: the light turns bluish for all four programs at
once.
"""

from dataclasses import replace
from math import radians

import numpy as np

from shaderlab import Case, UniformBuffer, assets, block_layout, formula, gl_calls, measure, query
from shaderlab.glslmath import dot, max, mul, normalize, sqrt, swizzle, vec2, vec3, vec4
from shaderlab.reference.rasterisation import samples_passed
from shaderlab.reference.transforms import clip_position, look_at, perspective, rotate, translate

from ..scenes.draws import tested
from ..scenes.figures import figures
from ..scenes.laws import unchanged
from ..scenes.panel_checks import smaller_check, softened_check
from ..scenes.panels import picture, softened_pass

PAPER = (0.13, 0.14, 0.17, 1.0)
PROJECTION = perspective(radians(38.0), 1.0, 0.1, 20.0)
VIEW = look_at((1.6, 2.2, 5.2), (0.0, 0.0, 0.0))
MATRICES = UniformBuffer(values={"projection": PROJECTION, "view": VIEW})
LIGHTS = UniformBuffer(
    values={
        "ambient": 0.25,
        "towards": (0.36, 0.80, 0.48),
        "gains": (0.75, 0.70, 0.60),
        "sky": (0.90, 1.00, 1.10),
        "tint": ((0.05, 0.01), (0.02, 0.06)),
    }
)
COLORS = {
    "red": (0.80, 0.16, 0.12),
    "green": (0.16, 0.55, 0.22),
    "yellow": (0.92, 0.72, 0.12),
    "blue": (0.12, 0.30, 0.78),
}
PLACES = ((-0.75, 0.75), (0.75, 0.75), (-0.75, -0.75), (0.75, -0.75))
CUBE = assets.cube()
OFFSETS = {"projection": 0, "view": 64}
SIDE = 64  # at which targets without a size are judged


def standing(place):
    """The model matrix of a cube."""
    return translate((*place, 0.0)) @ rotate(radians(24.0), (0.3, 1.0, 0.0))


def cube(color, place):
    """A cube of one colour, with the program for that colour."""
    stages = ("uniform_buffer.vert", f"uniform_buffer_{color}.frag")
    shaders, uniforms = (f"ch08_techniques/{name}" for name in stages), {"model": standing(place)}
    draw = tested(tuple(shaders), CUBE, uniforms, only=("aPos", "aNormal"))
    return replace(draw, blocks={"Matrices": MATRICES, "Lights": LIGHTS})


def lit(color):
    """The colour of a cube under the block's light, as a formula."""

    def shaded(Normal, Lights_ambient, Lights_towards, Lights_gains, Lights_sky, Lights_tint):
        """Ambient and sun by channel, a tint by height, encoded by a square root."""
        n = normalize(Normal)
        sun = max(dot(n, Lights_towards), 0.0)
        up = swizzle(n, "y")
        mood = mul(Lights_tint, vec2(max(up, 0.0), max(-up, 0.0)))
        gain = vec3(*Lights_gains)
        light = vec3(*color) * (Lights_ambient * Lights_sky + gain * sun)
        return vec4(sqrt(light + vec3(swizzle(mood, "x"), 0.0, swizzle(mood, "y"))), 1.0)

    return shaded


def in_front():
    """How many samples of each cube pass the depth test, at least and at most."""
    places, triangles = CUBE["attributes"]["aPos"], CUBE["indices"].reshape(-1, 3)
    corners = np.column_stack([places, np.ones(len(places))])
    clip = [corners @ (PROJECTION @ VIEW @ standing(place)).T for place in PLACES]
    return samples_passed([c[triangles] for c in clip], (SIDE, SIDE))


def seen_from_the_eye(color, draw):
    """Where the buffer's matrices put two points: what they are, and not only that they are used.

    The eye is √34.44 from the origin, and looks at it.
    """
    right = (2.775784, -0.320179, 5.451156, 5.595921)
    rows = {
        "the origin lies straight ahead": ((0.0, 0.0, 0.0), (0.0, 0.0, 5.726536, 5.868560)),
        "the eye itself has w = 0": ((1.6, 2.2, 5.2), (0.0, 0.0, -0.201005, 0.0)),
        "one step to the right": ((1.0, 0.0, 0.0), right),
    }
    named = {
        f"{color}: {what}": ({"aPos": point, "model": np.eye(4)}, found)
        for what, (point, found) in rows.items()
    }
    return figures("gl_Position", named, reference=clip_position, draw=draw)


def shaded_by_hand(draw, color):
    """One colour with normals that are longer than 1."""
    rows = {
        f"{color}, {where}": ({"Normal": normal}, (*found[color], 1.0))
        for where, (normal, found) in NORMALS.items()
    }
    return figures("FragColor", rows, reference=lit(COLORS[color]), draw=draw)


def off_paper(FragColor):
    """How far the corners of the picture are from the colour that it was cleared to."""
    return np.abs(FragColor[:: SIDE - 1, :: SIDE - 1] - PAPER).max()


CUBES = [cube(color, place) for color, place in zip(COLORS, PLACES, strict=True)]
# Where a normal looks, and the colour of each cube there.
NORMALS = {
    "from above": ((1.0, 2.0, 2.0), {
        "red": (0.892935, 0.386022, 0.341194), "green": (0.431432, 0.715705, 0.449793),
        "yellow": (0.954952, 0.818877, 0.341194), "blue": (0.384621, 0.528583, 0.826652),
    }),
    "from below": ((1.0, -1.0, 2.0), {
        "red": (0.558082, 0.252540, 0.269777), "green": (0.256041, 0.468221, 0.336180),
        "yellow": (0.597965, 0.535718, 0.269777), "blue": (0.224028, 0.345804, 0.581675),
    }),
    "turned away from the sun": ((-2.0, -4.0, -3.0), {
        "red": (0.432929, 0.200000, 0.278508), "green": (0.208393, 0.370810, 0.324140),
        "yellow": (0.463064, 0.424264, 0.278508), "blue": (0.185547, 0.273861, 0.508986),
    }),
}  # fmt: skip

case = Case(
    title="Uniform buffers",
    section="8.4",
    math=r"o_{i+1} = \left\lceil \frac{o_i + s_i}{a_{i+1}} \right\rceil a_{i+1}, \qquad "
    r"a(\mathtt{float}) = 4,\; a(\mathtt{vec3}) = a(\mathtt{mat4}) = 16",
    passes=(
        picture(CUBES, (1024, 1024), "scene", depth="depth24", clear=PAPER),
        *softened_pass("scene", (512, 512), domain={}),
        picture(CUBES, None, "main", depth="depth24", clear=PAPER),
    ),
    picture="picture.FragColor",
    expect=[
        softened_check(),
        smaller_check("main", edges=0.0005),
        *(
            block_layout("Matrices", OFFSETS, size=128, draw=k, name=f"Matrices, {color}")
            for k, color in enumerate(COLORS)
        ),
        *(
            gl_calls("glBufferData", size=size, usage="GL_STATIC_DRAW", times=times, name=name)
            for size, times, name in (
                (128, 2, "each block is written once"),
                (144, 4, "so are the indices of each cube"),
                (288, 8, "and its places and normals"),
            )
        ),
        gl_calls("glBufferData", times=14, name="and nothing else"),
        measure("the paper around the cubes", off_paper, at_most=2.0**-24),
        *(
            gl_calls(
                "glBindBufferRange",
                index=k,
                buffer=f"buffer {k + 1}",
                times=4,
                pass_name="main",
                name=f"four cubes read one buffer of {block}",
            )
            for k, block in enumerate(("Matrices", "Lights"))
        ),
        block_layout(
            "Lights",
            {"ambient": 0, "towards": 16, "gains": 32, "sky": 80, "tint": 96},
            size=128,
            name="Lights, with its gaps",
        ),
        *(
            expectation
            for k, (color, rgb) in enumerate(COLORS.items())
            for expectation in (
                formula("gl_Position", clip_position, draw=k, name=f"{color}: clip coordinates"),
                formula("Normal", unchanged("aNormal"), draw=k, name=f"{color}: normals"),
                formula("FragColor", lit(rgb), draw=k, name=f"{color}: colour"),
            )
        ),
        *(
            query(
                "samples_passed",
                at_least=low,
                at_most=high,
                draw=k,
                name=f"{color}: samples in front",
            )
            for k, (color, (low, high)) in enumerate(zip(COLORS, in_front(), strict=True))
        ),
        *(e for k, color in enumerate(COLORS) for e in seen_from_the_eye(color, k)),
        *(found for row in enumerate(COLORS) for found in shaded_by_hand(*row)),
    ],
)
