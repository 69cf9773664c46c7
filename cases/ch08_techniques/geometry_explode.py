"""Exploding a mesh: each triangle moves along its own normal.

A geometry shader sees all three corners of a triangle, which no vertex shader does, so it can work
out the plane they lie in: the cross product of two edges is at right angles to it, and points
outwards where corners run counter-clockwise seen from outside. All three corners move the same way
by ½ (sin t + 1), between 0 and 1, so that triangles keep their shape and only gaps open.

Look at: the strip of times. At t = −π/2 the ball is whole; at t = 0 its triangles have moved by ½,
at t = π/2 by 1. No triangle has turned or grown.

Try: in `ch08_techniques/geometry_explode.geom` write `sin(time)` for `(sin(time) + 1.0)`: at t =
−π/2 the triangles have moved inwards.
"""

from math import pi, radians

from shaderlab import Case, Mesh, Variant, formula, query, value
from shaderlab.assets import meshes
from shaderlab.glslmath import cross, dot, max, mul, normalize, sin, sqrt, swizzle, vec3, vec4
from shaderlab.reference.transforms import look_at, perspective, rotate, translate, world_position

from ..scenes import painted_solids as solids
from ..scenes.draws import tested
from ..scenes.figures import results
from ..scenes.laws import entry
from ..scenes.stage import photographed, picture_checks
from ..scenes.still_life import CORAL

BALL = Mesh(**solids.painted(meshes.sphere(0.8, segments=16, rings=10), CORAL))
MODEL = translate((0.1, -0.05, 0.2)) @ rotate(radians(25.0), (1.0, 0.3, 0.0))
VIEW = look_at((0.0, 0.8, 5.0), (0.0, 0.0, 0.0))
PROJECTION = perspective(radians(42.0), 1.0, 0.1, 20.0)

SHADERS = tuple(f"ch08_techniques/geometry_explode.{stage}" for stage in ("vert", "geom", "frag"))
UNIFORMS = {"model": MODEL, "view": VIEW, "projection": PROJECTION, "time": 0.0}
UPWARD = {"fColor": (1.0, 0.5, 0.31), "fNormal": (0.0, 2.0, 0.0)}
DUSK = (0.13, 0.14, 0.17, 1.0)


def magnitude(time):
    """How far triangles have moved."""
    return 0.5 * (sin(time) + 1.0)


def placed(aPos, model):
    """The same with w = 1: the projection is the geometry shader's."""
    return vec4(world_position(aPos, model), 1.0)


def dimmed(aColor, aNormal):
    """Brighter above than below."""
    return aColor * (0.6 + 0.4 * swizzle(aNormal, "y"))


def outwards(VS_OUT_world):
    """The triangle's unit normal."""
    a, b, c = VS_OUT_world
    return normalize(cross(b - a, c - a))


def position(VS_OUT_world, emitted, view, projection, time):
    """A corner moved along the normal, then seen."""
    place = entry(emitted, VS_OUT_world) + magnitude(time) * outwards(VS_OUT_world)
    return mul(projection, mul(view, vec4(place, 1.0)))


def color(VS_OUT_color, emitted):
    """A corner's colour."""
    return entry(emitted, VS_OUT_color)


def shaded(fColor, fNormal):
    """A lamp over the shoulder."""
    lamp = max(dot(normalize(fNormal), vec3(-0.36, 0.80, 0.48)), 0.0)
    return vec4(sqrt(fColor * (0.3 + 0.7 * lamp)), 1.0)


MOVED = {"0": (0.5, 0.0), "1": (0.920735, 1.0), "π∕2": (1.0, pi / 2), "−π∕2": (0.0, -pi / 2)}


def at(name, moved, time):
    """One moment."""
    figures = results({f"moved at {name}": (float(magnitude(time)), moved)})
    return Variant(name, {"time": time}, expect=figures)


case = Case(
    title="An exploding ball",
    section="8.6",
    math=r"p' = p + \tfrac12 (\sin t + 1)\, "
    r"\frac{(p_1 - p_0) \times (p_2 - p_0)}{\lVert (p_1 - p_0) \times (p_2 - p_0) \rVert}",
    passes=photographed([tested(SHADERS, BALL, UNIFORMS)], (512, 512), clear=DUSK),
    picture="picture.FragColor",
    variants=[at(f"t = {name}", *figures) for name, figures in MOVED.items()],
    expect=[
        formula("judged.gl_Position", position),
        formula("judged.fColor", color),
        formula("judged.fNormal", outwards),
        formula("judged.FragColor", shaded),
        *picture_checks(),
        query("geometry_primitives_emitted", equals=288, name="as many triangles as before"),
        formula("judged.gl_in.gl_Position", placed, name="vertices in the world"),
        formula("judged.VS_OUT.world", world_position, name="… handed on"),
        formula("judged.VS_OUT.color", dimmed, name="their colours"),
        value("judged.FragColor", at=UPWARD, equals=(0.927362, 0.655744, 0.516333, 1.0), digits=6),
    ],
)
