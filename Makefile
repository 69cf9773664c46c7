# `make run` and `make test` are all one needs; both set up whatever is missing first.
.DEFAULT_GOAL := help
.PHONY: help run test test-hard test-all setup lint format wheel docs clean

PY := .venv/bin/python

# In other locales Python 3.11 can't read the path of this folder where it has letters beyond ASCII.
ifneq ($(shell locale charmap 2>/dev/null),UTF-8)
export LC_ALL = C.UTF-8
endif

# An environment that was moved or copied here, or that lost its Python, is made anew.
STALE := $(shell test -x $(PY) && test "$$(cat .venv/.ready 2>/dev/null)" = "$(CURDIR)" \
	|| rm -f .venv/.ready .venv/.ready-for-work)

# Several processes where there are several cores; a file's tests stay in one of them. Files are
# begun in their order, short ones last, so that all processes end together.
PARALLEL = -n auto --maxprocesses 8 --dist loadscope --no-loadscope-reorder

help: ## what there is to do
	@sed -n 's/^\([a-z-]*\):.*## /  make \1	/p' Makefile | expand -t 18
	@echo "  make run CASE=spotlight            one case; several in quotes; more options in ARGS"
	@echo "  make test ARGS='-k stencil -x'     some of the tests"

# Python keeps what it has compiled in .venv and here, whatever it does elsewhere.
run: export PYTHONDONTWRITEBYTECODE =
run: .venv/.ready ## run every case and write the report
	@$(PY) -m shaderlab run $(if $(CASE),$(CASE),--all) $(ARGS)

# Shaders that were compiled at another time are not taken for tested.
test: .venv/.ready-for-tests ## run every test
	@SHADERLAB_CACHE_DIR= $(PY) -m pytest $(PARALLEL) $(ARGS)

test-hard: .venv/.ready-for-tests ## run every test 10 times, in random order, on busy cores
	@trap 'kill $$busy' EXIT; busy=; \
	for core in $$(seq $$(nproc)); do while :; do :; done & busy="$$busy $$!"; done; \
	SHADERLAB_CACHE_DIR= $(PY) -m pytest $(PARALLEL) --count 10 --random-order $(ARGS)

test-all: ## collect and run a part of the tests on each Python 3.11 to 3.14 that is here
	@.ci/pythons $(ARGS)

lint: .venv/.ready-for-work ## style and types
	@failed=0; for tool in "ruff check ." "ruff format --check ." mypy; do \
		$(PY) -m $$tool || failed=1; done; exit $$failed

format: .venv/.ready-for-work ## make the style right
	@$(PY) -m ruff check --fix .
	@$(PY) -m ruff format .

wheel: .venv/.ready-for-work ## build the wheel and the sdist, and try the wheel in a new environment
	@.ci/wheel

docs: .venv/.ready-for-work ## build the pages as a site in build/site, and check its links
	@.ci/docs

setup: .venv/.ready-for-work ## only what run and test set up: .venv, packages, an OpenGL driver
	@echo "setup: ready in .venv"

SETS_UP := pyproject.toml constraints.txt .ci/setup .ci/system .ci/opengl.py

# What running cases takes: half of the packages, which install in half the time.
.venv/.ready: $(SETS_UP)
	@.ci/setup course,pytest,vulkan

# All packages; .ci/setup makes .venv/.ready as well.
.venv/.ready-for-work: $(SETS_UP)
	@.ci/setup dev
	@touch $@

.venv/.ready-for-tests: .venv/.ready-for-work .ci/system
	@.ci/system tests
	@touch $@

clean: ## remove everything that was made here, .venv and reports too
	rm -rf .venv .cache build dist .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find reports -mindepth 1 ! -path reports/README.md -delete
	find . -name __pycache__ -prune -exec rm -rf {} +
