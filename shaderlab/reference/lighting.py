"""Lambert's cosine, the two classic specular lobes, and Phong's lighting model made of them.

Sources: J. H. Lambert, "Photometria", 1760 (the cosine law); B. T. Phong, "Illumination for
Computer Generated Pictures", Communications of the ACM 18(6), 1975 (ambient, diffuse and specular
part, and the lobe around the reflected ray); J. F. Blinn, "Models of Light Reflection for Computer
Synthesized Pictures", SIGGRAPH 1977 (the halfway vector); "The OpenGL Graphics System: A
Specification", version 1.0 (M. Segal, K. Akeley, 1992), section 2.13.1 (materials and lights with a
colour for each part, equation 2.1, whose f = 0 where N·L ≤ 0 keeps highlights off faces that are
turned away from the lamp).

Places are (…, 3), factors (…, 1), colours (…, 3) in linear light. Directions are (…, 3), point
away from the surface and need not be of unit length, but not of length 0.
"""

from __future__ import annotations

import math

from shaderlab.glslmath import Value, dot, max, normalize, pow, reflect, vec4, where


def lobe(cosine: Value, shininess: Value) -> Value:
    """cosineˢ, and 0 where the cosine is not positive (there GLSL's pow is undefined).

    >>> print(f"{lobe(0.5, 2.0).item():.2f} {lobe(-0.5, 2.0).item():.2f}")
    0.25 0.00
    """
    return where(cosine > 0.0, pow(cosine, shininess), 0.0)


def mirrored_lobe(
    normal: Value, light_direction: Value, view_direction: Value, shininess: Value
) -> Value:
    """(R·V)ˢ with R the mirrored light, also on faces that are turned away from the lamp.

    Args:
        normal, light_direction, view_direction: (…, 3).
        shininess: s > 0, without unit.

    Returns 0…1, (…, 1): 0 where R and V are 90° or more apart.

    >>> up, below = np.array([0.0, 0.0, 1.0]), np.array([0.8, 0.0, -0.6])
    >>> print(f"{mirrored_lobe(up, below, np.array([-0.8, 0.0, 0.6]), 2.0).item():.6f}")
    0.078400
    """
    mirrored = reflect(-normalize(light_direction), normalize(normal))
    return lobe(dot(mirrored, normalize(view_direction)), shininess)


def halfway_lobe(
    normal: Value, light_direction: Value, view_direction: Value, shininess: Value
) -> Value:
    """(N·H)ˢ with H halfway between light and viewer, also on faces that are turned away.

    Args and returns: as `mirrored_lobe`, but 0 where N and H are 90° or more apart.

    >>> up, level = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    >>> print(f"{halfway_lobe(up, level, up, 2.0).item():.6f}")
    0.500000
    """
    halfway = normalize(normalize(light_direction) + normalize(view_direction))
    return lobe(dot(normalize(normal), halfway), shininess)


def gated(cosine: Value, share: Value) -> Value:
    """A share of the light where the surface faces the lamp, N·L > 0, and 0 elsewhere.

    >>> print(f"{gated(0.5, 0.25).item()} {gated(-0.5, 0.25).item()}")
    0.25 0.0
    """
    return where(cosine > 0.0, share, 0.0)


def phong(normal: Value, light_direction: Value, view_direction: Value, shininess: Value) -> Value:
    """Phong's highlight: `mirrored_lobe`, `gated`. Args and returns: as there.

    >>> up, aside = np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.0, 0.8])
    >>> print(f"{phong(up, aside, up, 2.0).item():.6f}")
    0.640000
    """
    cosine = dot(normalize(normal), normalize(light_direction))
    return gated(cosine, mirrored_lobe(normal, light_direction, view_direction, shininess))


def blinn(normal: Value, light_direction: Value, view_direction: Value, shininess: Value) -> Value:
    """Blinn's highlight: `halfway_lobe`, `gated`; never cut off while lamp and viewer are above.

    >>> up, aside = np.array([0.0, 0.0, 1.0]), np.array([0.6, 0.0, 0.8])
    >>> print(f"{blinn(up, aside, up, 2.0).item():.6f}")
    0.900000
    """
    cosine = dot(normalize(normal), normalize(light_direction))
    return gated(cosine, halfway_lobe(normal, light_direction, view_direction, shininess))


def diffuse(normal: Value, light_direction: Value) -> Value:
    """Lambert's law: max(N·L, 0). Source: J. H. Lambert, "Photometria", 1760.

    >>> print(f"{diffuse(np.array([0.0, 0.0, 1.0]), np.array([1.2, 1.0, 2.0])).item():.6f}")
    0.788110
    """
    return max(dot(normalize(normal), normalize(light_direction)), 0.0)


def reflected_color(lightColor: Value, objectColor: Value) -> Value:
    """What a surface reflects, channel by channel: light · colour.

    >>> reflected_color(np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.5, 0.31])).tolist()
    [0.0, 0.5, 0.0]
    """
    return lightColor * objectColor


