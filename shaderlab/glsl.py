"""GLSL functions in tests: `from shaderlab import glsl`, `glsl.load("shaders/lighting.glsl")`."""

from shaderlab.engine.judging.laws import (
    Law as Law,
    bounded as bounded,
    even as even,
    monotone as monotone,
    odd as odd,
    symmetric as symmetric,
)
from shaderlab.functions.checks import (
    idempotent as idempotent,
    inverse as inverse,
    same_as as same_as,
    table as table,
)
from shaderlab.functions.library import Function as Function, Library as Library, load as load
from shaderlab.functions.properties import (
    bools as bools,
    directions as directions,
    example as example,
    floats as floats,
    given as given,
    ints as ints,
    one_of as one_of,
)
