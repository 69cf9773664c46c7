"""Cascaded shadow maps: a map for what is near, another for what is far.

One map for a long view spends as many texels on a post sixty metres away as on the one at your
feet, which covers a hundred times as many pixels. So the view is cut into slices, and each gets a
map fitted around it. Where to cut? In equal parts the first slice is still much too deep. In equal
ratios, dᵢ = n (f/n)^(i/N), near things get the best shadows, but most of the road has to share the
last map. The practical scheme is the mean of both. The depth of a fragment tells its cascade, and
rays tell how many shadows each scheme gets wrong, near and everywhere.

Look at: an avenue. Above, each of three cascades in a colour of its own: red, green, blue. Below,
their shadows: as sharp at the end of the road as at its beginning.

Try: in `ch05_lighting/cascaded_shadows.frag` write `i < 0` for `i < CASCADES - 1`: the first map
serves the whole road, and past its end half of the ground is dark.
"""

from itertools import pairwise

import numpy as np

from shaderlab import Case, Output, TextureArray, any_order, both_ways, formula, measure, reading
from shaderlab.glslmath import dot, max, mix, mul, normalize, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference.cascades import cascade_index, fitted, slice_corners, split_distances
from shaderlab.reference.shadows import shadow, shadow_coordinates, slope_bias
from shaderlab.reference.transforms import look_at, translate

from ..scenes import lit, shadow_stage
from ..scenes.cameras import camera, turned
from ..scenes.courtyard import avenue, avenue_boxes, before
from ..scenes.courtyard_light import seen_place, unit_normal
from ..scenes.draws import tested
from ..scenes.figures import figure, results
from ..scenes.laws import entry
from ..scenes.panels import cell, picture
from ..scenes.shadow_stage import PICTURED, SHADOW, reads
from ..scenes.shadow_truth import blocked, dark_share

SUN = (2.6, 3.0, 1.4)
NEAR, FAR, CASCADES = 0.5, 60.0, 3
BLENDS = {"uniform": 0.0, "practical": 0.5, "logarithmic": 1.0}
SPLITS = {name: split_distances(NEAR, FAR, CASCADES, blend) for name, blend in BLENDS.items()}
# One map for everything, in the place of all three.
SPLITS["one map"] = [FAR, FAR, FAR]
TOLD = {
    "uniform": (20.333333, 40.166667),
    "logarithmic": (2.466212, 12.164404),
    "practical": (11.399773, 26.165535),
}
MAP, CLAMPED = 256, ("clamp_to_edge",) * 2
REACHES = {"nearer than 12": 12.0, "all": FAR}
EYE, AIM = (3.0, 4.4, 5.2), (-0.9, 0.0, -11.0)
# The scheme whose pass keeps all outputs: the others show the same surfaces.
WHOLE, KEPT = "practical", {**SHADOW, "cascade": "r32f"}
LIGHT_VIEW = look_at(SUN, (0.0, 0.0, 0.0))
# Along the light, everything that can be seen or throw a shadow there.
DEPTHS = (-40.0, 80.0)
BOXES = avenue_boxes()
# Where the mesh lies in the world: it is kept turned and moved, so that no matrix is the identity.
MODEL = translate((0.5, 0.25, -1.0)) @ turned(30.0, (1.0, 2.0, 0.5))
AVENUE = before(avenue(), MODEL)


def seen(aspect):
    """The camera, as far as the cascades reach."""
    return camera(EYE, AIM, 38.0, aspect, near=NEAR, far=FAR)


VIEW = seen(1.0)["view"]


def light_spaces(scheme, aspect):
    """Each cascade's light-space matrix, fitted around where it begins and ends."""
    ends = [NEAR, *SPLITS[scheme]]
    slices = [(NEAR, FAR)] * CASCADES if scheme == "one map" else [*pairwise(ends)]
    projection = seen(aspect)["projection"]
    return np.array(
        [fitted(LIGHT_VIEW, slice_corners(VIEW, projection, *ends), DEPTHS) for ends in slices]
    )


def texel_depths(matrices):
    """How deep the largest texel of each map is, in its depths, at a slope of 1."""
    texels = [2.0 / np.abs(m[:2, :3]).max(axis=1).min() / MAP for m in matrices]
    return [texel / (DEPTHS[1] - DEPTHS[0]) for texel in texels]


def maps(scheme, aspect):
    """A pass for each cascade's map."""
    return tuple(
        shadow_stage.cast(f"{scheme}-{k}-{aspect:g}", matrix, MODEL, MAP, solid=AVENUE)
        for k, matrix in enumerate(light_spaces(scheme, aspect))
    )


