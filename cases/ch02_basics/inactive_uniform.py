"""A uniform that nothing depends on does not exist: its location is −1.

A program's uniforms are found by name after linking. The linker keeps those that an output depends
on; a uniform that is only declared, or read only by a function without callers, is inactive, and
`glGetUniformLocation` answers −1 as it does for a misspelt name. Setting location −1 is silently
ignored: there is no error, and the picture simply does not change. The lab names such uniforms in
its report, so that nobody searches the formula for the mistake.

Look at: the three panels. In the second the left dial, `strength`, was turned up, and the lamp is
brighter. In the third the right one, `unused`, was turned instead, all the way, and the lamp shines
as in the first, to the bit.

Try: in `ch02_basics/inactive_uniform.frag` write `(strength + 0.5 * unused) * tint` for `strength *
tint`: now an output depends on it, so the third lamp is brighter, too.
"""

import numpy as np

from shaderlab import (
    Case,
    Output,
    boundaries,
    exact,
    formula,
    gl_call,
    inactive_uniforms,
    measure,
    reading,
)
from shaderlab.engine.expectations.gl_call import Location, Program, call
from shaderlab.glslmath import (
    abs,
    cos,
    cross,
    dot,
    exp,
    length,
    max,
    mix,
    radians,
    sin,
    smoothstep,
    step,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import texelFetch

from ..scenes.api import answers, sent
from ..scenes.drawing import encoded
from ..scenes.figures import each_draw, figure
from ..scenes.laws import opaque
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import cell, enlarged, panel, panel_pass, square

# name: strength, unused
SETTINGS = {"first": (0.35, 0.2), "strength-turned": (0.9, 0.2), "unused-turned": (0.35, 1.0)}

LIT = Program("first")
MISSPELT = call("glGetUniformLocation", LIT, "strenght")
UNSET = {"location": -1}
HALF = {"strength": 0.5, "tint": (1.0, 0.5, 0.25)}


def lit(name, strength, unused):
    """The program under test, with its four uniforms set."""
    set_at = {"strength": strength, "unused": unused, "neverAsked": (unused, 1.0)}
    uniforms = {"tint": (1.0, 0.8, 0.45), **set_at}
    return panel_pass(name, "ch02_basics/inactive_uniform.frag", {}, uniforms)


def shown(k, name, strength, unused):
    """A lamp in the colour that a pass drew, over two dials."""
    return panel(
        "ch02_basics/inactive_uniform_picture.frag",
        {"place": square()},
        {"dials": (strength, unused), "turned": (k == 1, k == 2)},
        textures={"lit": Output(f"{name}.FragColor")},
        cell=cell(k, 3),
    )


def shines(tint, strength):
    """What the colour depends on, and all it depends on."""
    return vec4(strength * tint, 1.0)


def dial(color, off, value, marked, hue):
    """A dial over what was there: a dark disc, a needle, and a rim that tells whether it moved."""
    radius, angle = length(off), radians(225.0 - 270.0 * value)
    hand = vec2(cos(angle), sin(angle))
    color = mix(mix(vec3(0.10), hue, 0.30), color, smoothstep(0.24, 0.25, radius))
    # How far off the hand's line a place is: the length of a cross product.
    aside = abs(swizzle(cross(vec3(hand, 0.0), vec3(off, 0.0)), "z"))
    ink = where(dot(off, hand) > 0.0, 1.0 - smoothstep(0.0125, 0.0185, aside), 0.0)
    color = where(radius <= 0.22, mix(color, vec3(0.95), ink), color)
    rim = abs(radius - 0.27) <= mix(0.008, 0.022, marked)
    return where(rim, mix(vec3(0.35), vec3(1.0, 0.85, 0.3), marked), color)


def lamp_and_dials(place, lit, dials, turned):
    """The picture: a lamp in the colour that was drawn, its glow, and both dials."""
    glow = swizzle(texelFetch(lit, vec2(0.0, 0.0)), "rgb")
    away = length(place - vec2(0.0, 0.36))
    color = vec3(0.035, 0.045, 0.06) + 0.35 * exp(-5.0 * max(away - 0.34, 0.0)) * glow
    color = mix(glow, color, smoothstep(0.34, 0.35, away))
    for of, across, hue in (("x", -0.42, vec3(0.5, 0.8, 1.0)), ("y", 0.42, vec3(0.6))):
        off = place - vec2(across, -0.5)
        color = dial(color, off, swizzle(dials, of), swizzle(turned, of), hue)
    frame = max(abs(swizzle(place, "x")), abs(swizzle(place, "y")))
    return encoded(color * step(frame, 0.97))


def lamp_off(picture, lit, middle):
    """How far the middle of a panel's lamp is from the colour that a pass drew."""
    height, width = picture.shape[:2]
    shown = picture[int(0.68 * height), int(middle * width)]
    return np.abs(shown - encoded(lit[0, 0])).max()


case = Case(
    title="An inactive uniform",
    section="2.3.4",
    math=r"\frac{\partial\,\text{FragColor}}{\partial\,\text{unused}} = 0 "
    r"\;\Rightarrow\; \text{location} = -1",
    passes=(
        *(lit(name, *values) for name, values in SETTINGS.items()),
        *enlarged((shown(k, n, *v) for k, (n, v) in enumerate(SETTINGS.items())), (138, 46), 7),
    ),
    picture="picture.FragColor",
    columns=("at first", "strength turned up", "unused turned up"),
    expect=[
        enlarged_check(),
        measure(
            "each lamp has the colour of its pass",
            lamp_off,
            reads={"picture": "picture.FragColor"},
            readings=[
                reading(n, reads={"lit": f"{n}.FragColor"}, given={"middle": m}, at_most=0.001)
                for n, m in zip(SETTINGS, (1 / 6, 3 / 6, 5 / 6), strict=True)
            ],
        ),
        *each_draw(
            "small.FragColor", opaque(lamp_and_dials), {k: f"panel {k + 1}" for k in range(3)}
        ),
        *(
            boundaries(
                "small.FragColor", opaque(lamp_and_dials), draw=k, name=f"edges of panel {k + 1}"
            )
            for k in range(3)
        ),
        inactive_uniforms("unused", "neverAsked", pass_name="first", name="location −1"),
        *sent(
            "unused-turned",
            {
                "unused is set all the same": ("glUniform1fv", 1, {**UNSET, "value": "[1]"}),
                "neverAsked is set all the same": ("glUniform2fv", 1, {**UNSET, "value": "[1 1]"}),
            },
        ),
        gl_call("glUniform1f", Location("unused", LIT), 1.0, name="which raises no error"),
        *answers({"a misspelt name is nowhere, too": (MISSPELT, -1)}),
        formula("first.FragColor", shines),
        formula("strength-turned.FragColor", shines, name="another strength"),
        exact(
            "unused-turned.FragColor",
            Output("first.FragColor"),
            name="setting an inactive uniform changes nothing",
        ),
        figure("first.FragColor", "half of the tint", HALF, (0.5, 0.25, 0.125, 1.0)),
    ],
)
