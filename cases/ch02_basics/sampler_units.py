"""A sampler is a number: which texture unit it reads from, not which texture.

A texture is bound to a unit, and a sampler uniform is told the unit with `glUniform1i`: 0, 1 or 2.
Two mistakes are common. `GL_TEXTURE0` is the unit's name for `glActiveTexture`, 0x84C0, and not its
number: as a sampler's value it is out of range, GL_INVALID_VALUE. And a sampler uniform is an int,
so `glUniform1ui` on it is GL_INVALID_OPERATION. Both leave the sampler as it was. A sampler that
was never set is 0 and reads the texture of unit 0, so all three samplers of a program show the same
texture.

Look at: the first three panels, what `BaseMap`, `ReflectMap` and `RefractMap` read from units 0, 1
and 2, and at the last one, the mixture of all three. Which unit a texture uses makes no difference
as long as its sampler has that number: with the three exchanged, the picture is the same to the
bit.

Try: in `ch02_basics/sampler_units_picture.frag` write `reflected = texture(BaseMap, at)` for
`reflected = texture(ReflectMap, at)`: the second panel shows the first texture, as it does where
the sampler was never set.
"""

import numpy as np

from shaderlab import Case, Output, Texture, assets, exact, formula, fullscreen, gl_call, sweep
from shaderlab.engine.expectations.gl_call import Location, Program, call
from shaderlab.glslmath import fract, max, min, mix, swizzle, vec4, where
from shaderlab.glslmath.sampling import texture

from ..scenes import painted_textures
from ..scenes.panel_checks import enlarged_check
from ..scenes.panels import enlarged, panel, rectangle

MAPS = {
    "BaseMap": Texture(image=painted_textures.crate),
    "ReflectMap": Texture(image=painted_textures.emblem),
    "RefractMap": Texture(image=lambda: assets.checker(size=64, cells=8)),
}
SAMPLERS = tuple(MAPS)
PROGRAM = Program("other-units")


def drawn(name, order):
    """The program with its textures on units 0, 1 and 2 in this order."""
    return fullscreen(
        "ch02_basics/sampler_units.frag",
        name=name,
        uniforms={"reflectance": 0.3},
        textures={sampler: MAPS[sampler] for sampler in order},
    )


def of(sampler, TexCoords):
    """The colour that one sampler reads."""
    return swizzle(texture(sampler, TexCoords), "rgb")


def from_base(BaseMap, TexCoords):
    """Unit 0."""
    return of(BaseMap, TexCoords)


def from_reflect(ReflectMap, TexCoords):
    """Unit 1."""
    return of(ReflectMap, TexCoords)


def from_refract(RefractMap, TexCoords):
    """Unit 2."""
    return of(RefractMap, TexCoords)


def mixture(BaseMap, ReflectMap, RefractMap, TexCoords, reflectance):
    """Half of the base, and half of what is reflected and refracted."""
    light = mix(of(RefractMap, TexCoords), of(ReflectMap, TexCoords), reflectance)
    return vec4(0.5 * of(BaseMap, TexCoords) + 0.5 * light, 1.0)


def in_panels(BaseMap, ReflectMap, RefractMap, place, reflectance):
    """The three textures side by side, then their mixture, each in a frame."""
    at, x = fract(place), swizzle(place, "x")
    color = mixture(BaseMap, ReflectMap, RefractMap, at, reflectance)
    for panel_end, sampler in ((3.0, RefractMap), (2.0, ReflectMap), (1.0, BaseMap)):
        color = where(x < panel_end, vec4(of(sampler, at), 1.0), color)
    s, t = swizzle(at, "x"), swizzle(at, "y")
    frame = (min(s, t) < 0.015) | (max(s, t) > 0.985)
    return where(frame, vec4(0.0, 0.0, 0.0, 1.0), color)


def at(sampler):
    """Where the program has one of its samplers."""
    return Location(sampler, PROGRAM)


def unit_of(sampler, name, unit, **more):
    """The unit that the program says a sampler reads from."""
    return gl_call("glGetUniformiv", PROGRAM, at(sampler), returns=unit, name=name, **more)


case = Case(
    title="Samplers and texture units",
    section="2.3.4",
    math=r"\text{sampler} = u \;\Rightarrow\; \text{texture}(\text{sampler}, st) "
    r"\text{ reads what is bound to GL\_TEXTURE0} + u",
    passes=(
        *enlarged(
            [
                panel(
                    "ch02_basics/sampler_units_picture.frag",
                    {"place": rectangle((0.003, 0.001), (4.0, 1.0))},
                    {"reflectance": 0.3},
                    textures=MAPS,
                )
            ],
            (164, 41),
            7,
        ),
        *drawn("other-units", reversed(SAMPLERS)),
        *drawn("units", SAMPLERS),
    ),
    picture="picture.FragColor",
    expect=[
        formula("base", from_base, name="BaseMap on unit 0"),
        formula("reflected", from_reflect, name="ReflectMap on unit 1"),
        formula("refracted", from_refract, name="RefractMap on unit 2"),
        formula("FragColor", mixture),
        exact("FragColor", Output("other-units.FragColor"), name="other units, same picture"),
        *(
            exact(of, Output(f"other-units.{of}"), name=f"{of}, other units", pictured=False)
            for of in ("base", "reflected", "refracted")
        ),
        formula("small.FragColor", in_panels, name="the panels"),
        enlarged_check(),
        sweep(
            "FragColor",
            mixture,
            over="reflectance",
            values=np.linspace(0.0, 1.0, 11),
            at={"TexCoords": (0.3, 0.6)},
        ),
        *(unit_of(name, f"{name}, never set, is unit 0", 0) for name in SAMPLERS),
        *(
            unit_of(name, f"{name} set to unit {k}", k, before=[call("glUniform1i", at(name), k)])
            for k, name in enumerate(SAMPLERS)
        ),
        *(
            gl_call(
                "glUniform1i",
                at(name),
                f"GL_TEXTURE{unit}",
                raises="invalid_value",
                name=f"GL_TEXTURE{unit} is no value for {name}",
            )
            for unit, name in enumerate(SAMPLERS)
        ),
        gl_call(
            "glUniform1ui",
            at("BaseMap"),
            1,
            raises="invalid_operation",
            name="glUniform1ui does not set a sampler",
        ),
    ],
)
