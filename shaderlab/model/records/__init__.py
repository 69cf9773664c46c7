"""The results of running cases, as plain data: all that reports are made from.

Everything here is built of strings, numbers, lists and mappings, and converts to JSON and back
without loss. The public JSON of `shaderlab run --json` is a view of it (docs/guide/json.md).
"""

from .outcomes import (
    Curve as Curve,
    Explanation as Explanation,
    Outcome as Outcome,
    Plot as Plot,
    PlotPoint as PlotPoint,
    Row as Row,
    Status as Status,
    Step as Step,
    Worst as Worst,
    significant as significant,
)
from .programs import (
    Declared as Declared,
    Diagnostic as Diagnostic,
    ProgramRecord as ProgramRecord,
    Severity as Severity,
    SourceText as SourceText,
    Verdict as Verdict,
)
from .runs import (
    Agreement as Agreement,
    CodeCoverage as CodeCoverage,
    CoverageGap as CoverageGap,
    Disagreement as Disagreement,
    DriverResult as DriverResult,
    Points as Points,
    Run as Run,
)
from .scenes import (
    Attachment as Attachment,
    BufferPart as BufferPart,
    BufferRecord as BufferRecord,
    CallsRecord as CallsRecord,
    DrawnOutput as DrawnOutput,
    ErratumNote as ErratumNote,
    ModulesRecord as ModulesRecord,
    PassRecord as PassRecord,
    Record as Record,
)
