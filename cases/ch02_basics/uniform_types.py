"""One call for each type: float, int, uint, a vector, arrays, a member of a struct, a matrix.

`glUniform` comes in many forms, and the suffix names the type: `1f`, `1i`, `1ui`, `3f`, `4fv`. A
form that does not fit the declared type is an error and sets nothing; so is a call while no program
is in use. A value stays with its program, even while another program is in use. Structs have no
form of their own: each member is a uniform called `material.shininess`, and each element of an
array one called `pairs[1]`. Values arrive bit for bit, because no arithmetic has happened yet.

Look at: the eight instruments, each of which shows one uniform and nothing else. From the upper
left a float, an int as so many dots, the low byte of a uint, a vec3 as a colour; below them
float[4], vec2[2], a struct as a ball of that material, and the columns of a mat2x3. In the second
variant all of them have moved.

Try: in `ch02_basics/uniform_types_picture.frag` write `fv[3 - int(min(x, 3.0))]` for `fv[int(min(x,
3.0))]`: the four bars stand in reverse order.
"""

import numpy as np

from shaderlab import (
    Case,
    Mesh,
    Target,
    Variant,
    boundaries,
    exact,
    formula,
    fullscreen,
    gl_call,
    gl_calls,
    mesh_pass,
)
from shaderlab.engine.expectations.gl_call import Location, Program, call
from shaderlab.glslmath import (
    abs,
    atan,
    distance,
    dot,
    floor,
    fract,
    length,
    max,
    min,
    mix,
    normalize,
    pow,
    sqrt,
    swizzle,
    vec2,
    vec3,
    vec4,
    where,
)

from ..scenes.api import answers, errors
from ..scenes.drawing import encoded
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, panel, rectangle

FIRST = {
    "f": 0.7,
    "i": 11,
    "u": 0b10110010,
    "v3": (0.9, 0.35, 0.1),
    "fv": (0.2, 0.9, 0.5, 0.7),
    "pairs": [(-0.5, 0.4), (0.6, -0.3)],
    "material.ambient": (0.1, 0.35, 0.6),
    "material.shininess": 32.0,
    "m": [[0.9, 0.3], [0.5, 0.6], [0.2, 0.8]],
}
SECOND = {
    "f": 0.1,
    "i": -(2**31),
    "u": 2**32 - 2,
    "v3": (0.05, 0.3, 0.7),
    "fv": (0.9, 0.3, 0.6, 0.1),
    "pairs": [(0.3, 0.6), (-0.6, -0.6)],
    "material.ambient": (0.6, 0.2, 0.1),
    "material.shininess": 4.0,
    "m": [[0.1, 0.7], [0.4, 0.5], [0.9, 0.3]],
}

BACK, MARK, WARM = vec3(0.04, 0.05, 0.065), vec3(0.75, 0.80, 0.85), vec3(1.0, 0.55, 0.12)
BLUE, GREEN = vec3(0.2, 0.55, 0.9), vec3(0.25, 0.75, 0.45)


def bars(x, y, heights, colors):
    """Bars beside one another, each with a gap of its own, from −0.8 up to 1.6 times its height."""
    n = len(heights)
    cut = (x + 0.8) * (n / 1.6)
    color = BACK
    for k, (height, hue) in enumerate(zip(heights, colors, strict=True)):
        bar = (abs(cut - (k + 0.5)) < 0.36) & (y > -0.8) & (y < 1.6 * height - 0.8)
        color = where(bar, hue, color)
    return color


