"""Shadow acne: a surface that shadows itself, and what a bias costs.

A texel of the shadow map stores one depth for all of the surface that it covers. Where the surface
slants, half of that lies behind the stored depth, and darkens itself in stripes. A bias, taken
from each depth before it is compared, has to cover half a texel of slope: so it shrinks with
the texels, and must grow as light grazes. A constant one is too small for steep walls, or too
large everywhere else, where shadows then come loose from what throws them. Rays say
what is really in shadow, so both mistakes can be counted.

Look at: the same courtyard four times. Above without a bias, with a map of 512² on the left and of
2048² on the right: finer stripes, not fewer. Lower left a constant bias, which leaves stripes
on the walls that light grazes; lower right one that grows with the slope.
"""

from dataclasses import replace
from math import radians

from shaderlab import Case, Cell, Output, Pass, Target, formula, fullscreen, measure, reading, value
from shaderlab.reference.transforms import look_at, orthographic, perspective, rotate
from shaderlab.sampling import texture

from ..scenes.courtyard import boxes
from ..scenes.courtyard_light import courtyard_references, light_position, stored_depth
from ..scenes.shadow_stage import EYE, PICTURED, SUN, cast, lit, single_points
from ..scenes.shadow_truth import blocked, hidden_share, wrongly_bright, wrongly_dark
from ..scenes.studio import finished

MODEL = rotate(radians(6.0), (0.0, 1.0, 0.0))
BOXES = [MODEL @ box for box in boxes()]
LIGHT_SPACE = orthographic(-6.0, 6.0, -6.0, 6.0, 1.0, 9.0) @ look_at(SUN, (0.0, 0.0, 0.0))
CAMERA = look_at(EYE, (0.0, 0.4, 0.1)), perspective(radians(36.0), 1.0, 0.1, 60.0)
SIZES = (256, 512, 1024, 2048)
# The least bias, and the one at grazing light, in depth of the map: 0.001 is 8 mm of 8 m.
BIASES = {"none": (0.0, 0.0), "constant": (0.0012, 0.0), "slope": (0.0012, 0.012)}
PASSES = [f"{bias}-{size}" for bias in BIASES for size in SIZES]
LAWS = courtyard_references(texture)
SERIES = {"none": "no bias", "constant": "constant", "slope": "growing with the slope"}
# Between what the shares lie, at each of the sizes.
DARK = {
    "none": [(0.47, 0.53)] * 4,
    "constant": [(0.13, 0.17), (0.016, 0.021), (0.009, 0.012), (0.0005, 0.0013)],
    "slope": [(0.03, 0.045), (0.0006, 0.0015), (0.0004, 0.0010), (0.0, 0.0002)],
}
BRIGHT = {
    "none": [(0.02, 0.035), (0.012, 0.019), (0.003, 0.007), (0.001, 0.0025)],
    "constant": [(0.038, 0.05), (0.018, 0.026), (0.008, 0.0125), (0.005, 0.009)],
    "slope": [(0.038, 0.05), (0.018, 0.026), (0.008, 0.0125), (0.005, 0.009)],
}


def drawn(FragColor):
    """The share of pixels that show anything: the floor reaches to all edges."""
    return (FragColor[..., 3] > 0.0).mean()


def looked_at(name, texels, bias, radius=0, **target):
    """The courtyard with one map and one bias."""
    least, most = BIASES[bias]
    uniforms = {"leastBias": least, "mostBias": most, "radius": radius}
    shadow_map = Output(f"map-{texels}", "depth")
    return lit(name, shadow_map, LIGHT_SPACE, MODEL, CAMERA, uniforms, **target)


def quarter(column, row, size, bias):
    """One quarter of the picture."""
    (draw,) = looked_at("", size, bias).draws
    return replace(
        draw, state=replace(draw.state, cell=Cell(column=column, row=row, columns=2, rows=2))
    )


def counted(statistic):
    """A statistic of the places that are drawn and face the sun, by rays."""

    def share(FragColor, shadow, place, upright):
        facing = (upright * SUN).sum(axis=-1) > 0.0
        there = (FragColor[..., 3] > 0.0) & facing
        return statistic(shadow[..., 0], blocked(place, SUN, BOXES), there)

    return share


def table(label, statistic, shares, of):
    """One statistic at every size and with every bias."""
    outputs = ("FragColor", "shadow", "place", "upright")
    return measure(
        label,
        counted(statistic),
        readings=[
            reading(
                size,
                reads={output: f"{bias}-{size}.{output}" for output in outputs},
                series=SERIES[bias],
                between=bounds,
            )
            for bias in BIASES
            for size, bounds in zip(SIZES, shares[bias], strict=True)
        ],
        x_label="texels along each side of the map",
        y_label=f"share of {of} places",
        log_x=True,
        log_y=True,
    )


case = Case(
    title="Shadow acne",
    section="5.9.1",
    math=r"b = \max\left(b_1 (1 - N \cdot L),\ b_0\right)",
    passes=(
        *(cast(f"map-{size}", LIGHT_SPACE, MODEL, size) for size in SIZES),
        Pass(
            name="scene",
            target=Target(
                size=(1024, 1024),
                colors=PICTURED,
                depth="depth24",
            ),
            draws=(
                quarter(0, 1, 512, "none"),
                quarter(1, 1, 2048, "none"),
                quarter(0, 0, 512, "constant"),
                quarter(1, 0, 512, "slope"),
            ),
        ),
        *fullscreen(
            "ch05_lighting/finish.frag",
            name="picture",
            textures={"scene": Output("scene", "FragColor")},
        ),
        looked_at("filtered", 256, "slope", radius=2, size=(48, 48)),
        *(
            looked_at(f"{bias}-{size}", size, bias, size=(128, 128))
            for bias in BIASES
            for size in SIZES
        ),
    ),
    picture="picture.FragColor",
    expect=[
        formula("map-256.gl_Position", light_position),
        formula("map-256.depth", stored_depth),
        *(formula(f"slope-256.{output}", law) for output, law in LAWS.items()),
        *(formula(f"{bias}-512.shadow", LAWS["shadow"]) for bias in BIASES),
        formula("picture.FragColor", finished(texture), name="the picture"),
        *single_points("slope-256"),
        formula("filtered.shadow", LAWS["shadow"]),
        value(
            "slope-256.shadow",
            at={
                "FragPosLightSpace": (0.0, 0.0, 1.01, 1.0),
                "FragPos": (0.0, 0.0, 0.0),
                "Normal": (0.0, 1.0, 0.0),
                "Color": (1.0, 1.0, 1.0),
            },
            equals=0.0,
            digits=6,
            name="past the far plane nothing is dark",
        ),
        measure(
            "places hidden from the eye",
            hidden_share(EYE, BOXES, step=1),
            readings=[
                reading(name, reads={key: f"{name}.{key}" for key in ("FragColor", "place")})
                for name in ("filtered", *PASSES)
            ],
            at_most=0.002,
        ),
        measure(
            "share of the large picture that is drawn",
            drawn,
            reads={"FragColor": "scene.FragColor"},
            at_least=0.99,
        ),
        measure(
            "places hidden from the eye, in the large picture",
            hidden_share(EYE, BOXES, step=8),
            reads={key: f"scene.{key}" for key in ("FragColor", "place")},
            at_most=0.002,
        ),
        table("wrongly dark", wrongly_dark, DARK, "lit"),
        table("wrongly bright", wrongly_bright, BRIGHT, "shadowed"),
    ],
)
