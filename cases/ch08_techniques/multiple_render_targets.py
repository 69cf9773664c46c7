"""Multiple render targets: one fragment shader writes several pictures at once.

A framebuffer may have several colour attachments, and glDrawBuffers says which of them each output
location goes to. So one pass over the scene yields what would take four: its light, what of it is
bright enough to glow, its normals, and its luminance. Each attachment has a format of its own. An
output that no draw buffer takes is lost, and the others do not change. The driver says how many
there may be, at least 8: GL_MAX_COLOR_ATTACHMENTS, GL_MAX_DRAW_BUFFERS.

Look at: the four pictures of one draw: above the light and the bright parts alone, below normals as
colours (x in red, y in green, z in blue) and luminance.

Try: in `ch08_techniques/multiple_render_targets.frag` write `Luminance > 0.1` for `Luminance >
0.4`: much more of the scene would glow, and the other three pictures do not change.
"""

from shaderlab import Case, Output, Texture, assets, exact, formula
from shaderlab.glslmath import dot, fract, max, normalize, sqrt, swizzle, vec3, vec4, where
from shaderlab.glslmath.sampling import texture
from shaderlab.reference import post_processing
from shaderlab.reference.transforms import clip_position, normal_matrix, world_normal

from ..scenes.api import limits
from ..scenes.cameras import turned
from ..scenes.draws import tested
from ..scenes.figures import figure
from ..scenes.panel_checks import parts_check
from ..scenes.panels import WHOLE, panel_pass, picture, rectangle
from ..scenes.still_life import CAMERA, still_life
from ..scenes.studio import handed_on

MODEL = turned(12.0)
SHADER = "ch08_techniques/multiple_render_targets_tiles.frag"
OUTPUTS = {
    "FragColor": "rgba32f", "BrightColor": "rgba16f", "NormalColor": "rgba8", "Luminance": "r32f",
}  # fmt: skip


def into(name, **outputs):
    """The still life, into these attachments; nearest surfaces by depth."""
    uniforms = {"model": MODEL, "normalMatrix": 0.5 * normal_matrix(MODEL), **CAMERA}
    shaders = ("ch03_transforms/studio.vert", "ch08_techniques/multiple_render_targets.frag")
    draw = tested(shaders, still_life(), uniforms)
    return picture([draw], None, name, depth="depth24", colors=outputs)


def light(Normal, Color):
    """A lamp over the shoulder and a quarter of light from everywhere."""
    lamp = max(dot(normalize(Normal), vec3(-0.36, 0.80, 0.48)), 0.0)
    return Color * (0.25 + 0.75 * lamp)


def frag_color(Normal, Color):
    """The light, encoded by a square root."""
    return vec4(sqrt(light(Normal, Color)), 1.0)


def luminance(Normal, Color):
    """Rec. 709's."""
    return post_processing.luminance(light(Normal, Color))


def bright_color(Normal, Color):
    """The light where its luminance is past 0.4, else black."""
    past = luminance(Normal, Color) > 0.4
    return vec4(where(past, light(Normal, Color), vec3(0.0)), 1.0)


def normal_color(Normal):
    """From −1…1 to 0…1."""
    return vec4(0.5 * normalize(Normal) + 0.5, 1.0)


def tiles(TexCoords, lit, bright, normals, luminance):
    """The four pictures, each in its quarter."""
    tile = 2.0 * TexCoords
    st = fract(tile)
    left = swizzle(tile, "x") < 1.0
    below = where(left, texture(normals, st), swizzle(texture(luminance, st), "xxxx"))
    above = where(left, texture(lit, st), texture(bright, st))
    both = where(swizzle(tile, "y") < 1.0, below, above)
    return vec4(swizzle(both, "xyz"), 1.0)


TILES = {"lit": (0.25, 0.25), "bright": (1, 0.5), "normals": (0.5, 1), "luminance": (0.75, 0)}
# Around the middle of the window, a pixel every 1/4096: the tiles' edges, with four plain textures.
MIDDLE = 0.5 - 32.5 / 4096.0
NEAR_IT = {"TexCoords": rectangle((MIDDLE, MIDDLE), (1.0 / 64.0, 1.0 / 64.0))}
PLAIN = {name: Texture(image=assets.solid((*rg, 0.5, 1.0))) for name, rg in TILES.items()}
PICTURES = {name: Output(f"all.{output}") for name, output in zip(TILES, OUTPUTS, strict=True)}
QUARTERS = {
    "all.FragColor": (0.0, 0.5, 0.5, 1.0),
    "all.BrightColor": (0.5, 0.5, 1.0, 1.0),
    "all.NormalColor": (0.0, 0.0, 0.5, 0.5),
    "all.Luminance": (0.5, 0.0, 1.0, 0.5),
}
CORAL = {"Normal": (0.0, 2.0, 0.0), "Color": (1.0, 0.5, 0.31)}

case = Case(
    title="Multiple render targets",
    section="8.2",
    math=r"\text{out}_k \to \text{drawBuffers}[k], \qquad "
    r"\mathbf{b} = \begin{cases} \mathbf{c} & Y(\mathbf{c}) > 0.4 \\ 0 & \text{else} \end{cases}",
    passes=(
        into("all", **OUTPUTS),
        *(into(f"only {name}", **{name: word}) for name, word in OUTPUTS.items()),
        panel_pass("edges", SHADER, NEAR_IT, size=(64, 64), textures=PLAIN),
        panel_pass("picture", SHADER, WHOLE, textures=PICTURES),
    ),
    picture="picture.FragColor",
    expect=[
        formula("all.gl_Position", clip_position),
        formula("all.Normal", world_normal),
        formula("all.Color", handed_on),
        formula("all.FragColor", frag_color),
        formula("all.BrightColor", bright_color),
        formula("all.NormalColor", normal_color),
        formula("all.Luminance", luminance),
        *(
            exact(f"all.{name}", Output(f"only {name}.{name}"), name=f"{name} alone is the same")
            for name in OUTPUTS
        ),
        formula("picture.FragColor", tiles, name="four tiles"),
        parts_check(QUARTERS, at_most=0.06),
        formula("edges.FragColor", tiles, name="edges of the tiles"),
        figure(
            "all.BrightColor",
            "just bright enough to glow",
            {"Normal": (0.0, 2.0, 0.0), "Color": (0.402 / 0.85,) * 3},
            (0.402, 0.402, 0.402, 1.0),
        ),
        figure("all.Luminance", "luminance of coral, lit", CORAL, 0.503695),
        *limits(
            {
                "colour attachments of a framebuffer": ("GL_MAX_COLOR_ATTACHMENTS", 8),
                "of them, drawn into at once": ("GL_MAX_DRAW_BUFFERS", 8),
            }
        ),
    ],
)
