"""JUnit XML, for the test panels of CI systems: a suite per case, a test per expectation."""

from __future__ import annotations

import itertools
import math
from xml.etree import ElementTree as ET

from shaderlab.model.records import Record, Run
from shaderlab.report.grouping import group_cases
from shaderlab.report.text import clean, format_outcome, plural

# What a status is called in the schema: nothing (passed), failure, error, or skipped.
_TAGS = {
    "pass": None, "fail": "failure", "error": "error", "timeout": "error", "crash": "error",
    "unsupported": "skipped",
}  # fmt: skip


def render(run: Run) -> str:
    """A run as JUnit XML.

    Each case is a `testsuite`, each expectation of each variant a `testcase`. A record whose
    status none of its expectations accounts for (it crashed, timed out, did not compile, or has
    no expectations) gets its own test, "run"; so does a run that was interrupted, in error.
    No two tests have both class and name in common: readers would take one for the other.
    """
    root = ET.Element("testsuites", name="shaderlab", time=_seconds(run.seconds))
    for case in group_cases(run.records):
        suite = ET.SubElement(root, "testsuite", name=clean(case.id), timestamp=clean(run.started))
        for record in case.records:
            _add_record(suite, record)
        _set_counts(suite)
        suite.set("time", _seconds(sum(record.seconds for record in case.records)))
    if run.missing:
        suite = ET.SubElement(root, "testsuite", name="shaderlab", time=_seconds(0.0))
        test = ET.SubElement(suite, "testcase", classname="shaderlab", name="run", time="0")
        message = f"the run was interrupted: {plural(run.missing, 'variant')} not run"
        _verdict(test, "error", message, message)
        _set_counts(suite)
    _number_equal_names(root)
    _set_counts(root)
    del root.attrib["skipped"]  # Jenkins' schema has it for suites alone
    ET.indent(root)
    text = ET.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _add_record(suite: ET.Element, record: Record) -> None:
    tests = len(record.expectations)
    explained = any(_TAGS[o.status] == _TAGS[record.status] for o in record.expectations)
    alone = not explained
    seconds = record.seconds / (tests + alone)
    if alone:
        test = _test(suite, record, "run", seconds)
        _verdict(test, _TAGS[record.status], record.message or record.status, record.message)
    for outcome in record.expectations:
        test = _test(suite, record, outcome.name, seconds)
        message = outcome.message or outcome.status
        _verdict(test, _TAGS[outcome.status], message, "\n".join(format_outcome(outcome)))
    for name in record.not_asked:
        message = "skipped: it checks OpenGL's own calls, and this driver uses another API"
        _verdict(_test(suite, record, name, 0.0), "skipped", message, message)


def _test(suite: ET.Element, record: Record, name: str, seconds: float) -> ET.Element:
    owner, title = clean(record.id), clean(f"{record.variant}: {name}")
    place = {"file": clean(record.file), "time": _seconds(seconds)}
    return ET.SubElement(suite, "testcase", {"classname": owner, "name": title, **place})


def _verdict(test: ET.Element, tag: str | None, message: str, details: str) -> None:
    if tag is None:
        return
    lines = clean(message).strip().splitlines()
    verdict = ET.SubElement(test, tag, message=lines[0] if lines else "")
    verdict.text = clean(details)


def _number_equal_names(root: ET.Element) -> None:
    taken: set[tuple[str, str]] = set()
    for test in root.iter("testcase"):
        plain, owner = test.get("name", ""), test.get("classname", "")
        numbers = itertools.count(2)
        while (owner, test.get("name", "")) in taken:
            test.set("name", f"{plain} ({next(numbers)})")
        taken.add((owner, test.get("name", "")))


def _set_counts(element: ET.Element) -> None:
    tests = list(element.iter("testcase"))
    element.set("tests", str(len(tests)))
    for name, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        element.set(name, str(sum(test.find(tag) is not None for test in tests)))


def _seconds(value: float) -> str:
    return f"{value if math.isfinite(value) else 0.0:.6f}"
