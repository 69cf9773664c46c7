"""Shadow acne: a surface that shadows itself, and what a bias costs.

A texel of the shadow map stores one depth for all that it covers. Where the surface slants, half of
it lies behind that depth and is darkened in stripes. A bias, taken from each depth before it is
compared, has to cover half a texel of slope: it shrinks with the texels, and grows as light grazes.
A constant one is too small for steep walls, or too large elsewhere: shadows detach from what casts
them. Ray casting shows what is really in shadow and counts both mistakes.

Look at: above no bias, maps of 512² and 2048²: finer stripes, not fewer. Below a constant bias,
which leaves stripes on walls that light grazes, and one that grows with the slope.

Try: in `ch05_lighting/shadow_map.frag` write `bias + 0.01, radius` for `bias, radius`: no stripe is
left, with either map.
"""

from shaderlab import Case, Output, any_order, both_ways, formula, measure, reading
from shaderlab.glslmath.sampling import texture

from ..scenes import shadow_stage as courtyard
from ..scenes.cameras import camera
from ..scenes.courtyard_light import courtyard_references
from ..scenes.panels import cell
from ..scenes.shadow_stage import BOXES, EYE, LIGHT_SPACE, MODEL, SHADOW, SUN, reads
from ..scenes.shadow_truth import against_rays, wrongly_bright, wrongly_dark

CAMERA = tuple(camera(EYE, (-0.42, 0.45, 0.0), 34.5, far=60.0).values())
SIZES = (256, 512, 1024, 2048)
# The least bias, and the one at grazing light, in depth of the map: 0.001 is 8 mm of 8 m.
BIASES = {"none": (0.0, 0.0), "constant": (0.0012, 0.0), "slope": (0.0012, 0.012)}
# The pass that keeps all outputs: the others show the same surfaces.
WHOLE = "slope-256"
PASSES = [(bias, size) for bias in BIASES for size in SIZES]
OTHERS = [one for one in PASSES if one != ("slope", 256)]
LAWS = courtyard_references(texture)
SERIES = {"none": "no bias", "constant": "constant", "slope": "growing with the slope"}


def looked_at(name, texels, bias, radius=0, **target):
    """The courtyard with one map and one bias."""
    least, most = BIASES[bias]
    uniforms = {"leastBias": least, "mostBias": most, "radius": radius}
    shadow_map = Output(f"map-{texels}.depth")
    return courtyard.lit(name, shadow_map, LIGHT_SPACE, MODEL, CAMERA, uniforms, **target)


def surfaces(bias, size):
    """What one of the passes says of the surfaces that all of them show."""
    return reads(WHOLE, "place", "upright", shadow=f"{bias}-{size}.shadow")


def by_rays(bias, size):
    """The map against one that rays make: the same texels, the same bias, nothing rasterised."""
    given = {"size": size, "biases": BIASES[bias]}
    bound = {"at_most": courtyard.EQUAL_SHARE} if bias == "none" else {}
    return reading(f"{SERIES[bias]}, {size}²", reads=surfaces(bias, size), given=given, **bound)


def table(label, statistic, of, **none):
    """One statistic of the places that face the sun, by rays, at every size and with every bias.
    Without a bias it is bounded by `none`; what the others must be follows from `by_rays`."""
    bounds = {"none": none}
    return measure(
        label,
        against_rays(statistic, SUN, BOXES),
        readings=[
            reading(size, reads=surfaces(bias, size), series=SERIES[bias], **bounds.get(bias, {}))
            for bias, size in PASSES
        ],
        x_label="texels along each side of the map",
        y_label=f"share of {of} places",
        log_x=True,
        log_y=True,
        own_types=True,
    )


QUARTERS = [(512, "constant"), (512, "slope"), (512, "none"), (2048, "none")]  # from the lower left

case = Case(
    title="Shadow acne",
    section="5.9.1",
    math=r"b = \max\left(b_1 (1 - N \cdot L),\ b_0\right)",
    passes=(
        *(courtyard.cast(f"map-{size}", LIGHT_SPACE, MODEL, size) for size in SIZES),
        *courtyard.photographed(
            courtyard.in_cell(looked_at("", *QUARTERS[k]), cell(k, 2, 2)) for k in (2, 3, 0, 1)
        ),
        *both_ways(looked_at("filtered", 256, "slope", radius=2, size=(48, 48), colors=SHADOW)),
        looked_at(WHOLE, 256, "slope", size=(128, 128)),
        *(looked_at(f"{b}-{n}", n, b, size=(128, 128), colors=SHADOW) for b, n in OTHERS),
    ),
    picture="picture.FragColor",
    rows=("no bias", "a bias"),
    expect=[
        *courtyard.map_checks("map-256"),
        *(formula(f"{WHOLE}.{output}", law) for output, law in LAWS.items()),
        *(formula(f"{bias}-512.shadow", LAWS["shadow"]) for bias in BIASES),
        *courtyard.single_points(WHOLE),
        formula("filtered.shadow", LAWS["shadow"]),
        any_order("filtered.shadow"),
        courtyard.past_far_plane(WHOLE),
        *courtyard.surface_checks(EYE, BOXES, WHOLE, [f"{b}-{n}" for b, n in OTHERS]),
        *courtyard.picture_checks(EYE, BOXES),
        courtyard.map_of_rays_check(readings=[by_rays(*one) for one in PASSES]),
        # Half of all places have a texel's middle nearer to the light than they are.
        table("wrongly dark", wrongly_dark, "lit", between=(0.47, 0.53)),
        # A texel on an edge is wrong for half of its places: less than one in the shadows' width.
        table("wrongly bright", wrongly_bright, "shadowed", at_most=0.05),
    ],
)
