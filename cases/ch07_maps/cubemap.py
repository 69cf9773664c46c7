"""A cube map: six images around a point, and a direction in place of coordinates.

The largest of the three components, by its size, says which face the direction meets: +X, −X, +Y,
−Y, +Z or −Z, in this order. The other two, divided by it, are the place on that face. So the length
of the direction does not matter, and nothing has to be normalised. Which component becomes s and
which t, and with which sign, is a table. On the four faces around t runs down, so files, which
begin with their upper rows, are uploaded as they are: right, left, top, bottom, back and front. And
s runs to the right for a viewer outside: inside, where a sky is seen from, each face is a mirror
image.

Look at: a ball and a cube that are wrapped in the same six charts, each face in a colour of its
own, with figures that count along s and then along t; as t runs down, they stand on their heads. On
the ball the fields shrink towards the corners of the cube: texels there stand for a smaller part of
the sphere. On the right the cube is unfolded, its outer side up: −X, +Z, +X and −Z in a row, +Y
above +Z and −Y below it.

Try: in `ch07_maps/cubemap_ball.frag` write `textureLod(faces, normal, 0.0)` for `textureLod(faces,
FragPos, 0.0)`: the ball stays as it is, and each face of the cube reads a single texel.
"""

from dataclasses import replace
from math import radians

import numpy as np

from shaderlab import Case, Cell, CubeTexture, assets, measure
from shaderlab.glslmath import dot, max, normalize, swizzle, vec4
from shaderlab.glslmath.sampling import textureLod
from shaderlab.reference.cube_maps import face_coordinates
from shaderlab.reference.transforms import look_at, perspective, rotate

from ..scenes import painted_textures, stage
from ..scenes.cameras import directions
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figures
from ..scenes.laws import sampled
from ..scenes.lit import vertex_stage_checks
from ..scenes.panels import cell, panel, picture

COLORS = (
    (1.0, 0.45, 0.38), (0.38, 0.85, 0.88), (0.58, 0.86, 0.42),
    (0.84, 0.48, 0.86), (0.46, 0.60, 1.0), (1.0, 0.84, 0.34),
)  # fmt: skip
NAMES = ("+X", "−X", "+Y", "−Y", "+Z", "−Z")
LIGHT = np.array([0.35, 0.75, 0.56]) / np.linalg.norm([0.35, 0.75, 0.56])


def chart(face):
    """A face of the picture: the chart's fields and figures in the face's own colour."""
    grey = painted_textures.uv_grid(256, 4)[..., :3].mean(axis=-1, keepdims=True)
    board = 0.55 + 0.75 * (grey - 0.3)
    return np.concatenate([board * COLORS[face], np.ones((256, 256, 1))], axis=-1)


def numbered(face, side=4):
    """A face to be judged: each texel says its face, column and row."""
    row, column = np.mgrid[0:side, 0:side].astype(float)
    return np.stack([face + 0.0 * row, column, row, 1.0 + 0.0 * row], axis=-1)


CHARTS = CubeTexture(faces=[lambda face=face: chart(face) for face in range(6)])
NUMBERED = CubeTexture(faces=[numbered(face) for face in range(6)])
# A file for each face, from above: 40 times the face, 60 times the column, 60 times the row.
FILES = CubeTexture(
    faces=[f"cubemap/{name}.ppm" for name in ("right", "left", "top", "bottom", "back", "front")],
    format="rgb32f",
)

# Each field looks along an axis, a little more than a face wide: right, up and forward there.
VIEWS = {
    "+X": ((0, 0, -1), (0, 1, 0), (1, 0, 0)), "−X": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    "+Y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)), "−Y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "+Z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "−Z": ((-1, 0, 0), (0, 1, 0), (0, 0, -1)),
}  # fmt: skip
REACH = 1.29


def looking(index, name, faces=NUMBERED):
    """One of six fields, with directions of very different lengths."""
    right, above, forward = (np.array(axis, float) for axis in VIEWS[name])
    size = 0.5 + 0.75 * index
    along = directions(size * REACH * right, size * REACH * above, size * forward)
    return panel(
        "ch07_maps/cubemap.frag",
        {"direction": along},
        {"stretch": 3.0},
        textures={"faces": faces},
        cell=cell(index, 3, 2),
    )


def texel(faces, direction):
    """What the specification's table finds."""
    return textureLod(faces, direction, 0.0)


def stretched(faces, direction, stretch):
    """The same of a longer direction, rounded once more."""
    return textureLod(faces, direction * stretch, 0.0)


VIEW = look_at((1.6, 1.9, 5.2), (0.0, 0.0, 0.0))
PROJECTION = perspective(radians(30.0), 1.0, 0.1, 100.0)
# Where the unfolded cube's faces are, among cells of 16 columns and 5 rows.
CROSS = {"−X": (11, 2), "+Z": (12, 2), "+X": (13, 2), "−Z": (14, 2), "+Y": (12, 3), "−Y": (12, 1)}


def wrapped(geometry, model):
    """A solid around the origin, coloured by the direction of each of its points."""
    uniforms = {"view": VIEW, "projection": PROJECTION, "normalMatrix": 0.5 * model[:3, :3]}
    return tested(
        ("ch07_maps/placed.vert", "ch07_maps/cubemap_ball.frag"),
        geometry,
        {"model": model, "light": LIGHT, **uniforms},
        only=("aPos", "aNormal"),
        textures={"faces": CHARTS},
        cell=cell(0 if model is BALL else 1, 3),
    )


