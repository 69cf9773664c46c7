"""One call for each type: float, int, uint, a vector, arrays, a member of a struct, a matrix.

`glUniform` comes in many forms, and the suffix says what is sent: `1f`, `1i`, `1ui`, `3f`, `4fv`.
A form that does not fit the declared type is an error, and nothing is set. A struct has no form of
its own: each member is a uniform by the name `material.shininess`, each element of an array one by
`pairs[1]`. What arrives is what was sent, bit for bit, for no arithmetic has happened yet.

Look at: the eight instruments, each of which shows one uniform and nothing else. From the upper
left a float, an int as so many dots, the low byte of a uint, a vec3 as a colour; below them
float[4], vec2[2], a struct as a ball of that material, and the columns of a mat2x3. In the second
variant all of them have moved.
"""

import numpy as np

from shaderlab import Case, Ramp, Target, Variant, exact, fullscreen

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
    return [exact(name, expected) for name, expected in whole.items()]


case = Case(
    title="Uniforms of every type",
    section="2.3.4",
    math=r"\text{glUniform}\{1,2,3,4\}\{f, i, ui\}[v], \qquad "
    r"\text{glUniformMatrix}\{2,3,4\}[\times\{2,3,4\}]fv",
    passes=(
        *fullscreen(
            "ch02_basics/uniform_types_picture.frag",
            name="picture",
            domain={"place": Ramp((0.0, 0.0), (4.0, 0.0), (0.0, 2.0))},
            uniforms=FIRST,
            target=Target(size=(1024, 512)),
        ),
        *fullscreen("ch02_basics/uniform_types.frag", domain={}, uniforms=FIRST),
    ),
    picture="picture.FragColor",
    expect=[],
    variants=[
        Variant("first", expect=arrives(FIRST)),
        Variant("second", SECOND, expect=arrives(SECOND)),
    ],
)
