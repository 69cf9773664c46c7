"""An ellipsoid: a stretched globe whose normals are not the stretched ones.

The points with (x/a)² + (y/b)² + (z/c)² = 1 are a globe scaled by a, b and c. Its normal is the
gradient of that sum, (x/a², y/b², z/c²) up to length: it is divided by the half axes where the
point is multiplied by them. A mesh of triangles with its corners on the surface lies inside it, so
its silhouette falls short of the true one, by at most what the flattest triangle leaves: with 64
segments and 32 rings 0.24 % of the radius.

Look at: the light on the two. Both have the same shape, half axes 1, 0.45 and 0.7. On the left the
normals are the gradient's; on the right they are the globe's, stretched along with it, and the
light falls as if on something rounder: the brightest place is too far down the side.
"""

from math import radians

import numpy as np

from shaderlab import (
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Ramp,
    State,
    Target,
    assets,
    computed,
    formula,
    fullscreen,
    value,
)
from shaderlab.glslmath import abs, dot, fract, max, mul, normalize, swizzle, vec3, vec4, where
from shaderlab.reference.transforms import normal_matrix, orthographic, rotate
from shaderlab.sampling import texture

AXES = (1.0, 0.45, 0.7)
SOLID = assets.ellipsoid(AXES, segments=64, rings=32)
MODEL = rotate(radians(25.0), (0.0, 0.0, 1.0)) @ rotate(radians(35.0), (0.0, 1.0, 0.0))
# The view plane, 2.1 by 1.68 of the half axes' units, seen straight on.
PROJECTION = orthographic(-1.05, 1.05, -0.84, 0.84, -2.0, 3.0)
LIGHT = np.array([-0.36, 0.80, 0.48])


def ball(stretched, **state):
    """The ellipsoid with one kind of normals or the other."""
    return Draw(
        vertex="ch11_window/ellipsoid.vert",
        fragment="ch11_window/ellipsoid.frag",
        mesh=Mesh(**SOLID).only("aPos"),
        uniforms={
            "model": MODEL,
            "normalMatrix": normal_matrix(MODEL),
            "projection": PROJECTION,
            "axes": AXES,
            "lightDir": LIGHT,
            "stretched": stretched,
        },
        state=State(depth=Depth(), **state),
    )


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


def same(aPos):
    """The point itself."""
    return aPos


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


def two(name, size):
    """Both kinds of normals side by side."""
    sides = (Cell(column=k, row=0, columns=2, rows=1) for k in (0, 1))
    return Pass(
        name=name,
        target=Target(size=size, depth="depth24", clear=(0.10, 0.12, 0.15, 1.0)),
        draws=tuple(ball(k == 1, cell=cell) for k, cell in enumerate(sides)),
    )


case = Case(
    title="An ellipsoid",
    section="11.5",
    math=r"n \propto \nabla\!\left(\frac{x^2}{a^2} + \frac{y^2}{b^2} + \frac{z^2}{c^2}\right) = "
    r"2\left(\frac{x}{a^2},\ \frac{y}{b^2},\ \frac{z}{c^2}\right)",
    passes=(
        two("scene", (2000, 800)),
        *fullscreen(
            "ch03_transforms/soften.frag",
            name="picture",
            domain={},
            textures={"scene": Output("scene.FragColor")},
            target=Target(size=(1000, 400)),
        ),
        two("both", (120, 48)),
        Pass(name="mesh", target=Target(size=(240, 192), depth="depth24"), draws=(ball(False),)),
        *fullscreen(
            "ch11_window/ellipsoid_silhouette.frag",
            name="silhouette",
            domain={"plane": Ramp((-1.05, -0.84), (2.1, 0.0), (0.0, 1.68))},
            textures={"covered": Output("mesh.covered")},
            target=Target(size=(240, 192)),
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("mesh.gl_Position", clip),
        formula("mesh.Local", same),
        formula("mesh.gradient", gradient),
        formula("both.normal", surface_normal, draw=0, name="the gradient's normals"),
        formula("both.normal", surface_normal, draw=1, name="the globe's, stretched"),
        formula("both.FragColor", lit, draw=0, name="light on the left"),
        formula("both.FragColor", lit, draw=1, name="light on the right"),
        *(
            formula(f"{name}.facing", outer, draw=k, name=f"the outer side is seen: {name} {k}")
            for name, k in (("both", 0), ("both", 1), ("mesh", 0))
        ),
        formula("silhouette.inside", outline, name="the outline against the true one"),
        value(
            "mesh.normal",
            at={"Local": (1.0, 1.0, 1.0), "axes": (1.0, 2.0, 0.5), "normalMatrix": 2.0 * np.eye(3)},
            equals=(0.242091, 0.060523, 0.968364),
            digits=6,
            reference=surface_normal,
            name="(1, 1/4, 4) made unit length",
        ),
        computed("the mesh's normals are the gradient's", stored, equals=0.0, digits=6),
        computed("the flattest triangle's distance", flattest, equals=0.997595, digits=6),
    ],
)
