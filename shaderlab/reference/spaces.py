"""Coordinate spaces after the world: view, clip, normalised device and window coordinates.

Sources: "The OpenGL Graphics System: A Specification", version 4.5 core (M. Segal, K. Akeley,
2017), section 13.6 "Coordinate Transformations" (viewport and depth range); version 1.0 (1992),
section 2.9.2 (glOrtho, glFrustum); "OpenGL Utility Library" manual, version 1.3 (1998), gluLookAt
and gluPerspective.
"""

from __future__ import annotations

from shaderlab.glslmath import (
    Value,
    cos,
    cross,
    dot,
    mul,
    normalize,
    sin,
    swizzle,
    tan,
    vec2,
    vec3,
    vec4,
)


def in_camera(world: Value, eye: Value, target: Value, up: Value) -> Value:
    """World coordinates (…, 3) in view space: x to the camera's right, y up, z towards it.

    >>> in_camera(np.zeros(3), np.array([0, 0, 3.0]), np.zeros(3), np.array([0, 1.0, 0])).tolist()
    [0.0, 0.0, -3.0]
    """
    forward = normalize(target - eye)
    side = normalize(cross(forward, up))
    above = cross(side, forward)

    def along(axis: Value) -> Value:
        return dot(axis, world) - dot(axis, eye)

    return vec3(along(side), along(above), along(forward) * -1.0)


def orbit_eye(angle: Value, radius: Value, height: Value) -> Value:
    """A camera's place on a horizontal circle around y, `angle` radians from +z towards +x: (…, 3).

    >>> import math
    >>> orbit_eye(math.pi / 2, 5.0, 1.0).round(9).tolist()
    [5.0, 1.0, 0.0]
    """
    return vec3(sin(angle) * radius, height, cos(angle) * radius)


def orthographic_clip(
    seen: Value, left: Value, right: Value, bottom: Value, top: Value, near: Value, far: Value
) -> Value:
    """The box left…right, bottom…top, −near…−far of view space onto −1…1, w = 1: (…, 4).

    >>> orthographic_clip(np.array([3.0, -2, -7.5]), -3, 3, -2, 2, 1, 7.5).round(9).tolist()
    [1.0, -1.0, 1.0, 1.0]
    """
    x, y, z = (swizzle(seen, name) for name in "xyz")
    return vec4(
        2.0 / (right - left) * x - (right + left) / (right - left),
        2.0 / (top - bottom) * y - (top + bottom) / (top - bottom),
        -2.0 / (far - near) * z - (far + near) / (far - near),
        1.0,
    )


def perspective_clip(seen: Value, fovy: Value, aspect: Value, near: Value, far: Value) -> Value:
    """View space to clip space, with a vertical field of view of `fovy` radians; w is −z.

    >>> import math
    >>> clip = perspective_clip(np.array([0.0, 0, -0.1]), math.radians(45), 1.0, 0.1, 100.0)
    >>> (clip[2] / clip[3]).round(9)
    np.float64(-1.0)
    """
    x, y, z = (swizzle(seen, name) for name in "xyz")
    focal = 1.0 / tan(fovy / 2.0)
    return vec4(
        focal / aspect * x,
        focal * y,
        (far + near) / (near - far) * z + 2.0 * far * near / (near - far),
        z * -1.0,
    )


def device(clip: Value) -> Value:
    """Normalised device coordinates: the division by w, (…, 4) to (…, 3).

    >>> device(np.array([1.0, -2.0, 3.0, 4.0])).tolist()
    [0.25, -0.5, 0.75]
    """
    return swizzle(clip, "xyz") / swizzle(clip, "w")


def window(ndc: Value, viewport: Value, depth_range: Value) -> Value:
    """Device to window coordinates: x, y in pixels from the lower left, and depth.

    Args:
        ndc: (…, 3).
        viewport: x, y, width, height.
        depth_range: depths of the near and the far plane, 0 and 1 by default.

    >>> window(np.array([0.5, -0.5, 0.2]), np.array([10, 20, 640, 480]), np.array([0, 1]))
    array([490. , 140. ,   0.6])
    """
    half = swizzle(viewport, "zw") * 0.5
    xy = half * swizzle(ndc, "xy") + (swizzle(viewport, "xy") + half)
    near, far = swizzle(depth_range, "x"), swizzle(depth_range, "y")
    z = (far - near) * 0.5 * swizzle(ndc, "z") + (near + far) * 0.5
    return vec3(xy, z)


def depth_of(view_z: Value, near: Value, far: Value) -> Value:
    """Device depth at z in view space (negative in front of the camera), and its derivative.

    z_ndc = (f + n)/(f − n) + 2fn/((f − n) z), so ∂z_ndc/∂z = −2fn/((f − n) z²): (…, 2).

    >>> depth_of(-1.0, 0.1, 100.0).round(6).tolist()
    [0.801802, -0.2002]
    """
    reach = 2.0 * far * near / (far - near)
    return vec2((far + near) / (far - near) + reach / view_z, reach * -1.0 / (view_z * view_z))


def sky_clip(aPos: Value, view: Value, projection: Value) -> Value:
    """A sky box's vertex in clip space, rotated but not moved with the camera, on the far plane
    (z = w): (…, 4).

    Args:
        aPos: (…, 3), a point of a box around the camera.
        view, projection: 4 × 4.

    >>> far = np.eye(4) + 9.0 * np.eye(4, k=3)
    >>> sky_clip(np.array([1.0, 2, 3]), far, np.eye(4)).tolist()
    [1.0, 2.0, 1.0, 1.0]
    """
    turned = mul(view[:3, :3], aPos)
    return swizzle(mul(projection, vec4(turned, 1.0)), "xyww")
