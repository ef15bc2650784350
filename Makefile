# `make demo` and `make test` do all of the set-up themselves; PYTHON=/path/to/python picks another interpreter.
BIN := .venv/bin
READY := .venv/.installed
# It holds the folder it was made for: a checkout that was moved or copied sets itself up anew.
ifneq ($(shell cat $(READY) 2>/dev/null),$(CURDIR))
.PHONY: $(READY)
endif

.PHONY: help setup demo test studies lint types format bench notebooks docs wheel clean
.DEFAULT_GOAL := help

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

$(READY): pyproject.toml constraints.txt scripts/setup.sh scripts/missing_system_packages.py
	@PYTHON='$(PYTHON)' sh scripts/setup.sh

setup: $(READY)  ## the virtual environment .venv, and nothing more

demo: $(READY)  ## set-up 1 of the thesis end to end, in simulation; look at out/demo
	@$(BIN)/mmt-drake demo --out out/demo

IN_PARALLEL := -n logical --dist loadfile --no-loadscope-reorder --max-worker-restart 0

test: $(READY)  ## the tests, a process on each core; then those by the wall clock, alone
	@$(BIN)/python -m pytest $(IN_PARALLEL) -m 'not realtime and not study'
	@$(BIN)/python -m pytest -m realtime

studies: $(READY)  ## the tests that run experiments, trials, benches, notebooks and whole diagnoses
	@$(BIN)/python -m pytest $(IN_PARALLEL) -m study

lint: $(READY)  ## ruff, and whether the code is formatted
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check

types: $(READY)  ## strict types
	@$(BIN)/mypy

format: $(READY)  ## format the code and mend what ruff can mend
	@$(BIN)/ruff check --fix
	@$(BIN)/ruff format

bench: $(READY)  ## the performance figures of the README, measured here and now
	@$(BIN)/mmt-drake bench

notebooks: $(READY)  ## execute notebooks/*.py into their paired .ipynb
	@$(BIN)/python scripts/execute_notebooks.py notebooks/*.py

docs: $(READY)  ## the documentation site, links checked; open out/site/index.html
	@$(BIN)/python -m pip install --quiet --no-build-isolation --constraint constraints.txt --editable '.[docs]'
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

wheel: $(READY)  ## dist/*.whl, which runs every command
	@$(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir dist .
	@rm -rf build *.egg-info  # left behind, they would end up in the next wheel and hide the installed metadata

clean:  ## remove everything that make makes
	@rm -rf .venv out dist build *.egg-info .pytest_cache .mypy_cache .ruff_cache
	@find . -name __pycache__ -prune -exec rm -rf {} +