def instruments(sent):
    """The eight instruments as they show what was sent."""

    def needle(at):
        off = at + vec2(0.0, 0.35)
        x, y, r = swizzle(off, "x"), swizzle(off, "y"), length(off)
        scale = (y > 0.0) & (r > 0.55) & (r < 0.85)
        # From the left: a half turn less the angle.
        color = where(1.0 - atan(y, x) / 3.14159265 < sent["f"], WARM, BACK * 3.0)
        return where(scale, color, BACK)

    def dots(at):
        color = BACK
        for k in range(16):  # row by row from above
            centre = vec2(0.4 * (k % 4) - 0.6, 0.6 - 0.4 * (k // 4))
            lit = (distance(at, centre) < 0.32 * 0.4) & (k < sent["i"])
            color = where(lit, WARM, color)
        return color

    def low_byte(at):
        x, color = (swizzle(at, "x") + 0.8) * 5.0, BACK
        for k, bit in enumerate(format(sent["u"] & 0xFF, "08b")):
            hue = MARK if bit == "1" else BACK * 3.0
            color = where(abs(x - (k + 0.5)) < 0.42, hue, color)
        return where(abs(swizzle(at, "y")) > 0.3, BACK, color)

    def colored(at):
        inside = max(abs(swizzle(at, "x")), abs(swizzle(at, "y"))) < 0.6
        return where(inside, vec3(*sent["v3"]), BACK)

    def places(at):
        axes = min(abs(swizzle(at, "x")), abs(swizzle(at, "y"))) < 0.006
        color = where(axes, mix(BACK, MARK, 0.25), BACK)
        for place, hue in zip(sent["pairs"], (WARM, BLUE), strict=True):
            color = where(distance(at, vec2(*place)) < 0.12, hue, color)
        return color

    def ball(at):
        r = length(at) / 0.7
        height = sqrt(max(1.0 - r * r, 0.0))
        facing = max(dot(vec3(at / 0.7, height), normalize(vec3(-0.4, 0.5, 0.9))), 0.0)
        lit = vec3(*sent["material.ambient"]) * (0.25 + 0.75 * height)
        return where(r < 1.0, lit + 0.6 * pow(facing, sent["material.shininess"]), BACK)

    def seen(place):
        at = fract(place) * 2.0 - 1.0
        x, y = swizzle(at, "x"), swizzle(at, "y")
        columns = np.array(sent["m"]).T.ravel()
        each = (
            *(needle(at), dots(at), low_byte(at), colored(at)),
            *(bars(x, y, sent["fv"], [BLUE] * 4), places(at), ball(at)),
            bars(x, y, columns, [WARM] * 3 + [GREEN] * 3),
        )
        color = each[7]
        for k in range(7):
            column, row = (
                swizzle(floor(place), "x") == k % 4,
                swizzle(floor(place), "y") == 1 - k // 4,
            )
            color = where(column & row, each[k], color)
        return vec4(encoded(where(max(abs(x), abs(y)) <= 0.96, color, vec3(0.0))), 1.0)

    return seen


# One function for each type, as the suffix has it: which one, how many elements.
FORMS = {
    "f": ("1fv", 1), "i": ("1iv", 1), "u": ("1uiv", 1), "v3": ("3fv", 1), "fv": ("1fv", 4),
    "pairs": ("2fv", 2), "material.ambient": ("3fv", 1), "material.shininess": ("1fv", 1),
    "m": ("Matrix2x3fv", 1),
}  # fmt: skip
SENT = Program("main")
F, V3 = Location("f", SENT), Location("v3", SENT)
IN_USE = (call("glUseProgram", SENT),)
SET_AND_LEFT = (call("glUniform1f", F, 0.375), call("glUseProgram", 0))
REFUSED = "invalid_operation"


def sent_as(sent):
    """Each uniform is sent once, by the function for its type and in as many elements."""
    for name, (form, count) in FORMS.items():
        values = np.array(sent[name])
        flat = (values.T if name == "m" else values).ravel()
        kind = {"i": np.int64, "u": np.int64}.get(name, np.float32)
        words = " ".join(f"{x}" if kind is np.int64 else f"{x:g}" for x in flat.astype(kind))
        yield gl_calls(
            f"glUniform{form}",
            count=count,
            value=f"[{words}]",
            times=1,
            pass_name="main",
            name=f"{name} by glUniform{form}",
        )


def arrives(sent):
    """Every uniform comes out as it was sent."""
    m = np.float32(sent["m"])
    whole = {
        "fOut": np.float32(sent["f"]),
        "iOut": np.int32(sent["i"]),
        "uOut": np.uint32(sent["u"]),
        "v3Out": np.float32(sent["v3"]),
        "fvOut": np.float32(sent["fv"]),
        "pairsOut": np.float32(sent["pairs"]).ravel(),
        "materialOut": np.float32((*sent["material.ambient"], sent["material.shininess"])),
        "mOut": np.float32((*m[:, 0], m[2, 1])),
    }
    return [
        *(exact(name, expected) for name, expected in whole.items()),
        formula("small.FragColor", instruments(sent), name="the instruments"),
        boundaries("small.FragColor", instruments(sent), name="… at their edges"),
        *sent_as(sent),
    ]


CORNERS = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0)])


def shrunk(aPos, level):
    """The vertex stage scales by the level."""
    return vec4(aPos * level, 1.0)


def shaded(level):
    """The fragment stage shows the same number as a grey."""
    return vec4(vec3(level), 1.0)


WINDOW = {"place": rectangle((0.0, 0.0), (4.0, 2.0))}
PICTURE = panel("ch02_basics/uniform_types_picture.frag", WINDOW, FIRST)

case = Case(
    title="Uniforms of every type",
    section="2.3.4",
    math=r"\text{glUniform}\{1,2,3,4\}\{f, i, ui\}[v], \qquad "
    r"\text{glUniformMatrix}\{2,3,4\}[\times\{2,3,4\}]fv",
    passes=(
        *enlarged([PICTURE], (112, 56), 9),
        *mesh_pass(
            "ch02_basics/shared_uniform.vert",
            "ch02_basics/shared_uniform.frag",
            Mesh(attributes={"aPos": CORNERS}),
            uniforms={"level": 0.375},
            name="shared",
            target=Target(size=(16, 16)),
        ),
        *fullscreen("ch02_basics/uniform_types.frag", domain={}, uniforms=FIRST),
    ),
    picture="picture.FragColor",
    expect=[
        enlarged_check(),
        *errors(
            {
                "no program: 0x0502": (call("glUniform1f", 0, 0.5), REFUSED),
                "an int for a float: 0x0502": (call("glUniform1i", F, 1), REFUSED, IN_USE),
                "two numbers for three: 0x0502": (
                    call("glUniform2f", V3, 0.5, 0.5),
                    REFUSED,
                    IN_USE,
                ),
            }
        ),
        gl_call(
            "glGetUniformLocation",
            *(SENT, "f"),
            at_least=0,
            name="f has a location before its program is used",
        ),
        gl_call("glGetUniformLocation", SENT, "g", returns=-1, name="a name of none: −1"),
        gl_call(
            "glGetProgramiv",
            *(Program("shared"), "GL_ACTIVE_UNIFORMS"),
            returns=1,
            name="a uniform of both stages is one uniform",
        ),
        gl_calls("glUniform1fv", times=1, pass_name="shared", name="… and is set once"),
        formula("shared.gl_Position", shrunk, name="the vertex stage gets it"),
        formula("shared.FragColor", shaded, name="the fragment stage gets it"),
        *answers(
            {
                "what was sent stays with the program": (
                    call("glGetUniformfv", SENT, F),
                    0.375,
                    IN_USE,
                    SET_AND_LEFT,
                    IN_USE,
                ),
                "before that it is 0": (call("glGetUniformfv", SENT, F), 0.0, IN_USE),
            }
        ),
    ],
    variants=[
        Variant("first", expect=arrives(FIRST)),
        Variant("second", SECOND, expect=arrives(SECOND)),
    ],
)