def ambient_color(lightColor: Value, objectColor: Value, ambientStrength: Value) -> Value:
    """Ambient light: the same from every direction.

    >>> ambient_color(np.ones(3), np.array([1.0, 0.5, 0.31]), 0.1).round(6).tolist()
    [0.1, 0.05, 0.031]
    """
    return ambientStrength * lightColor * objectColor


def diffuse_factor(FragPos: Value, Normal: Value, lightPos: Value) -> Value:
    """Lambert's cosine at a fragment: max(N·L, 0), L from the fragment to the lamp.

    Args:
        FragPos, lightPos: in the same space, not in the same place.
        Normal: of any length but 0.

    >>> up, lamp = np.array([0.0, 0.0, 1.0]), np.array([1.2, 1.0, 2.0])
    >>> print(f"{diffuse_factor(np.zeros(3), up, lamp).item():.6f}")
    0.788110
    """
    return diffuse(Normal, lightPos - FragPos)


def specular_factor(
    FragPos: Value, Normal: Value, lightPos: Value, viewPos: Value, shininess: Value
) -> Value:
    """Phong's highlight at a fragment.

    >>> up, lamp, eye = np.eye(3)[2], np.array([1.2, 1.0, 2.0]), np.array([0.0, 0.0, 3.0])
    >>> print(f"{specular_factor(np.zeros(3), up, lamp, eye, 32.0).item():.9f}")
    0.000490666
    """
    return phong(Normal, lightPos - FragPos, viewPos - FragPos, shininess)


def diffuse_color(
    FragPos: Value,
    Normal: Value,
    lightPos: Value,
    lightColor: Value,
    objectColor: Value,
    ambientStrength: Value,
) -> Value:
    """Ambient and diffuse part together, (…, 4).

    >>> up, lamp, coral = np.eye(3)[2], np.array([1.2, 1.0, 2.0]), np.array([1.0, 0.5, 0.31])
    >>> diffuse_color(np.zeros(3), up, lamp, np.ones(3), coral, 0.1).round(6).tolist()
    [0.88811, 0.444055, 0.275314, 1.0]
    """
    share = ambientStrength + diffuse_factor(FragPos, Normal, lightPos)
    return vec4(share * lightColor * objectColor, 1.0)


def phong_color(
    FragPos: Value,
    Normal: Value,
    lightPos: Value,
    viewPos: Value,
    lightColor: Value,
    objectColor: Value,
    ambientStrength: Value,
    diffuseStrength: Value,
    specularStrength: Value,
    shininess: Value,
) -> Value:
    """All three parts, each with its own strength, times the object's colour, (…, 4).

    >>> up, lamp, coral = np.eye(3)[2], np.array([1.2, 1.0, 2.0]), np.array([1.0, 0.5, 0.31])
    >>> eye, white = np.array([0.0, 0.0, 3.0]), np.ones(3)
    >>> color = phong_color(np.zeros(3), up, lamp, eye, white, coral, 0.1, 1.0, 0.5, 32.0)
    >>> color.round(6).tolist()
    [0.888356, 0.444178, 0.27539, 1.0]
    """
    share = (
        ambientStrength
        + diffuseStrength * diffuse_factor(FragPos, Normal, lightPos)
        + specularStrength * specular_factor(FragPos, Normal, lightPos, viewPos, shininess)
    )
    return vec4(share * lightColor * objectColor, 1.0)


def half_power_angle(shininess: float) -> float:
    """The angle from a lobe's axis, in degrees, at which it has fallen to one half.

    arccos(0.5^(1/s)): cosˢ is one half there.

    >>> print(f"{half_power_angle(2):.6f} {half_power_angle(32):.6f}")
    45.000000 11.882461
    """
    return math.degrees(math.acos(0.5 ** (1.0 / shininess)))


def lit_material(
    FragPos: Value,
    Normal: Value,
    viewPos: Value,
    material_ambient: Value,
    material_diffuse: Value,
    material_specular: Value,
    material_shininess: Value,
    light_position: Value,
    light_ambient: Value,
    light_diffuse: Value,
    light_specular: Value,
) -> Value:
    """A material under a lamp; both have one colour for each part: (…, 4).

    >>> coral, half, up = np.array([1.0, 0.5, 0.31]), np.full(3, 0.5), np.eye(3)[2]
    >>> lamp, eye, one = np.array([1.2, 1.0, 2.0]), np.array([0.0, 0.0, 3.0]), np.ones(3)
    >>> lit = lit_material(np.zeros(3), up, eye, coral, coral, half, 32.0, lamp, one, one, one)
    >>> lit.round(6).tolist()
    [1.788356, 0.894301, 0.55456, 1.0]
    """
    diff = diffuse_factor(FragPos, Normal, light_position)
    spec = specular_factor(FragPos, Normal, light_position, viewPos, material_shininess)
    ambient = light_ambient * material_ambient
    diffuse = light_diffuse * (diff * material_diffuse)
    specular = light_specular * (spec * material_specular)
    return vec4(ambient + diffuse + specular, 1.0)
