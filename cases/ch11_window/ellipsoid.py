"""An ellipsoid: a stretched sphere whose normals are not the stretched ones.

The points with (x/a)² + (y/b)² + (z/c)² = 1 are a unit sphere scaled by a, b and c. Its normal is
the gradient of that sum, (x/a², y/b², z/c²) up to length: it is divided by the half axes where the
point is multiplied by them. A mesh of triangles with its corners on the surface lies inside it, so
its silhouette falls short of the true one, by at most what the flattest triangle leaves: with 64
segments and 32 rings 0.24 % of the radius.

Look at: the light on the two. Both have the same shape, half axes 1, 0.45 and 0.7. On the left the
normals are the gradient's; on the right they are the sphere's, stretched along with it, and the
light falls as if on something rounder: the brightest place is too far down the side.

Try: in `ch11_window/ellipsoid.frag` write `Local / axes;` for `Local / (axes * axes);`: the
sphere's own normals, not stretched, are wrong as well, but less so.
"""

import numpy as np

from shaderlab import Case, Output, Pass, Target, assets, formula, fullscreen, gl_calls
from shaderlab.glslmath import abs, dot, fract, max, mul, normalize, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.transforms import normal_matrix, orthographic

from ..scenes.cameras import turned
from ..scenes.draws import tested
from ..scenes.figures import each_draw, figure, results
from ..scenes.laws import unchanged
from ..scenes.panel_checks import smaller_check, softened_check
from ..scenes.panels import cell, rectangle, softened_pass

AXES = (1.0, 0.45, 0.7)
SOLID = assets.ellipsoid(AXES, segments=64, rings=32)
MODEL = turned(25.0, (0.0, 0.0, 1.0)) @ turned(35.0)
# The view plane, 2.1 by 1.68 of the half axes' units, seen straight on.
PROJECTION = orthographic(-1.05, 1.05, -0.84, 0.84, -2.0, 3.0)
DUSK = (0.10, 0.12, 0.15, 1.0)
LIGHT = np.array([-0.36, 0.80, 0.48])


def ball(stretched, **state):
    """The ellipsoid with one kind of normals or the other."""
    uniforms = {
        "model": MODEL,
        "normalMatrix": 0.5 * normal_matrix(MODEL),
        "projection": PROJECTION,
        "axes": AXES,
        "lightDir": LIGHT,
        "stretched": stretched,
    }
    return tested("ch11_window/ellipsoid", SOLID, uniforms, only=("aPos",), **state)


def quadric():
    """The symmetric matrix Q with xᵀQx = 1 on the ellipsoid as it stands in the view."""
    turn = MODEL[:3, :3]
    return turn @ np.diag(1.0 / np.square(AXES)) @ turn.T


def silhouette():
    """The outline's own matrix S, with pᵀSp = 1: what is left of Q where its z is extreme."""
    q = quadric()
    return q[:2, :2] - np.outer(q[:2, 2], q[2, :2]) / q[2, 2]


def flattest():
    """How near to the centre the mesh comes, in the frame where the ellipsoid is the unit ball."""
    corners = SOLID["attributes"]["aPos"].astype(float) / AXES
    a, b, c = corners[SOLID["indices"]].reshape(-1, 3, 3).transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    return float((np.sum(across * a, axis=1) / np.linalg.norm(across, axis=1)).min())


S = silhouette()
INNER = flattest() ** 2


def outline(covered, plane):
    """1 inside of all that the mesh must cover, 0 outside of the true outline; what the mesh has
    between the two, where it may lie either way."""
    x, y = swizzle(plane, "x"), swizzle(plane, "y")
    k = S[0, 0] * (x * x) + 2.0 * S[0, 1] * (x * y) + S[1, 1] * (y * y)
    measured = swizzle(texture(covered, plane / np.array([2.1, 1.68]) + 0.5), "x")
    return where(k < INNER, 1.0, where(k > 1.0, 0.0, measured))


def clip(aPos, model, projection):
    """Clip coordinates without a view matrix."""
    return mul(projection, mul(model, vec4(aPos, 1.0)))


def gradient(aPos, axes):
    """The gradient of (x/a)² + (y/b)² + (z/c)²."""
    return 2.0 * aPos / (axes * axes)


