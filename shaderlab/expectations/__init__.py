"""What must hold of a scene: one kind of expectation a file.

Here is what a new kind is written with. Whatever derives from `Expectation` can be in a case's
`expect`, wherever it lives; those of the lab are public by their lines in shaderlab/__init__.pyi.
"""

from shaderlab.expectations.base import (
    OfDraw as OfDraw,
    OfOutput as OfOutput,
    judge_rows as judge_rows,
)
from shaderlab.expectations.needs import (
    CapturedFragments as CapturedFragments,
    CapturedVertices as CapturedVertices,
    Probe as Probe,
)
from shaderlab.expectations.subject import find_image as find_image, subject_of as subject_of
from shaderlab.frame import Frame as Frame
from shaderlab.model import (
    Expectation as Expectation,
    Judgement as Judgement,
    Need as Need,
    Programs as Programs,
    Read as Read,
    Scene as Scene,
)
from shaderlab.records import Outcome as Outcome, Row as Row
