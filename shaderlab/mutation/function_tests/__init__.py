"""Files of tests of GLSL functions, run by pytest inside warm workers: for `watch` and `mutate`."""
