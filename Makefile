# make setup | run | test | bench: each does all the set-up that it needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.ready
PAGE_STAMP := $(VENV)/.page
PAGE_SOURCES := $(shell find hawk/web/page -type f -not -path '*/node_modules/*' 2>/dev/null)
ARGS ?=
# Quick kinds first, so that a mistake shows early; those that fly in real programs have the machine to themselves.
PYTEST := $(BIN)/python -m pytest -q

.PHONY: setup run test bench lint unit integration e2e page page-check browser system clean

setup: $(STAMP) page

$(STAMP): pyproject.toml hatch_build.py
	packaging/ensure-python-venv $(PYTHON)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	touch $@

page: $(PAGE_STAMP)

$(PAGE_STAMP): $(STAMP) $(PAGE_SOURCES)
	$(BIN)/python packaging/build_page.py
	touch $@

run: setup
	$(BIN)/hawk-drone --config config.toml --sim $(ARGS)

browser:
	packaging/ensure-browser

test: setup lint page-check unit integration e2e

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

page-check: page
	$(BIN)/python packaging/build_page.py --check

unit: $(STAMP)
	$(PYTEST) --numprocesses auto --dist worksteal tests/unit $(ARGS)

integration: $(STAMP)
	$(PYTEST) tests/integration $(ARGS)

e2e: setup browser
	$(PYTEST) tests/e2e $(ARGS)

bench: setup browser
	$(BIN)/python -m benchmarks $(ARGS)

clean:
	rm -rf $(VENV) hawk/web/static dist build
