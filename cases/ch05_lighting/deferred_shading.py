"""Deferred shading: first what is visible, then how it is lit.

Forward shading lights every fragment with every lamp, also those fragments that something nearer
covers later. Deferred shading draws the scene once into several attachments, the G-buffer:
position, normal, and albedo with the specular strength in alpha. A second pass over the screen
reads them and adds up the lamps for what is left, once for each pixel. The sum is the same law on
the same numbers, so the result must be the same, provided that the buffer keeps them: 16-bit floats
round positions to thousandths, and bytes round colours and cannot hold a direction without scaling.

Look at: the three attachments of the G-buffer, places (upper left), normals (upper right), albedo
(lower left), and what sixteen small lamps make of them (lower right). Nothing in the three knows of
any lamp.

Try: in `ch05_lighting/deferred_buffer.frag` write `vec3(0.0, 1.0, 0.0)` for `normalize(Normal)`:
the lamps light every ball as if it lay flat on the floor.
"""

from functools import partial
from math import cos, sin

import numpy as np

from shaderlab import Case, Output, Pass, Target, boundaries, formula, fullscreen, measure, reading
from shaderlab.glslmath import (
    dot,
    either,
    fract,
    length,
    max,
    normalize,
    swizzle,
    vec2,
    vec4,
    where,
)
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.attenuation import attenuation
from shaderlab.reference.lighting import gated, lobe
from shaderlab.reference.transforms import normal_matrix

from ..scenes.cameras import camera, turned
from ..scenes.drawing import encoded
from ..scenes.figures import figure
from ..scenes.lit import BELOW, GRAZING, PAINTED, TURNED_AWAY, thing, vertex_stage_checks
from ..scenes.plaza import plaza

EYE = (0.0, 4.6, 7.4)
MODEL = turned(12.0)
CAMERA = camera(EYE, (0.0, 0.2, 0.4), 36.0, far=30.0)
HUES = ((3.4, 1.5, 0.5), (0.6, 1.7, 3.6), (2.7, 0.6, 1.6), (0.7, 2.6, 1.2))
BUFFER = ("gPosition", "gNormal", "gAlbedoSpec")
HALF = {"gPosition": "rgba16f", "gNormal": "rgba16f", "gAlbedoSpec": "rgba8"}


def lamp(k):
    """Where lamp `k` hangs: on a spiral from the middle outwards, at two heights."""
    angle, away = 2.4 * k, 0.55 + 0.2 * k
    return away * cos(angle), 0.9 + 0.9 * (k % 2), away * sin(angle)


LIGHTS = {
    name: setting
    for k in range(16)
    for name, setting in {
        f"lamps[{k}].position": lamp(k),
        f"lamps[{k}].color": tuple(1.5 * c for c in HUES[k % 4]),
    }.items()
}


def scene(name, fragment, uniforms, segments=40, **target):
    """The plaza in one of the two ways."""
    # Half as long as they were: the fragment shader is to make them whole again.
    uniforms = {"normalMatrix": 0.5 * normal_matrix(MODEL), **uniforms}
    shader, solid = f"ch05_lighting/{fragment}", plaza(segments=segments)
    draw = thing(shader, solid, MODEL, CAMERA, uniforms, vertex=PAINTED)
    return Pass(name=name, target=Target(depth="depth24", **target), draws=(draw,))


def lit(name, buffer):
    """The second pass: the lamps on what a buffer holds."""
    return fullscreen(
        "ch05_lighting/deferred_lit.frag",
        name=name,
        uniforms={**LIGHTS, "viewPos": EYE},
        textures={output: Output(f"{buffer}.{output}") for output in BUFFER},
    )


def all_lamps(place, normal, albedo, gloss, viewPos, places, colors, gate):
    """The law of both ways: every lamp's diffuse and specular part on one surface."""
    total = 0.03 * albedo
    for position, color in zip(places, colors, strict=True):
        ray = position - place
        light, view = normalize(ray), normalize(viewPos - place)
        cosine = dot(normal, light)  # 0 where the buffer holds no surface, and no normal
        glint = gate(cosine, lobe(dot(normal, normalize(light + view)), 32.0)) * gloss
        fading = attenuation(length(ray), 1.0, 1.4, 3.6)
        total = total + fading * color * (albedo * max(cosine, 0.0) + glint)
    return vec4(total, 1.0)


def gated_or_not(cosine, share):
    """A highlight on faces towards the lamp, or on all: that has a check of its own."""
    return either(gated(cosine, share), share)


def forward(FragPos, Normal, Color, viewPos, lamps_position, lamps_color, gate=gated_or_not):
    """Light on a fragment while it is drawn."""
    gloss = 0.8 * swizzle(Color, "r")
    lamps = (lamps_position, lamps_color)
    return all_lamps(FragPos, normalize(Normal), Color, gloss, viewPos, *lamps, gate)


