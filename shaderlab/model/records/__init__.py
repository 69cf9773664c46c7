"""The results of running cases, as plain data: all that reports are made from.

Everything here is built of strings, numbers, lists and mappings, and converts to JSON and back
without loss. The public JSON of `shaderlab run --json` is a view of it (docs/guide/json.md).
"""

from .records import (
    Agreement as Agreement,
    Attachment as Attachment,
    BufferPart as BufferPart,
    BufferRecord as BufferRecord,
    CallsRecord as CallsRecord,
    CodeCoverage as CodeCoverage,
    CoverageGap as CoverageGap,
    Curve as Curve,
    Declared as Declared,
    Diagnostic as Diagnostic,
    Disagreement as Disagreement,
    DrawnOutput as DrawnOutput,
    DriverResult as DriverResult,
    ErratumNote as ErratumNote,
    Explanation as Explanation,
    ModulesRecord as ModulesRecord,
    Outcome as Outcome,
    PassRecord as PassRecord,
    Plot as Plot,
    PlotPoint as PlotPoint,
    Points as Points,
    ProgramRecord as ProgramRecord,
    Record as Record,
    Row as Row,
    Run as Run,
    Severity as Severity,
    SourceText as SourceText,
    Status as Status,
    Step as Step,
    Verdict as Verdict,
    Worst as Worst,
    significant as significant,
)
