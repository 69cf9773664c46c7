"""Renderbuffers: attachments that no shader samples, and what makes a framebuffer complete.

Depth and stencil are needed while a scene is drawn, and seldom afterwards. A renderbuffer is memory
for just that, in whatever layout suits the driver: it attaches to a framebuffer and to no texture
unit, so no sampler can read it. A framebuffer is complete when each of its attachments is, when
there is at least one, and when their numbers of samples agree. A framebuffer has at least eight
points for colour attachments and one each for depth and stencil, but none of them has to be used: a
depth attachment alone is complete. Sizes may differ; then what all of them cover can be drawn.

Look at: a house, and mountains and a meadow drawn after it. On the left a depth renderbuffer keeps
them behind it; on the right there is none, and what is drawn last hides the house.

Try: in `ch08_techniques/framebuffer_renderbuffer.vert` write `-depth, 1.0` for `depth, 1.0`: the
house is behind the mountains now, and both windows are alike.
"""

import numpy as np

from shaderlab import Case, Depth, exact, formula, query
from shaderlab.engine.expectations.gl_call import Object, call

from ..scenes.api import ONE_PIXEL, PIXEL, answers, errors, limits, sent
from ..scenes.cutouts import (
    COLORS,
    DOOR,
    FIRS,
    LANDSCAPE,
    MOUNTAIN,
    PANES,
    ROOF,
    SKY,
    WALL,
    covered,
    cutout,
    layers,
    placed,
)
from ..scenes.laws import unchanged
from ..scenes.panels import cell, picture

COLOR, DEPTH = "GL_COLOR_ATTACHMENT0", "GL_DEPTH_ATTACHMENT"
ATTACHED = {"target": "GL_FRAMEBUFFER"}
NEAREST_FIRST = (DOOR, PANES, ROOF, WALL, FIRS, *LANDSCAPE)
PLACE = NEAREST_FIRST.index(MOUNTAIN)


def window(name, depth_format):
    """Both halves, over a renderbuffer of one depth format."""
    both = [
        cutout(shape, depth=test, cell=cell(column, 2))
        for column, test in enumerate((Depth(), None))
        for shape in NEAREST_FIRST
    ]
    target = {"depth": depth_format, "depth_storage": "renderbuffer"}
    return picture(both, (512, 256), name, clear=SKY, **target)


def depth_kept_in(name, word, point):
    """A pass draws with a renderbuffer of this format, made once, and with no depth texture."""
    storage = {"internalformat": word, "width": 512, "height": 256}
    rows = {
        "memory for one renderbuffer": ("glRenderbufferStorage", 1, storage),
        "it is attached": ("glFramebufferRenderbuffer", 1, {**ATTACHED, "attachment": point}),
        "the colour is a texture": ("glFramebufferTexture2D", 1, {"attachment": COLOR}),
        "and nothing else is": ("glFramebufferTexture2D", 1),
    }
    return sent(name, {f"{name}: {what}": row for what, row in rows.items()})


FRAMEBUFFER = Object("framebuffer")
BIND = (call("glBindFramebuffer", "GL_FRAMEBUFFER", FRAMEBUFFER),)
NO_COLOR = (call("glDrawBuffer", "GL_NONE"), call("glReadBuffer", "GL_NONE"))


def renderbuffer(label, point, word, size=(64, 64), samples=0):
    """A renderbuffer that is made, given its storage, and attached."""
    made = Object("renderbuffer", label)
    storage = ("GL_RENDERBUFFER", samples, word, *size)
    return (
        call("glBindRenderbuffer", "GL_RENDERBUFFER", made),
        call("glRenderbufferStorageMultisample", *storage),
        call("glFramebufferRenderbuffer", "GL_FRAMEBUFFER", point, "GL_RENDERBUFFER", made),
    )


ON_COLOR = renderbuffer("a", COLOR, "GL_RGBA8")
ON_BOTH = renderbuffer("b", "GL_DEPTH_STENCIL_ATTACHMENT", "GL_DEPTH24_STENCIL8")
SMALLER = renderbuffer("b", DEPTH, "GL_DEPTH_COMPONENT24", size=(32, 48))
HELD = "GL_RENDERBUFFER"


def at_point(point):
    """Asks what a framebuffer has at one of its points."""
    what = (point, "GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE")
    return call("glGetFramebufferAttachmentParameteriv", "GL_FRAMEBUFFER", *what)


def status(name, answer, *steps):
    """What glCheckFramebufferStatus says of a framebuffer with these attachments."""
    asked, complete = call("glCheckFramebufferStatus", "GL_FRAMEBUFFER"), f"GL_FRAMEBUFFER_{answer}"
    return answers({name: (asked, complete, BIND, *steps)})


