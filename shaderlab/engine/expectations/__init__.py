"""What must hold of a scene: one kind of expectation a file.

Here is what a new kind is written with. Whatever derives from `Expectation` can be in a case's
`expect`, wherever it lives; those of the lab are public by their lines in shaderlab/__init__.pyi.
"""

from shaderlab.model.case import Scene as Scene
from shaderlab.model.expectation import (
    Expectation as Expectation,
    Judgement as Judgement,
    Need as Need,
    Programs as Programs,
    Read as Read,
)
from shaderlab.model.frame import Frame as Frame
from shaderlab.model.records import Outcome as Outcome, Row as Row

from .base import DrawExpectation as DrawExpectation, OutputExpectation as OutputExpectation
from .needs import (
    CapturedFragments as CapturedFragments,
    CapturedVertices as CapturedVertices,
    Probe as Probe,
    find_image as find_image,
    subject_of as subject_of,
)
