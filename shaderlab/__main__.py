"""`python -m shaderlab` is `shaderlab`, wherever the environment's scripts may be."""

from shaderlab.cli import main

if __name__ == "__main__":
    main()