REFUSED = "invalid_operation"
RENDERBUFFER = Object("renderbuffer")
BOUND = (*BIND, call("glBindRenderbuffer", "GL_RENDERBUFFER", RENDERBUFFER))
AS_TEXTURE = ("GL_FRAMEBUFFER", DEPTH, "GL_TEXTURE_2D", RENDERBUFFER, 0)
STORAGE = call("glRenderbufferStorage", "GL_RENDERBUFFER", "GL_RGBA8", 64, 64)
# A texture's own name, or a core context had a second error to choose: a name that is not made.
TEXTURE = Object("texture")
NOT_SAMPLED = "no unit takes a renderbuffer: it can't be sampled"


def cleared(*color):
    """Calls that fill the bound framebuffer with a colour."""
    return call("glClearColor", *color), call("glClear", "GL_COLOR_BUFFER_BIT")


FILLED = (*ONE_PIXEL, *cleared(0.2, 0.4, 0.6, 1.0))
NOT_DRAWN = (call("glDrawBuffer", "GL_NONE"), *cleared(1.0, 1.0, 1.0, 1.0))
BYTES = (51, 102, 153, 255)
OVERLAID = [(shape, COLORS[shape]) for shape in NEAREST_FIRST]
BEFORE = [covered(shape) for shape in NEAREST_FIRST[:PLACE]]
SEEN = np.sum(covered(MOUNTAIN) & ~np.any(BEFORE, axis=0))
HALVES = np.concatenate([layers(SKY, *OVERLAID[::-1]), layers(SKY, *OVERLAID)], axis=1)

case = Case(
    title="Renderbuffers and completeness",
    section="8.2",
    math=r"\text{complete} \iff n \ge 1 \;\wedge\; \forall i: w_i, h_i > 0 \;\wedge\; "
    r"\forall i, j: \text{samples}_i = \text{samples}_j",
    passes=(window("tested", "depth24_stencil8"), window("24 bits", "depth24")),
    picture="tested.FragColor",
    columns=("with a depth renderbuffer", "without"),
    expect=[
        exact("tested.FragColor", HALVES, name="with and without the depth test"),
        exact("24 bits.FragColor", HALVES, name="depth alone does as well as depth and stencil"),
        # The slopes overlap, at one depth: LESS lets the second pass only where the first is not.
        *(
            query("samples_passed", equals=SEEN, draw=PLACE, pass_name=of, name=f"{of}: mountain")
            for of in ("tested", "24 bits")
        ),
        *depth_kept_in("tested", "GL_DEPTH24_STENCIL8", "GL_DEPTH_STENCIL_ATTACHMENT"),
        *depth_kept_in("24 bits", "GL_DEPTH_COMPONENT24", "GL_DEPTH_ATTACHMENT"),
        *errors(
            {
                NOT_SAMPLED: (call("glBindTexture", "GL_RENDERBUFFER", TEXTURE), "invalid_enum"),
                "nor does its name stand for a texture": (
                    call("glFramebufferTexture2D", *AS_TEXTURE),
                    REFUSED,
                    BOUND,
                ),
            }
        ),
        *limits(
            {
                "a framebuffer takes eight colours or more": ("GL_MAX_COLOR_ATTACHMENTS", 8),
                "and draws into eight at once or more": ("GL_MAX_DRAW_BUFFERS", 8),
            }
        ),
        formula("tested.gl_Position", placed, draw=0, name="the door"),
        formula("tested.gl_Position", placed, draw=PLACE, name="the mountain"),
        formula("tested.FragColor", unchanged("color"), draw=0, name="colour"),
        *status("nothing attached", "INCOMPLETE_MISSING_ATTACHMENT"),
        *status("colour alone", "COMPLETE", renderbuffer("a", COLOR, "GL_RGBA8")),
        *status(
            "depth alone", "COMPLETE", renderbuffer("a", DEPTH, "GL_DEPTH_COMPONENT24"), NO_COLOR
        ),
        *status("colour, depth and stencil", "COMPLETE", ON_COLOR, ON_BOTH),
        *status("sizes differ", "COMPLETE", ON_COLOR, SMALLER),
        *answers(
            {
                "one renderbuffer at two points: at depth": (at_point(DEPTH), HELD, BIND, ON_BOTH),
                "… and at stencil": (at_point("GL_STENCIL_ATTACHMENT"), HELD, BIND, ON_BOTH),
                "the smaller one is at depth": (at_point(DEPTH), HELD, BIND, SMALLER),
            }
        ),
        *status(
            "depth where colour belongs",
            "INCOMPLETE_ATTACHMENT",
            renderbuffer("a", COLOR, "GL_DEPTH_COMPONENT24"),
        ),
        *answers(
            {
                "glReadPixels reads a renderbuffer": (PIXEL, BYTES, FILLED),
                "glDrawBuffer(GL_NONE): nothing is drawn": (PIXEL, BYTES, FILLED, NOT_DRAWN),
            }
        ),
        *errors({"glReadBuffer(GL_NONE): nothing is read": (PIXEL, REFUSED, FILLED, NO_COLOR)}),
        *errors({"storage with renderbuffer 0 bound: 0x0502": (STORAGE, REFUSED)}),
    ],
)
