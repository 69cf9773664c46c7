"""The initial state of the tests, and a depth buffer that is not cleared.

OpenGL begins with all tests off, and with sensible settings for when they are turned on: depth is
compared by LESS and written, the stencil function is ALWAYS and keeps what is stored, blending adds
source times one, back faces are those seen clockwise. A frame has to clear what it tests against:
what the last frame left in the depth buffer hides what this one draws behind it, though the colours
of the last frame are gone.

Look at: the second frame, mountains and a meadow, twice. In the first frame a house was nearer. On
the left its depth was cleared with its colour; on the right only the colour was, and the house is a
hole in the landscape, in the colour of the sky.

Try: in `ch08_techniques/framebuffer_renderbuffer.vert` write `-depth, 1.0` for `depth, 1.0`: the
mountains are in front of the house: the hole is gone. On the left nothing is in front of the sky.
"""

import numpy as np

from shaderlab import Case, Depth, exact, formula, query
from shaderlab.engine.expectations.gl_call import call

from ..scenes import cutouts
from ..scenes.api import answers
from ..scenes.cutouts import HOUSE, LANDSCAPE, SIDE, SKY, covered, cutout, layers
from ..scenes.laws import unchanged
from ..scenes.panels import cell, picture

# What a test is set to before anything is called.
STATES = (
    ("glIsEnabled", "GL_DEPTH_TEST", "GL_FALSE"),
    ("glGetIntegerv", "GL_DEPTH_FUNC", "GL_LESS"),
    ("glGetIntegerv", "GL_DEPTH_WRITEMASK", "GL_TRUE"),
    ("glGetFloatv", "GL_DEPTH_CLEAR_VALUE", 1.0),
    ("glIsEnabled", "GL_STENCIL_TEST", "GL_FALSE"),
    ("glGetIntegerv", "GL_STENCIL_FUNC", "GL_ALWAYS"),
    ("glGetIntegerv", "GL_STENCIL_FAIL", "GL_KEEP"),
    ("glIsEnabled", "GL_BLEND", "GL_FALSE"),
    ("glGetIntegerv", "GL_BLEND_SRC_RGB", "GL_ONE"),
    ("glGetIntegerv", "GL_BLEND_DST_RGB", "GL_ZERO"),
    ("glGetIntegerv", "GL_BLEND_EQUATION_RGB", "GL_FUNC_ADD"),
    ("glIsEnabled", "GL_CULL_FACE", "GL_FALSE"),
    ("glGetIntegerv", "GL_CULL_FACE_MODE", "GL_BACK"),
    ("glGetIntegerv", "GL_FRONT_FACE", "GL_CCW"),
)


def two_frames(column, cleared):
    """The house; the sky over it, and its depth as well if it is cleared; then the landscape."""
    half = cell(column, 2)
    return (
        cutout(HOUSE, depth=Depth(), cell=half),
        cutout(cutouts.WHOLE, depth=Depth(func="always", write=cleared), cell=half),
        *(cutout(shape, depth=Depth(), cell=half) for shape in LANDSCAPE),
    )


def second_frame(sky, values, hole):
    """The window at the end: on the left the landscape, on the right the same with a hole."""
    behind = [(shape, values[shape]) for shape in reversed(LANDSCAPE)]
    return np.concatenate([layers(sky, *behind), layers(sky, *behind, (HOUSE, hole))], axis=1)


FRAMES = (*two_frames(0, True), *two_frames(1, False))
HOUSE_PIXELS = covered(HOUSE)
MOUNTAIN_PIXELS = covered(cutouts.MOUNTAIN) & ~covered(cutouts.SNOW) & ~covered(cutouts.MEADOW)
LEFT = {shape: (0.5 * z + 0.5,) for shape, z in cutouts.DEPTHS.items()}

case = Case(
    title="Default states, and depth that is not cleared",
    section="6",
    math=r"z_{\text{mountain}} < z_{\text{stored}} = \begin{cases} 1 & \text{cleared} \\ "
    r"z_{\text{house}} & \text{left over} \end{cases}",
    passes=[
        picture(FRAMES, (2 * SIDE, SIDE), "main", depth="depth32f", clear=(0.0, 0.0, 0.0, 1.0))
    ],
    columns=("depth cleared", "depth left over"),
    expect=[
        exact("FragColor", second_frame(SKY, cutouts.COLORS, SKY), name="the second frame, twice"),
        exact("depth", second_frame((1.0,), LEFT, 0.25), name="the depth that is left"),
        *(
            query("samples_passed", equals=passed, draw=k, name=name)
            for k, passed, name in (
                (0, HOUSE_PIXELS.sum(), "house left"),
                (4, MOUNTAIN_PIXELS.sum(), "the mountain where depth was cleared"),
                (6, HOUSE_PIXELS.sum(), "house right"),
                (10, (MOUNTAIN_PIXELS & ~HOUSE_PIXELS).sum(), "the mountain where it was not"),
            )
        ),
        *(
            formula("gl_Position", cutouts.placed, draw=k, name=f"places of draw {k}")
            for k in range(12)
        ),
        formula("FragColor", unchanged("color"), draw=4, name="the mountain's colour"),
        *answers(
            {f"{word} at first": (call(asked, word), at_first) for asked, word, at_first in STATES}
        ),
        *answers(
            {
                f"{word}, turned on": (call(asked, word), "GL_TRUE", (call("glEnable", word),))
                for asked, word, _ in STATES
                if asked == "glIsEnabled"
            }
        ),
    ],
)
