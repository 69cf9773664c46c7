"""Renderbuffers: attachments that are drawn into and never sampled, and what makes a set complete.

Depth and stencil are needed while a scene is drawn, and seldom afterwards. A renderbuffer is memory
for that alone, in whatever arrangement suits the driver: it is bound to a framebuffer only, and to
no texture unit, so that no sampler reads it. A framebuffer is complete when each of its
attachments is, when there is at least one, and when their numbers of samples agree. There need be
no colour, a depth attachment alone is complete; and sizes may differ, then what all of them cover
can be drawn.

Look at: on the left a small near square and a large far one with a depth renderbuffer, on the right
without one: there the far square, drawn last, hides the near one.
"""

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Pass,
    State,
    Target,
    assets,
    exact,
    formula,
    gl_call,
    gl_calls,
)
from shaderlab.expectations.gl_call import Object, call
from shaderlab.glslmath import swizzle, vec4

SQUARE = Mesh(**assets.quad(2.0)).only("aPos")
NEAR, FAR, PAPER = (1.0, 0.72, 0.30, 1.0), (0.16, 0.42, 0.55, 1.0), (0.93, 0.93, 0.92, 1.0)
SHADERS = {
    "vertex": "ch08_techniques/framebuffer_renderbuffer.vert",
    "fragment": "ch08_techniques/framebuffer_renderbuffer.frag",
}


def squares(column, depth):
    """The near square, and then the far one, in one half of the window."""
    cell = Cell(column=column, row=0, columns=2, rows=1)
    return tuple(
        Draw(
            **SHADERS,
            mesh=SQUARE,
            uniforms={"size": size, "depth": z, "color": color},
            state=State(depth=depth, cell=cell),
        )
        for size, z, color in ((0.5, -0.5, NEAR), (0.75, 0.5, FAR))
    )


def window(name, depth_format):
    """Both halves, over a renderbuffer of one depth format."""
    target = Target(size=(512, 256), depth=depth_format, depth_storage="renderbuffer", clear=PAPER)
    return Pass(name=name, target=target, draws=(*squares(0, Depth()), *squares(1, None)))


def depth_kept_in(name, word, point):
    """A pass draws with a renderbuffer of this format, made once, and with no depth texture."""
    of_depth = {"target": "GL_FRAMEBUFFER", "attachment": point}
    return (
        gl_calls(
            "glRenderbufferStorage",
            internalformat=word,
            width=512,
            height=256,
            times=1,
            pass_name=name,
            name=f"{name}: memory for one renderbuffer",
        ),
        gl_calls(
            "glFramebufferRenderbuffer",
            **of_depth,
            times=1,
            pass_name=name,
            name=f"{name}: it is attached",
        ),
        gl_calls(
            "glFramebufferTexture2D",
            attachment="GL_COLOR_ATTACHMENT0",
            times=1,
            pass_name=name,
            name=f"{name}: the colour is a texture",
        ),
        gl_calls(
            "glFramebufferTexture2D",
            times=1,
            pass_name=name,
            name=f"{name}: and nothing else is",
        ),
    )


def half(tested):
    """A half of 256 × 256 pixels: paper, the far square, before it perhaps the near one."""
    block = np.tile(np.asarray(PAPER, np.float32), (256, 256, 1))
    block[32:224, 32:224] = FAR
    if tested:
        block[64:192, 64:192] = NEAR
    return block


def placed(aPos, size, depth):
    """Scaled across, and put at a depth."""
    return vec4(swizzle(aPos, "xy") * size, depth, 1.0)


def plain(color):
    """One colour."""
    return color


FRAMEBUFFER = Object("framebuffer")
BIND = call("glBindFramebuffer", "GL_FRAMEBUFFER", FRAMEBUFFER)
NO_COLOR = (call("glDrawBuffer", "GL_NONE"), call("glReadBuffer", "GL_NONE"))
COLOR, DEPTH = "GL_COLOR_ATTACHMENT0", "GL_DEPTH_ATTACHMENT"


def renderbuffer(label, point, word, size=(64, 64), samples=0):
    """A renderbuffer that is made, given its storage, and attached."""
    made = Object("renderbuffer", label)
    storage = ("GL_RENDERBUFFER", samples, word, *size)
    return (
        call("glBindRenderbuffer", "GL_RENDERBUFFER", made),
        call("glRenderbufferStorageMultisample", *storage),
        call("glFramebufferRenderbuffer", "GL_FRAMEBUFFER", point, "GL_RENDERBUFFER", made),
    )


