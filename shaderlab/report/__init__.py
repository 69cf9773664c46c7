"""Records as something to read: the HTML page, and the formats of `shaderlab.report.formats`.

This package sees records, errors and pictures only: never a case, a shader or a device. Jinja is
loaded with `html`; Pygments and latex2mathml are loaded when a function needs them.
"""
