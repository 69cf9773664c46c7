"""Holding measured values against a reference formula's band. NumPy only, no device."""
