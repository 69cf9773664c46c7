"""The case model and the records of its runs: frozen, plain data that touches no device."""