def unfolded(name, column, row):
    """A face of the cross, which fills its cell."""
    along = directions(*VIEWS[name])
    shader, place = "ch13_skybox/skybox.frag", Cell(column=column, row=row, columns=16, rows=5)
    return panel(shader, {"TexCoords": along}, textures={"skybox": CHARTS}, cell=place)


# The ball is turned, which nothing shows: colours go by directions in the world.
BALL, BOX = rotate(radians(25.0), (1.0, 2.0, 0.5)), np.diag([0.999, 0.999, 0.999, 1.0])
SOLIDS = [wrapped(assets.sphere(1.15, 96, 48), BALL), wrapped(assets.cube(1.7), BOX)]
FACES = [unfolded(name, *place) for name, place in CROSS.items()]
SIDES = dict(enumerate(CROSS, len(SOLIDS)))


def share_of_faces(texels, table):
    """The share of pixels where both name the same face, edges aside, where either may be right."""
    far = np.all(np.abs(table[..., 1:] - 0.5) < 0.499, axis=-1)
    return float(np.mean(texels[far][:, 0] == table[far][:, 0]))


def unlike(files, texels):
    """How many pixels show another face, column or row of the files than of the arrays."""
    codes = np.rint(255.0 * files[..., :3]) / (40.0, 60.0, 60.0)
    return int((codes != texels[..., :3]).any(axis=-1).sum())


def painted(faces, FragPos, Normal, light):
    """The chart's colour in a simple light."""
    shade = 0.45 + 0.55 * max(dot(normalize(Normal), light), 0.0)
    return vec4(shade * swizzle(textureLod(faces, FragPos, 0.0), "rgb"), 1.0)


# A direction, and what the table makes of it: face, s, t.
DIRECTIONS = {
    "(2, ½, −1) meets +X": ((2.0, 0.5, -1.0), (0.0, 0.75, 0.375)),
    "−X is the second face": ((-1.0, 0.0, 0.0), (1.0, 0.5, 0.5)),
    "+Y is the third": ((0.0, 5.0, 0.0), (2.0, 0.5, 0.5)),
    "(¼, −1, ½) meets −Y": ((0.25, -1.0, 0.5), (3.0, 0.625, 0.25)),
    "x goes before y where both are as large": ((1.0, -1.0, 0.5), (0.0, 0.25, 1.0)),
    "+X, very short": ((0.005, 0.0, 0.0), (0.0, 0.5, 0.5)),
    "+Y, very short": ((0.0, 0.005, 0.0), (2.0, 0.5, 0.5)),
    "+Z, very short": ((0.001, 0.0, 0.005), (4.0, 0.6, 0.5)),
    "an upward direction, very short": ((0.001, 0.005, 0.002), (2.0, 0.6, 0.7)),
    "a sideward direction, very short": ((0.005, 0.002, 0.001), (0.0, 0.4, 0.3)),
    "+Z is the fifth, however short": ((0.0, 0.0, 0.01), (4.0, 0.5, 0.5)),
    "−Z is the last, however long": ((0.0, 0.0, -900.0), (5.0, 0.5, 0.5)),
}

case = Case(
    title="A cube map",
    section="7.4",
    math=r"s = \tfrac12\left(\frac{s_c}{|m_a|} + 1\right), \qquad t = \tfrac12\left("
    r"\frac{t_c}{|m_a|} + 1\right), \qquad m_a = \text{the component of the largest size}",
    passes=(
        # Both solids are convex: without a depth test, too, it is enough to leave out far sides.
        *stage.photographed(
            [*SOLIDS, *FACES],
            (1280, 400),
            clear=(0.93, 0.93, 0.92, 1.0),
            reordered=[
                *FACES,
                *(replace(s, state=replace(s.state, depth=None, cull="back")) for s in SOLIDS),
            ],
        ),
        picture((looking(k, name) for k, name in enumerate(NAMES)), (120, 80), "main"),
        picture(
            (looking(k, name, FILES) for k, name in enumerate(NAMES)),
            (120, 80),
            "six files",
            colors={"FragColor": "rgba32f"},
        ),
    ),
    picture="picture.FragColor",
    columns=("ball", "cube", "unfolded"),
    expect=[
        *stage.picture_checks(),
        *each_draw("main.FragColor", texel, enumerate(NAMES), "texels around {}"),
        *each_draw("main.byHand", face_coordinates, enumerate(NAMES), "the table around {}"),
        *each_draw("main.onceMore", stretched, enumerate(NAMES), "three times as long around {}"),
        measure(
            "six files: texels of another face, column or row",
            unlike,
            reads={"files": "six files.FragColor", "texels": "main.FragColor"},
            equals=0,
            digits=0,
        ),
        measure(
            "the texel's face is the table's",
            share_of_faces,
            reads={"texels": "main.FragColor", "table": "main.byHand"},
            at_least=1.0,
        ),
        *each_draw("judged.FragColor", painted, {0: "the ball's colours", 1: "the cube's colours"}),
        *each_draw(
            "judged.FragColor", sampled("skybox"), dict(enumerate(CROSS, 2)), "unfolded, {}"
        ),
        *vertex_stage_checks(pass_name="judged", draw=0),
        *figures(
            "main.byHand",
            {name: ({"direction": way}, found) for name, (way, found) in DIRECTIONS.items()},
            reference=face_coordinates,
        ),
    ],
)
