"""A uniform that nothing depends on is not there: its location is −1.

A program's uniforms are found by name after linking. The linker keeps those that an output depends
on; a uniform that is only declared, or read only by a function without callers, is inactive, and
`glGetUniformLocation` answers −1 as it does for a misspelt name. Setting location −1 is silently
ignored: that is no error, and the picture simply does not change. The lab names such uniforms in
its report, so that a forgotten one is not looked for in the formula.

Look at: the three panels. In the second the left dial, `strength`, was turned up, and the lamp is
brighter. In the third the right one, `unused`, was turned instead, all the way, and the lamp shines
as in the first, to the bit.
"""

from shaderlab import (
    Case,
    Cell,
    Draw,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    exact,
    formula,
    fullscreen,
    inactive_uniforms,
    value,
)
from shaderlab.glslmath import vec4

# name: strength, unused
SETTINGS = {"first": (0.35, 0.2), "strength-turned": (0.9, 0.2), "unused-turned": (0.35, 1.0)}


def lit(name, strength, unused):
    """The program under test, with its four uniforms set."""
    return fullscreen(
        "ch02_basics/inactive_uniform.frag",
        name=name,
        domain={},
        uniforms={
            "tint": (1.0, 0.8, 0.45),
            "strength": strength,
            "unused": unused,
            "neverAsked": (unused, 1.0),
        },
    )


def panel(k, name, strength, unused):
    """A lamp in the colour that a pass drew, over two dials."""
    return Draw(
        fragment="ch02_basics/inactive_uniform_picture.frag",
        domain={"place": Ramp((-1.0, -1.0), (2.0, 0.0), (0.0, 2.0))},
        uniforms={"dials": (strength, unused), "turned": (k == 1, k == 2)},
        textures={"lit": Output(f"{name}.FragColor")},
        state=State(cell=Cell(column=k, row=0, columns=3, rows=1)),
    )


def shines(tint, strength):
    """What the colour depends on, and all it depends on."""
    return vec4(strength * tint, 1.0)


case = Case(
    title="An inactive uniform",
    section="2.3.4",
    math=r"\frac{\partial\,\text{FragColor}}{\partial\,\text{unused}} = 0 "
    r"\;\Rightarrow\; \text{location} = -1",
    passes=(
        *(p for name, values in SETTINGS.items() for p in lit(name, *values)),
        Pass(
            name="picture",
            target=Target(size=(960, 320)),
            draws=tuple(panel(k, n, *v) for k, (n, v) in enumerate(SETTINGS.items())),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        inactive_uniforms("unused", "neverAsked", pass_name="first", name="location −1"),
        formula("first.FragColor", shines),
        formula("strength-turned.FragColor", shines, name="another strength"),
        exact(
            "unused-turned.FragColor",
            Output("first.FragColor"),
            name="setting an inactive uniform changes nothing",
        ),
        value(
            "first.FragColor",
            at={"strength": 0.5, "tint": (1.0, 0.5, 0.25)},
            equals=(0.5, 0.25, 0.125, 1.0),
            digits=6,
            name="half of the tint",
        ),
    ],
)