def surface_normal(Local, axes, normalMatrix, stretched):
    """The unit normal, or the mistaken one."""
    return normalize(mul(normalMatrix, where(stretched > 0.5, Local, Local / (axes * axes))))


def lit(Local, axes, normalMatrix, stretched, lightDir):
    """Lambert's cosine over lines at equal heights."""
    normal = surface_normal(Local, axes, normalMatrix, stretched)
    y = swizzle(Local / axes, "y")
    lines = where(abs(fract(6.0 * y) - 0.5) > 0.46, 0.75, 1.0)
    light = 0.16 + 0.84 * max(dot(normal, lightDir), 0.0)
    return vec4(light * lines * vec3(0.95, 0.62, 0.30), 1.0)


def outer(gl_FrontFacing):
    """Every pixel shows the ellipsoid from outside."""
    return 1.0 + 0.0 * gl_FrontFacing


def stored():
    """The largest difference between the mesh's own normals and the gradient at its points."""
    found = SOLID["attributes"]
    exact = found["aPos"].astype(float) / np.square(AXES)
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    return np.max(np.abs(found["aNormal"] - exact))


NAMES = ("the gradient's", "the sphere's, stretched")
SIDES = [ball(k == 1, cell=cell(k, 2)) for k in range(2)]


def drawn(name, size, draws, colors=None, clear=(0.0, 0.0, 0.0, 0.0)):
    """Draws in a pass, depth tested."""
    target = Target(size=size, colors=colors, depth="depth24", clear=clear)
    return Pass(name=name, target=target, draws=draws)


case = Case(
    title="An ellipsoid",
    section="11.5",
    math=r"n \propto \nabla\!\left(\frac{x^2}{a^2} + \frac{y^2}{b^2} + \frac{z^2}{c^2}\right) = "
    r"2\left(\frac{x}{a^2},\ \frac{y}{b^2},\ \frac{z}{c^2}\right)",
    passes=(
        drawn("scene", (2000, 800), SIDES, {"FragColor": "rgba32f"}, clear=DUSK),
        *softened_pass("scene", (1000, 400), domain={}),
        drawn("both", (80, 32), SIDES, clear=DUSK),
        drawn("mesh", (240, 192), [ball(False)], {"covered": "r32f", "facing": "r32f"}),
        *fullscreen(
            "ch11_window/ellipsoid_silhouette.frag",
            name="silhouette",
            domain={"plane": rectangle((-1.05, -0.84), (2.1, 1.68))},
            textures={"covered": Output("mesh.covered")},
            target=Target(size=(240, 192)),
        ),
    ),
    picture="picture.FragColor",
    columns=("the gradient", "the sphere's normals, stretched"),
    expect=[
        softened_check(),
        smaller_check("both", "scene"),
        formula("mesh.gl_Position", clip),
        formula("mesh.Local", unchanged("aPos")),
        formula("mesh.gradient", gradient),
        *(
            check
            for output, law, what in (
                ("normal", surface_normal, "normals"),
                ("FragColor", lit, "light"),
                ("facing", outer, "the outer side is seen"),
                ("covered", outer, "there it is"),
            )
            for check in each_draw(
                f"both.{output}", law, {k: f"{what}, {side}" for k, side in enumerate(NAMES)}
            )
        ),
        gl_calls(
            "glViewport",
            width=1000,
            height=800,
            pass_name="scene",
            times=2,
            name="each in a viewport of its own",
        ),
        gl_calls(
            "glDrawElementsInstanced",
            mode="GL_TRIANGLES",
            count=2 * 64 * 31 * 3,
            pass_name="scene",
            times=2,
            name="both of 3968 triangles: two for each of 64 · 32 fields, one at the poles",
        ),
        formula("mesh.facing", outer, name="the outer side of the mesh is seen"),
        formula("silhouette.inside", outline, name="the outline against the true one"),
        figure(
            "mesh.normal",
            "(1, 1/4, 4) made unit length",
            {"Local": (1.0, 1.0, 1.0), "axes": (1.0, 2.0, 0.5), "normalMatrix": 2.0 * np.eye(3)},
            (0.242091, 0.060523, 0.968364),
            reference=surface_normal,
        ),
        *results(
            {
                "the mesh's normals are the gradient's": (stored, 0.0),
                "the flattest triangle's distance": (flattest, 0.997595),
            }
        ),
    ],
)
