"""How different two colours look, as one number.

Source: G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula", Color Research and
Application 30(1), 2005; computed by colour-science. sRGB: IEC 61966-2-1:1999.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from shaderlab.errors import require_extra


def delta_e_2000(one: Any, other: Any) -> npt.NDArray[np.float64]:
    """CIE ΔE 2000 of display colours; about 1 is what an eye can just see side by side.

    Args:
        one, other: sRGB as a display gets it, 0…1, (…, 3).

    Returns:
        the differences, (…), 0 for equal colours. White against black is 100.

    >>> print(f"{delta_e_2000([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]):.3f}")
    100.000
    """
    # colour-science changes how NumPy prints, and says what it was installed without.
    with np.printoptions(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with require_extra("course", "ΔE 2000"):
            import colour

        labs = [
            colour.XYZ_to_Lab(
                colour.sRGB_to_XYZ(np.asarray(c, np.float64)),
                colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"],
            )
            for c in (one, other)
        ]
        found = colour.delta_E(labs[0], labs[1], method="CIE 2000")
    return np.asarray(found, np.float64)


def srgb_by_colour_science(linear: Any) -> Any:
    """The sRGB encoding by the colour-science library, of float64 arrays only.

    >>> print(f"{srgb_by_colour_science(0.5):.6f}")
    0.735357
    """
    # It announces which optional parts of it are not installed, and changes how NumPy prints.
    with warnings.catch_warnings(), np.printoptions():
        warnings.simplefilter("ignore")
        with require_extra("course", "the comparison with colour-science"):
            from colour.models import eotf_inverse_sRGB

    return eotf_inverse_sRGB(np.asarray(linear))


def oklab_by_colour_science(linear: Any) -> Any:
    """OKLab by the colour-science library, by way of CIE XYZ; of linear sRGB, (…, 3).

    >>> abs(oklab_by_colour_science([1.0, 1.0, 1.0])).round(3).tolist()
    [1.0, 0.0, 0.0]
    """
    with warnings.catch_warnings(), np.printoptions():
        warnings.simplefilter("ignore")
        with require_extra("course", "the comparison with colour-science"):
            from colour.models import RGB_COLOURSPACE_sRGB, XYZ_to_Oklab

    to_xyz = np.asarray(RGB_COLOURSPACE_sRGB.matrix_RGB_to_XYZ)
    return XYZ_to_Oklab(np.asarray(linear, float) @ to_xyz.T)