def drawn(scheme, aspect=1.0, tint=0.0, cell=None):
    """The avenue with one scheme's cascades."""
    matrices = light_spaces(scheme, aspect)
    layers = [Output(f"{scheme}-{k}-{aspect:g}.depth") for k in range(CASCADES)]
    return tested(
        (lit.PAINTED, "ch05_lighting/cascaded_shadows.frag"),
        AVENUE,
        {
            "model": MODEL,
            # Half as long as they were: the fragment shader is to make them whole again.
            "normalMatrix": 0.5 * MODEL[:3, :3],
            **seen(aspect),
            "lightSpaceMatrices": matrices,
            "splits": SPLITS[scheme],
            "biases": texel_depths(matrices),
            "lightPos": SUN,
            "tint": tint,
        },
        textures={"shadowMaps": TextureArray(layers=layers, format="depth32f", wrap=CLAMPED)},
        cell=cell,
    )


def index(FragPos, view, splits):
    """A fragment's cascade, by how far in front of the camera it is."""
    return cascade_index(-swizzle(mul(view, vec4(FragPos, 1.0)), "z"), splits)


def own_bias(FragPos, Normal, view, splits, biases, lightPos):
    """The bias of the fragment's cascade, at the slope of its surface."""
    least = entry(index(FragPos, view, splits), biases)
    return slope_bias(Normal, lightPos, least, 6.0 * least)


def dark(FragPos, Normal, view, splits, biases, lightSpaceMatrices, shadowMaps, lightPos):
    """What the cascade's own map says."""
    number = index(FragPos, view, splits)
    found = None
    for k in range(CASCADES):
        place = shadow_coordinates(mul(lightSpaceMatrices[k], vec4(FragPos, 1.0)))
        stored = swizzle(texture(shadowMaps, vec3(swizzle(place, "xy"), float(k))), "x")
        bias = slope_bias(Normal, lightPos, biases[k], 6.0 * biases[k])
        told = shadow(swizzle(place, "z"), stored, bias)
        # Halves, as a sum of two ones is only nearly 2 where compilers may rearrange it.
        found = told if found is None else where(number > k - 0.5, told, found)
    return found


def color(
    FragPos, Normal, Color, view, splits, biases, lightSpaceMatrices, shadowMaps, lightPos, tint
):
    """Ambient light and the sun, on the colour of the thing or of its cascade."""
    number = index(FragPos, view, splits)
    told = dark(FragPos, Normal, view, splits, biases, lightSpaceMatrices, shadowMaps, lightPos)
    lambert = max(dot(normalize(Normal), normalize(lightPos)), 0.0)
    far = where(number > 1.5, vec3(0.2, 0.35, 0.9), vec3(0.25, 0.75, 0.3))
    own = where(number > 0.5, far, vec3(0.9, 0.25, 0.2))
    return vec4((0.15 + (1.0 - told) * lambert) * mix(Color, own, tint), 1.0)


def depth_of(place, view=VIEW):
    """How far in front of the camera places are."""
    return -(place @ view[:3, :3].T + view[:3, 3])[..., 2]


def wrong(shadow, place, upright, within):
    """The share of places that face the sun of which the maps tell something else than rays."""
    there = shadow_stage.faces(upright, SUN) & (depth_of(place) < within)
    return np.mean((shadow[..., 0] > 0.5)[there] != blocked(place[there], SUN, BOXES))


def wrong_of(shadow, other, place, upright, within):
    """How often one scheme is wrong where another is wrong once."""
    return wrong(shadow, place, upright, within) / wrong(other, place, upright, within)


def told_otherwise(shadow, place, upright, scheme):
    """The share of places that face the sun of which the maps of a scheme tell something else than
    maps that are made by rays, of the same texels with the same biases."""
    slope = 1.0 - upright @ (np.array(SUN) / np.linalg.norm(SUN))
    there = slope < 1.0
    bias = np.maximum(6.0 * slope[there], 1.0)
    dark = dark_by_rays([*SPLITS][int(scheme)], 1.0, place[there], bias)
    return np.mean((shadow[..., 0] > 0.5)[there] != dark)


def dark_by_rays(name, aspect, place, bias):
    """Whether maps made by rays tell places, (n, 3), to be dark; the bias as a multiple of each
    map's least one."""
    number = (depth_of(place)[:, None] >= SPLITS[name][:-1]).sum(axis=-1)
    matrices, dark = light_spaces(name, aspect), np.zeros(number.shape, bool)
    for k, (matrix, least) in enumerate(zip(matrices, texel_depths(matrices), strict=True)):
        here = number == k
        dark[here] = dark_share(place[here], matrix, MAP, BOXES, least * bias[here]) > 0.5
    return dark


def told_otherwise_in_picture(FragColor, shadow, place):
    """The same of every eighth pixel both ways, whichever way it faces: the bias is once the least
    one where the sun falls straight down, and at most twelve times that, on faces turned away."""
    drawn = FragColor[::8, ::8, 3] > 0.0
    told = shadow[::8, ::8, 0][drawn] > 0.5
    place = place[::8, ::8, :3][drawn].astype(float)
    either, both = (dark_by_rays("practical", 2.0, place, np.full(len(place), b)) for b in (1, 12))
    return np.mean((told & ~either) | (~told & both))


def wrong_cascade(cascade, upright, place, view, splits):
    """The share of pixels whose cascade is not the one that their place has in float64."""
    right = (depth_of(place, view)[..., None] >= splits[:-1]).sum(axis=-1)
    drawn = upright.any(axis=-1)
    return np.mean(cascade[..., 0][drawn] != right[drawn])


