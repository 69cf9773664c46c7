"""The initial state of the tests, and a depth buffer that is not cleared.

OpenGL begins with all tests off, and with sensible settings for when they are turned on: depth is
compared by LESS and written, the stencil function is ALWAYS and keeps what is stored, blending adds
source times one, back faces are those seen clockwise. A frame has to clear what it tests against:
what the last frame left in the depth buffer hides what this one draws behind it, though the colours
of the last frame are gone.

Look at: the second frame, a blue square, twice. In the first frame a hexagon was nearer. On the
left its depth was cleared with its colour; on the right only the colour was, and the hexagon is a
hole in the square, in the colour of the paper.
"""

import numpy as np

from shaderlab import Case, Depth, Mesh, Pass, Target, assets, exact, formula, gl_call, query
from shaderlab.glslmath import swizzle, vec4

from ..scenes.draws import tested
from ..scenes.laws import unchanged
from ..scenes.panels import cell
from ..scenes.rosette import rosette

SIDE = 256
PAPER, NEAR, FAR = (0.93, 0.93, 0.92, 1.0), (1.0, 0.72, 0.30, 1.0), (0.16, 0.42, 0.55, 1.0)
SQUARE, HEXAGON = Mesh(**assets.quad(2.0)).only("aPos"), rosette().only("aPos")
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


def shape(mesh, size, depth, color, column, test):
    """A shape at one depth, in one half of the window."""
    uniforms = {"size": size, "depth": depth, "color": color}
    half = cell(column, 2)
    return tested("ch08_techniques/framebuffer_renderbuffer", mesh, uniforms, cell=half, depth=test)


def two_frames(column, cleared):
    """The hexagon; the paper over it, and its depth as well if it is cleared; then the square."""
    return (
        shape(HEXAGON, 0.5, -0.5, NEAR, column, Depth()),
        shape(SQUARE, 1.0, 1.0, PAPER, column, Depth(func="always", write=cleared)),
        shape(SQUARE, 0.75, 0.5, FAR, column, Depth()),
    )


# Which pixel centres of a half lie in the hexagon: its corners are (±52, ±30) and (0, ±60) pixels
# from the middle.
X, Y = np.abs(np.meshgrid(*[np.arange(SIDE) + 0.5 - SIDE / 2] * 2))
HOLE = (X < 52.0) & (30.0 * X + 52.0 * Y < 52.0 * 60.0)


def second_frame(paper, square, hole):
    """The window at the end: on the left the square, on the right the square with a hole."""
    left = np.tile(np.float32(paper), (SIDE, SIDE, 1))
    left[32:224, 32:224] = square
    return np.concatenate([left, np.where(HOLE[..., None], np.float32(hole), left)], axis=1)


def placed(aPos, size, depth):
    """Scaled across, and put at a depth."""
    return vec4(swizzle(aPos, "xy") * size, depth, 1.0)


case = Case(
    title="Default states, and depth that is not cleared",
    section="6",
    math=r"z_{\text{square}} < z_{\text{stored}} = \begin{cases} 1 & \text{cleared} \\ "
    r"z_{\text{hexagon}} & \text{left over} \end{cases}",
    passes=[
        Pass(
            target=Target(size=(2 * SIDE, SIDE), depth="depth32f", clear=(0.0, 0.0, 0.0, 1.0)),
            draws=(*two_frames(0, True), *two_frames(1, False)),
        )
    ],
    columns=("depth cleared", "depth left over"),
    expect=[
        exact("FragColor", second_frame(PAPER, FAR, PAPER), name="the second frame, twice"),
        exact("depth", second_frame((1.0,), 0.75, (0.25,)), name="the depth that is left"),
        *(
            query("samples_passed", equals=passed, draw=k, name=name)
            for k, passed, name in (
                (0, HOLE.sum(), "hexagon left"),
                (2, 192**2, "the square where depth was cleared"),
                (3, HOLE.sum(), "hexagon right"),
                (5, 192**2 - HOLE.sum(), "the square where it was not"),
            )
        ),
        *(formula("gl_Position", placed, draw=k, name=f"places of draw {k}") for k in range(6)),
        formula("FragColor", unchanged("color"), draw=2, name="the square's colour"),
        *(
            gl_call(function, word, returns=at_first, name=f"{word} at first")
            for function, word, at_first in STATES
        ),
    ],
)
