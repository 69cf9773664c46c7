"""Records as something to read: the HTML page, JUnit XML, JSON, and Markdown.

This room sees records, errors and pictures only: never a case, a shader or a device. Jinja,
Pygments, latex2mathml and cattrs are loaded when a function needs them.
"""

from shaderlab.report.html import write
from shaderlab.report.junit import write_junit
from shaderlab.report.markdown import summary
from shaderlab.report.store import load, public_json, save

__all__ = ["load", "public_json", "save", "summary", "write", "write_junit"]