def status(name, answer, *steps):
    """What glCheckFramebufferStatus says of a framebuffer with these attachments."""
    return gl_call(
        "glCheckFramebufferStatus",
        "GL_FRAMEBUFFER",
        before=(BIND, *(step for some in steps for step in some)),
        returns=f"GL_FRAMEBUFFER_{answer}",
        name=name,
    )


case = Case(
    title="Renderbuffers and completeness",
    section="8.2",
    math=r"\text{complete} \iff n \ge 1 \;\wedge\; \forall i: w_i, h_i > 0 \;\wedge\; "
    r"\forall i, j: \text{samples}_i = \text{samples}_j",
    passes=(window("tested", "depth24_stencil8"), window("24 bits", "depth24")),
    picture="tested.FragColor",
    expect=[
        exact(
            "tested.FragColor",
            np.concatenate([half(True), half(False)], axis=1),
            name="with and without the depth test",
        ),
        exact(
            "24 bits.FragColor",
            np.concatenate([half(True), half(False)], axis=1),
            name="depth alone does as well as depth and stencil",
        ),
        *depth_kept_in("tested", "GL_DEPTH24_STENCIL8", "GL_DEPTH_STENCIL_ATTACHMENT"),
        *depth_kept_in("24 bits", "GL_DEPTH_COMPONENT24", "GL_DEPTH_ATTACHMENT"),
        gl_call(
            "glBindTexture",
            "GL_RENDERBUFFER",
            1,
            raises="invalid_enum",
            name="no unit takes a renderbuffer: it can't be sampled",
        ),
        gl_call(
            "glFramebufferTexture2D",
            "GL_FRAMEBUFFER",
            DEPTH,
            "GL_TEXTURE_2D",
            Object("renderbuffer"),
            0,
            before=(BIND, call("glBindRenderbuffer", "GL_RENDERBUFFER", Object("renderbuffer"))),
            raises="invalid_operation",
            name="nor does its name stand for a texture",
        ),
        gl_call(
            "glGetIntegerv",
            "GL_MAX_COLOR_ATTACHMENTS",
            at_least=8,
            name="a framebuffer takes eight colours or more",
        ),
        gl_call(
            "glGetIntegerv",
            "GL_MAX_DRAW_BUFFERS",
            at_least=8,
            name="and draws into eight at once or more",
        ),
        formula("tested.gl_Position", placed, draw=0, name="the near square"),
        formula("tested.gl_Position", placed, draw=1, name="the far square"),
        formula("tested.FragColor", plain, draw=0, name="colour"),
        status("nothing attached", "INCOMPLETE_MISSING_ATTACHMENT"),
        status("colour alone", "COMPLETE", renderbuffer("a", COLOR, "GL_RGBA8")),
        status(
            "depth alone", "COMPLETE", renderbuffer("a", DEPTH, "GL_DEPTH_COMPONENT24"), NO_COLOR
        ),
        status(
            "colour, depth and stencil",
            "COMPLETE",
            renderbuffer("a", COLOR, "GL_RGBA8"),
            renderbuffer("b", "GL_DEPTH_STENCIL_ATTACHMENT", "GL_DEPTH24_STENCIL8"),
        ),
        status(
            "sizes differ",
            "COMPLETE",
            renderbuffer("a", COLOR, "GL_RGBA8", size=(64, 64)),
            renderbuffer("b", DEPTH, "GL_DEPTH_COMPONENT24", size=(32, 48)),
        ),
        status(
            "depth where colour belongs",
            "INCOMPLETE_ATTACHMENT",
            renderbuffer("a", COLOR, "GL_DEPTH_COMPONENT24"),
        ),
        gl_call(
            "glRenderbufferStorage",
            "GL_RENDERBUFFER",
            "GL_RGBA8",
            64,
            64,
            raises="invalid_operation",
            name="storage with renderbuffer 0 bound: 0x0502",
        ),
    ],
    errata=[
        Erratum(
            section="8.2",
            says="a framebuffer needs at least one colour attachment to be complete",
            truth="with glDrawBuffer(GL_NONE) and glReadBuffer(GL_NONE) depth alone is complete",
            proof="depth alone",
        ),
    ],
)
