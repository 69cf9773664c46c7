"""Distance from depth: the inverse of F.

A shader that reads a depth, its own gl_FragCoord.z or a texture's, gets F and not the distance. In
normalised device coordinates d = 2F − 1 the distance is z = 2nf / (f + n − d·(f − n)). This gains
no precision: the distance is as exact as the stored F, to one step of the depth buffer.

Look at: one railway twice, as grey from 0 to 1. On the left is gl_FragCoord.z as it is: almost
white from the first sleeper on, because with n = 0.1 all that is farther away than 2 has an F above
0.95. On the right is z / f, even from black at the camera to white at the far plane.

Try: in `ch06_tests/depth_linear.frag` write `linear / (0.5 * far) :` for `linear / far :`: the
right railway is white from halfway to the far plane on.
"""

from dataclasses import replace

import numpy as np

from shaderlab import Case, Mesh, formula, measure
from shaderlab.glslmath import mix, mul, swizzle, vec3, vec4, where
from shaderlab.reference.depth import distance_of, window_depth
from shaderlab.reference.transforms import clip_position, translate

from ..scenes import stage
from ..scenes.cameras import camera
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, results
from ..scenes.laws import unchanged
from ..scenes.panels import cell
from ..scenes.props import railway

NEAR, FAR = 0.1, 30.0
CAMERA = camera((0.5, 1.2, 1.7), (0.1, 0.55, -3.0), 48.0, near=NEAR, far=FAR)
SEEN = {"model": np.eye(4), **CAMERA, "near": NEAR, "far": FAR}
RAILWAY = Mesh(**railway()).only("aPos", "aColor")
# The same triangles, the last one first.
BACKWARDS = replace(RAILWAY, indices=RAILWAY.indices.reshape(-1, 3)[::-1].ravel())
WHITE = (1.0, 1.0, 1.0, 0.0)


def halves(mesh):
    """The railway's depth on the left, its distance on the right."""
    shader = "ch06_tests/depth_linear"
    return [tested(shader, mesh, {**SEEN, "linearly": k}, cell=cell(int(k), 2)) for k in (0.0, 1.0)]


def linear(frag_coord, near, far):
    """The distance out of gl_FragCoord.z."""
    return distance_of(swizzle(frag_coord, "z"), near, far)


def grey(frag_coord, Color, near, far, linearly):
    """What the picture shows."""
    z = swizzle(frag_coord, "z")
    shown = where(linearly > 0.5, linear(frag_coord, near, far) / far, z)
    return vec4(mix(vec3(shown, shown, shown), Color, 0.12), 1.0)


def seen_distance(aPos, model, view):
    """Minus the third coordinate in the camera's space."""
    return -swizzle(mul(view, mul(model, vec4(aPos, 1.0))), "z")


def there_and_back(z):
    """A distance, through F."""
    return distance_of(window_depth(z, NEAR, FAR), NEAR, FAR)


def error(linear, travelled):
    """The largest error, as a share of the distance."""
    seen = travelled > 0.0
    return (np.abs(linear - travelled)[seen] / travelled[seen]).max()


SIDES = {0: "as it is", 1: "as a distance"}
FARTHER = {"aPos": (0.1, 0.55, -3.0), "model": translate((0.0, 0.0, -2.0))}
HALF = (distance_of(0.5, NEAR, FAR), 0.199336, "half of all codes lie before it")

case = Case(
    title="Distance out of depth",
    section="6.2.2",
    math=r"z = \frac{2\,n f}{f + n - d\,(f - n)}, \qquad d = 2F - 1",
    passes=stage.photographed(
        halves(RAILWAY), (1000, 500), clear=WHITE, reordered=halves(BACKWARDS)
    ),
    picture="picture.FragColor",
    columns=("depth, as stored", "distance"),
    expect=[
        *stage.checks("linear", "travelled", props=False, light=False),
        *each_draw("judged.linear", linear, SIDES, "distance out of depth, {}"),
        *each_draw("judged.FragColor", grey, SIDES, "depth, {}"),
        formula("judged.travelled", unchanged("Distance")),
        formula("judged.Distance", seen_distance, name="distance of a vertex"),
        figure("judged.Distance", "two farther away", FARTHER, 6.73571, digits=5),
        formula("judged.gl_Position", clip_position),
        measure(
            "error of the distance",
            error,
            reads={"linear": "judged.linear", "travelled": "judged.travelled"},
            # F is off by at most five steps of 2⁻²⁴: the division by w by 2½, the viewport, the
            # interpolation and the formula by less than one each. dz/z = z (1/n − 1/f) dF.
            at_most=5.0 * 2.0**-24 * (FAR / NEAR - 1.0),
            note="a step of F below 1 is 6e-8: 2e-5 of the distance at the far plane",
        ),
        *results(
            {"F at z = 2": (window_depth(2.0, NEAR, FAR), 0.953177), "distance at F = ½": HALF}
        ),
        *results({"there and back at z = 12.5": (there_and_back(12.5), 12.5)}, digits=9),
    ],
)