def surfaces(scheme, others=()):
    """What a scheme's pass says of the surfaces that all of them show."""
    return reads(WHOLE, "place", "upright", shadow=f"{scheme}.shadow", **dict(others))


def within_reaches(schemes, others=(), **bound):
    """Readings of each scheme, of what is near and of everything."""
    return [
        reading(f"{scheme}, {far}", reads=surfaces(scheme, others), given={"within": to}, **bound)
        for far, to in REACHES.items()
        for scheme in schemes
    ]


def judged(scheme):
    """The avenue with one scheme, small."""
    colors = None if scheme == WHOLE else KEPT if scheme in BLENDS else SHADOW
    return picture([drawn(scheme, tint=0.3)], (96, 96), scheme, depth="depth24", colors=colors)


# A white surface at right angles to the sun.
FACING = {"FragPos": (0.0, 0.0, 0.0), "Normal": SUN, "Color": (1.0, 1.0, 1.0)}
PAST_LAST = {**FACING, "FragPos": (-10.0, 0.0, -80.0)}
PAST_FAR = {**FACING, "FragPos": tuple(-18.15 * s for s in SUN)}  # a depth of 1.005
LEAST = np.round(texel_depths(light_spaces("practical", 1.0)), 6)

case = Case(
    title="Cascaded shadow maps",
    section="5.9.3",
    math=r"d_i = \lambda\, n \left(\frac{f}{n}\right)^{i/N} + (1 - \lambda)\left(n + "
    r"\frac{i}{N}(f - n)\right)",
    passes=(
        *(one for made in maps("practical", 2.0) for one in both_ways(made)),
        *shadow_stage.photographed(
            (
                drawn("practical", 2.0, 0.7, cell(1, 1, 2)),
                drawn("practical", 2.0, 0.0, cell(0, 1, 2)),
            ),
            colors={**PICTURED, "shadow": "r16f"},
            clear=(0.30, 0.40, 0.52, 0.0),
        ),
        *(one for scheme in SPLITS for made in maps(scheme, 1.0) for one in both_ways(made)),
        *(judged(scheme) for scheme in SPLITS),
    ),
    picture="picture.FragColor",
    rows=("cascades", "shadows"),
    expect=[
        *shadow_stage.map_checks("practical-0-1"),
        *(any_order(f"practical-{k}-2.depth") for k in range(CASCADES)),
        *(any_order(f"{scheme}-{k}-1.depth") for scheme in SPLITS for k in range(CASCADES)),
        *lit.vertex_stage_checks(
            "gl_Position", "FragPos", "Normal", "Color", pass_name="practical"
        ),
        formula("practical.place", seen_place),
        formula("practical.upright", unit_normal),
        *(formula(f"{scheme}.cascade", index) for scheme in BLENDS),
        *(formula(f"{scheme}.shadow", dark) for scheme in SPLITS),
        formula("practical.FragColor", color),
        formula("practical.bias", own_bias),
        figure(
            "practical.bias", "the least bias, where the sun falls straight down", FACING, LEAST[0]
        ),
        figure("practical.bias", "… in the last cascade", PAST_LAST, LEAST[2]),
        figure("practical.cascade", "past the last split the last cascade goes on", PAST_LAST, 2.0),
        figure("practical.shadow", "just past the far plane nothing is dark", PAST_FAR, 0.0),
        measure(
            "told otherwise than by maps of rays, in the large picture",
            told_otherwise_in_picture,
            reads=reads("scene", "FragColor", "shadow", "place"),
            at_most=0.001,  # as below
            own_types=True,
        ),
        *(
            measure(
                f"{scheme}: pixels in a wrong cascade",
                wrong_cascade,
                reads=reads(WHOLE, "upright", "place", cascade=f"{scheme}.cascade"),
                pass_name=scheme,
                equals=0.0,
                digits=9,
            )
            for scheme in BLENDS
        ),
        *shadow_stage.surface_checks(EYE, BOXES, WHOLE, [s for s in SPLITS if s != WHOLE]),
        *shadow_stage.picture_checks(EYE, BOXES, drawn=0.7),
        measure(
            "told otherwise than by maps of rays",
            told_otherwise,
            readings=[
                reading(scheme, reads=surfaces(scheme), given={"scheme": k})
                for k, scheme in enumerate(SPLITS)
            ],
            at_most=0.001,  # as in shadow-acne: places next to an edge, or to equality
        ),
        measure(
            "shadows told wrongly",
            wrong,
            readings=within_reaches(SPLITS, at_most=0.02),  # what they are follows from the above
        ),
        measure(
            "… for each by a single map",
            wrong_of,
            readings=within_reaches(BLENDS, {"other": "one map.shadow"}),
            at_most=1.0,
        ),
        # The first two of each.
        *results({f"{scheme} splits": (SPLITS[scheme][:2], told) for scheme, told in TOLD.items()}),
    ],
)