def deferred(
    gPosition, gNormal, gAlbedoSpec, TexCoords, viewPos, lamps_position, lamps_color,
    gate=gated_or_not,
):  # fmt: skip
    """Light on what the buffer holds."""
    place, normal, surface = (
        texture(buffer, TexCoords) for buffer in (gPosition, gNormal, gAlbedoSpec)
    )
    albedo, gloss = swizzle(surface, "rgb"), swizzle(surface, "a")
    return all_lamps(
        swizzle(place, "rgb"), swizzle(normal, "rgb"), albedo, gloss, viewPos,
        lamps_position, lamps_color, gate,
    )  # fmt: skip


def shown(gPosition, gNormal, gAlbedoSpec, lit, TexCoords):
    """The picture: a quarter each, as colours or encoded; the mean of four texels."""
    right, above = (swizzle(TexCoords, axis) > 0.5 for axis in "xy")
    height, width = lit.texels.values.shape[:2]

    def read(x, y):
        at = fract(2.0 * TexCoords) + vec2(0.25 * x / width, 0.25 * y / height)
        place, normal, albedo, light = (
            swizzle(texture(buffer, at), "rgb") for buffer in (gPosition, gNormal, gAlbedoSpec, lit)
        )
        raw = where(right, 0.5 + 0.5 * normal, 0.5 + 0.14 * place)
        return where(above, raw, encoded(where(right, light, albedo)))

    return vec4(0.25 * (read(-1, -1) + read(1, 1) + read(-1, 1) + read(1, -1)), 1.0)


def place_of(FragPos):
    """The first attachment."""
    return FragPos


def normal_of(Normal):
    """The second."""
    return normalize(Normal)


def surface_of(Color):
    """The third: albedo, and the specular strength in alpha."""
    return vec4(Color, 0.8 * swizzle(Color, "r"))


def largest_difference(lit, forward):
    """Between the two ways, of any pixel and channel."""
    return np.abs(lit - forward).max()


def difference(label, buffer, **bound):
    """The two ways compared, with one kind of buffer."""
    reads = {"lit": f"{buffer}.FragColor", "forward": "forward.FragColor"}
    return reading(label, reads=reads, **bound)


POINT = {"FragPos": (0.0, 0.0, 0.0), "Normal": (0.0, 1.0, 0.0), "Color": (0.5, 0.5, 0.5)}
IN_THE_MIDDLE, AMBIENT = (1.010453, 0.657102, 0.704490, 1.0), (0.015, 0.015, 0.015, 1.0)
LAMPS_BELOW = {f"lamps[{k}].position": BELOW for k in range(16)}
ALL_BELOW = {**GRAZING, "Color": (0.5, 0.5, 0.5), **LAMPS_BELOW}
GATED = partial(forward, gate=gated)

case = Case(
    title="Deferred shading",
    section="5.12",
    math=r"G(x, y) = (p,\ n,\ a,\ s), \qquad c(x, y) = \sum_i L_i(p, n, a, s)",
    passes=(
        scene("buffer", "deferred_buffer.frag", {}),
        *lit("lit", "buffer"),
        scene("forward", "deferred_forward.frag", {**LIGHTS, "viewPos": EYE}, clear=(0, 0, 0, 1)),
        scene("small-buffer", "deferred_buffer.frag", {}, colors=HALF),
        *lit("small-lit", "small-buffer"),
        *fullscreen(
            "ch05_lighting/deferred_picture.frag",
            name="picture",
            textures={
                **{output: Output(f"buffer.{output}") for output in BUFFER},
                "lit": Output("lit.FragColor"),
            },
        ),
    ),
    picture="picture.FragColor",
    expect=[
        *vertex_stage_checks("gl_Position", "FragPos", "Normal", "Color", pass_name="buffer"),
        formula("buffer.gPosition", place_of),
        formula("buffer.gNormal", normal_of),
        formula("buffer.gAlbedoSpec", surface_of),
        formula("lit.FragColor", deferred, name="deferred"),
        *vertex_stage_checks("Normal", pass_name="forward"),
        formula("picture.FragColor", shown, name="the picture"),
        boundaries("picture.FragColor", shown, name="the picture's quarters"),
        formula("forward.FragColor", forward, name="forward"),
        measure(
            "largest difference from forward shading",
            largest_difference,
            readings=[
                # The same numbers in the same sums. A dot product that is fused in one shader alone
                # is two roundings apart, 2⁻²³, and so is the half-way vector: a highlight is the
                # 32nd power of their cosine, and its errors are 32 times as large.
                difference(
                    "places, normals and colours as 32-bit floats", "lit", at_most=64 * 2.0**-23
                ),
                # Half floats keep places to 2⁻¹⁰ and bytes colours to 2⁻⁹: that must show, and may
                # be ten times as much in a highlight.
                difference("16-bit floats, colours in bytes", "small-lit", between=(1e-4, 2e-2)),
            ],
        ),
        figure("forward.FragColor", "a grey point in the middle", POINT, IN_THE_MIDDLE),
        figure(
            "forward.FragColor",
            TURNED_AWAY,
            ALL_BELOW,
            AMBIENT,
            reference=partial(forward, gate=gated),
        ),
    ],
)
