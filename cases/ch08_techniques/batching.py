"""Batching: the same leaves in N draw calls, in one, and in one with N instances.

A draw call costs the processor the same whether it draws two triangles or two thousand: it checks
state and writes commands. So it is better to draw many small things together. Either their vertices
are put into one buffer, already moved (merged: one call, N times the memory), or one shape is drawn
with attributes that go on once an instance (instanced: one call, a few bytes for each).

Look at: 256 leaves on a grid. All three ways draw the same bits. The table counts calls, vertices
and time; times are this machine's, the ratios are what to look at.

Try: in `ch08_techniques/batching_instanced.vert` write `aPos + 0.5 * aOffset` for `aPos + aOffset`:
the leaves of one draw with 256 instances crowd together in the middle.
"""

import numpy as np

from shaderlab import (
    Case,
    Draw,
    Mesh,
    Output,
    Pass,
    Target,
    attribute_layout,
    cost,
    coverage,
    exact,
    formula,
    query,
)
from shaderlab.glslmath import vec4

COUNTS = (1, 16, 64, 256)
SIDE = 512
PAPER = (0.93, 0.93, 0.88, 1.0)
FOLDER = "ch08_techniques"
# A leaf and its stalk, nine triangles in a square of 1/8. All coordinates are multiples of 2⁻⁹, so
# that they add without rounding, in NumPy as in a shader.
RIM = [(-12, -14), (4, -16), (18, -4), (24, 12), (26, 28), (10, 26), (-6, 16), (-14, 2)]
LEAF = np.array([(0, 0), *RIM, (-28, -28), (-24, -30)]) / 512.0
LEAF_INDICES = np.array([*((0, k, k % 8 + 1) for k in range(1, 9)), (1, 9, 10)]).ravel()


def places(count):
    """The first leaves' places, row by row from below, (count, 2)."""
    k = np.arange(count)
    return np.column_stack([k % 16, k // 16]) / 8.0 - 15.0 / 16.0


def tints(count):
    """Their colours: green to gold from left to right, darker from row to row, (count, 3)."""
    x, y = places(count).T
    level = np.round(64.0 * (0.75 + 0.25 * y)) / 64.0
    return np.column_stack([(0.5 + 0.5 * x) * level, 0.75 * level, 0.25 * level])


def one_by_one(count):
    """N draw calls, two uniforms each."""
    leaf = Mesh(attributes={"aPos": LEAF}, indices=LEAF_INDICES)
    return tuple(
        Draw(
            vertex=f"{FOLDER}/batching.vert",
            fragment=f"{FOLDER}/batching.frag",
            mesh=leaf,
            uniforms={"offset": tuple(place), "tint": tuple(tint)},
        )
        for place, tint in zip(places(count), tints(count), strict=True)
    )


def merged(count):
    """One draw call of one mesh with all leaves in it."""
    mesh = Mesh(
        attributes={
            "aPos": (places(count)[:, None] + LEAF).reshape(-1, 2),
            "aColor": np.repeat(tints(count), len(LEAF), axis=0),
        },
        indices=(len(LEAF) * np.arange(count)[:, None] + LEAF_INDICES).ravel(),
        layout="interleaved",
    )
    shaders = {"vertex": f"{FOLDER}/batching_merged.vert", "fragment": f"{FOLDER}/batching.frag"}
    return (Draw(**shaders, mesh=mesh),)


def instanced(count):
    """One draw call of one leaf with N instances."""
    mesh = Mesh(
        attributes={"aPos": LEAF},
        instance_attributes={"aOffset": places(count), "aTint": tints(count)},
        indices=LEAF_INDICES,
        layout="interleaved",
    )
    shaders = {"vertex": f"{FOLDER}/batching_instanced.vert", "fragment": f"{FOLDER}/batching.frag"}
    return (Draw(**shaders, mesh=mesh, instances=count),)


WAYS = {"one by one": one_by_one, "merged": merged, "instanced": instanced}


def window(way, count):
    """One way of drawing so many leaves."""
    target = Target(size=(SIDE, SIDE), clear=PAPER)
    return Pass(name=f"{way} {count}", target=target, draws=WAYS[way](count))


def moved(aPos, offset):
    """A leaf moved by a uniform."""
    return vec4(aPos + offset, 0.0, 1.0)


def tinted(tint):
    """Its colour, a uniform."""
    return tint


def as_it_is(aPos):
    """A leaf that was moved beforehand."""
    return vec4(aPos, 0.0, 1.0)


def color_of(aColor):
    """Its colour, an attribute."""
    return aColor


def moved_as_instance(aPos, aOffset):
    """A leaf moved by an instance's attribute."""
    return vec4(aPos + aOffset, 0.0, 1.0)


def tint_of(aTint):
    """Its colour, an instance's attribute."""
    return aTint


def flat(Color):
    """The colour as it is."""
    return vec4(Color, 1.0)


MOST = COUNTS[-1]

case = Case(
    title="Batching",
    section="8.5",
    math=r"t(N) = N\,(c + v) \;\text{ in } N \text{ calls}, \qquad t(N) = c + N v "
    r"\;\text{ in one}",
    passes=tuple(window(way, count) for count in COUNTS for way in WAYS),
    picture=f"instanced {MOST}.FragColor",
    expect=[
        *(
            exact(
                f"{way} {count}.FragColor",
                Output(f"one by one {count}.FragColor"),
                name=f"{count} {way}: the same pixels",
            )
            for count in COUNTS
            for way in ("merged", "instanced")
        ),
        formula(f"one by one {MOST}.gl_Position", moved, draw=100, name="one by one: places"),
        formula(f"one by one {MOST}.Color", tinted, draw=100, name="one by one: colours"),
        formula(f"merged {MOST}.gl_Position", as_it_is, name="merged: places"),
        formula(f"merged {MOST}.Color", color_of, name="merged: colours"),
        formula(f"instanced {MOST}.gl_Position", moved_as_instance, name="instanced: places"),
        formula(f"instanced {MOST}.Color", tint_of, name="instanced: colours"),
        formula(f"instanced {MOST}.FragColor", flat, name="instanced: pixels"),
        attribute_layout(
            {"aPos": (0, 8, 0), "aOffset": (0, 20, 1), "aTint": (8, 20, 1)},
            pass_name=f"instanced {MOST}",
            name="instanced: where attributes lie",
        ),
        query(
            "vertices_submitted",
            equals=27 * MOST,
            pass_name=f"instanced {MOST}",
            name="instanced: vertices",
        ),
        coverage(256 * 303, pass_name=f"instanced {MOST}", name="pixels of 256 leaves"),
        cost(
            {way: {count: f"{way} {count}" for count in COUNTS} for way in WAYS},
            claim="one draw call takes less time than N",
            cheaper=("instanced", "one by one"),
            draw_calls={"one by one": lambda n: n, "merged": lambda n: 1, "instanced": lambda n: 1},
            vertices={way: lambda n: 27 * n for way in WAYS},
            repeats=3,
        ),
    ],
)
