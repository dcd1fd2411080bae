# make setup | run | check | test | docs | deb | container | bench | faults | ardupilot: each does its whole set-up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.ready
PAGE_STAMP := $(VENV)/.page
DOCS_SITE := hawk/web/docs_site/index.html
AXE := hawk/web/page/node_modules/axe-core
PAGE_SOURCES := $(shell find hawk/web/page -type f -not -path '*/node_modules/*' 2>/dev/null)
ARGS ?=
# Quick kinds first, so that a mistake shows early; those that fly and see in real programs have the machine to themselves.
PYTEST := $(BIN)/python -m pytest -q
# A module's tests share what they warm up, so they stay in one process; flights begin first (tests/conftest.py). Some
# wait: three processes keep two cores at work.
REAL := $(PYTEST) --dist loadscope --no-loadscope-reorder
UNIT := $(REAL) --numprocesses 3 tests/unit
FAST := -m 'not flight and not slow and not nightly'
COVERED := -m 'not flight and not nightly'
SHARING := 'not alone and not whole and not nightly'
ALONE := 'alone and not nightly'
WHOLE := 'whole and not nightly'
# COVERAGE=1: `make test` runs the fast unit tests by `make coverage`, which prints the share of lines and branches that
# they reach and the ten modules that they reach least, and fails when they miss a branch of a module that decides about
# safety (proving/mutants/modules.py). Tracing doubles their time on Python 3.11, so only CI does it.
UNIT_KINDS := $(if $(COVERAGE),coverage flights,unit)
# Without compiled files every process would compile and rewrite its modules and tests again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup run check test deb container bench bench-archive bench-lots bench-pictures bench-small study newcomer faults ardupilot api-fuzz chaos webhook-kills lint fast unit nightly coverage mutants flights integration contract programs e2e page page-check docs browser clean

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

run: setup $(DOCS_SITE)
	packaging/keep-running $(BIN)/hawk-drone --config config.toml --sim $(ARGS)

# The browser's tests judge the page by axe, a package that its build does without.
browser: $(AXE)
	packaging/ensure-browser

$(AXE): | $(PAGE_STAMP)
	$(BIN)/python packaging/build_page.py --packages

# While working: 2 minutes on 2 cores.
check: lint fast

# Everything: see CONTRIBUTING.md for the time that each kind takes.
test: setup
	$(MAKE) --jobs 2 --output-sync lint page-check docs
	$(MAKE) $(UNIT_KINDS) programs

# Whole explorations and benchmarks' runs, what cheaper tests of `make test` show too, and properties on more and on new
# examples: once a night, and before a release. An hour.
nightly: setup browser
	$(UNIT) -m nightly $(ARGS)
	$(REAL) --numprocesses 2 -m nightly tests/integration $(ARGS)
	$(PYTEST) -m nightly tests/e2e $(ARGS)
	$(UNIT) -m hypothesis --hypothesis-profile=search $(ARGS)

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/oxlint --config hawk/web/page/.oxlintrc.json hawk/web/page
	$(BIN)/python packaging/check_wording.py

page-check: page
	$(BIN)/python packaging/build_page.py --check

# The page leads to /docs/: the first run builds it (9 s of a processor). A drone flies without it, too.
$(DOCS_SITE): | $(STAMP)
	-$(BIN)/python packaging/docs_site.py

# The site of the documentation, for the daemon's /docs/ and the wheel: links, anchors and menus are checked. The pages
# of reference, man pages and shell completions are written again first. Nothing is fetched.
docs: $(STAMP)
	$(BIN)/python packaging/protocol_page.py
	$(BIN)/python packaging/api_page.py
	$(BIN)/python packaging/command_line.py
	$(BIN)/python -m proving.faults --page
	$(BIN)/python packaging/docs_site.py $(ARGS)

# Each process collects every test, half a minute of a processor; these wait for nothing.
fast: $(STAMP)
	$(REAL) --numprocesses 2 tests/unit $(FAST) $(ARGS)

unit: $(STAMP)
	$(UNIT) -m 'not nightly' $(ARGS)

coverage: $(STAMP)
	$(UNIT) $(COVERED) --cov --cov-report= $(ARGS)
	$(BIN)/coverage report --sort=cover --fail-under=0 | sed -n 1,12p
	$(BIN)/coverage report --fail-under=100 --skip-covered --show-missing --include="$$($(BIN)/python -m proving.mutants --list)"

# Faults put into the modules that decide about safety: do their tests notice? ARGS="--seed 2 --only judge --verbose"
mutants: $(STAMP)
	$(BIN)/python -m proving.mutants $(ARGS)

flights: $(STAMP)
	$(UNIT) -m 'flight and not nightly' $(ARGS)

integration: $(STAMP)
	$(REAL) --numprocesses 3 -m $(SHARING) tests/integration $(ARGS)
	$(REAL) --numprocesses 2 -m $(ALONE) tests/integration $(ARGS)

# The contract with MAVSDK and ArduCopter. It waits more than it works: a hawk-sim for each module. A real vehicle, one
# test after the other: make contract ARGS="--autopilot udpin://127.0.0.1:14550"
contract: $(STAMP)
	$(if $(findstring --autopilot,$(ARGS)),$(PYTEST),$(REAL) --numprocesses 4) tests/contract $(ARGS)

# All programs and browsers: while one waits, another one works.
programs: setup browser
	$(REAL) --numprocesses 4 -m $(SHARING) tests/e2e tests/integration tests/contract $(ARGS)
	$(REAL) --numprocesses 2 -m $(ALONE) tests/integration tests/e2e $(ARGS)
	$(PYTEST) -m $(WHOLE) tests/e2e $(ARGS)

e2e: setup browser
	$(PYTEST) -m 'not nightly and (alone or whole)' tests/e2e $(ARGS)
	$(PYTEST) --numprocesses 2 --dist worksteal -m $(SHARING) tests/e2e $(ARGS)

# Every fault on the real programs: 45 minutes, on a quiet machine. What was measured is kept in docs/results/faults.json
# and docs/faults.md; `python -m proving.faults --table` prints it beside what must be seen.
faults: setup
	$(BIN)/python -m proving.faults --write $(ARGS)

# The API by its own definition: ten minutes of requests that it allows, and such as it does not, at a real server.
api-fuzz: setup
	$(BIN)/python -m proving.api $(ARGS)

# Fifty kills of the daemon and of a receiver of its reports, in turn: nothing is lost. Some minutes.
webhook-kills: setup
	WEBHOOK_KILLS=50 $(BIN)/python -m pytest -q tests/integration/test_webhook_kills.py $(ARGS)

# Documents of surveys while programs are killed and links, disk, clock and tokens fail: twenty minutes, as root on four
# cores and more. ARGS="--flights 1" on two cores.
chaos: setup
	$(BIN)/python -m proving.chaos $(ARGS)

# A real ArduCopter with the whole daemon; writes the rows of docs/ardupilot.md. Half an hour, in real time:
# make ardupilot ARDUPILOT=/path/to/arducopter [DEFAULTS=/path/to/copter.parm] [INSTANCE=N] [ARGS='"words"']
# LOT=PICTURE SCALE=METRES_PER_PIXEL [TRUTH=JSON] [PLACE=X,Y]: over a picture, in place of a drawn lot.
ARDUPILOT_OPTIONS = $(if $(DEFAULTS),--defaults "$(DEFAULTS)") $(if $(INSTANCE),--instance $(INSTANCE)) \
	$(if $(LOT),--world "$(LOT)" --metres-per-pixel "$(SCALE)") $(if $(TRUTH),--truth "$(TRUTH)") \
	$(if $(PLACE),--start "$(PLACE)")
ARDUPILOT_MISSING := set ARDUPILOT=/path/to/arducopter, ArduPilot's program for software-in-the-loop (docs/ardupilot.md)
ardupilot:
	@test -n "$(ARDUPILOT)" || { echo "make ardupilot: $(ARDUPILOT_MISSING)" >&2; exit 2; }
	@$(MAKE) --no-print-directory setup
	$(BIN)/python -m proving.faults.ardupilot --program "$(ARDUPILOT)" $(ARDUPILOT_OPTIONS) --write $(ARGS)

# The Debian packages (dist/) of each release, tried in its clean root: as root on Debian 12, with a network, some forty
# minutes. The tests build the container's image too, of the same wheels: six more.
# ARGS="-k life" tries less, RELEASES=trixie one release; DEB_TOOLS= leaves the tools as they are.
RELEASES ?= bookworm trixie
DEB_TOOLS ?= buildah debhelper dpkg-dev iproute2 lintian mmdebstrap python3-installer qemu-user-static
BUILD_DEB := $(BIN)/python packaging/deb/build_deb.py
deb: setup
	test -z "$(DEB_TOOLS)" || packaging/apt-install $(DEB_TOOLS)
	$(BIN)/python -m pip install --quiet 'uv>=0.9'
	$(BIN)/python packaging/docs_site.py
	for release in $(RELEASES); do \
		$(BUILD_DEB) --release $$release --arch amd64 --version 0.1.0 --out build/deb/before && \
		$(BUILD_DEB) --release $$release --arch amd64 && \
		$(BUILD_DEB) --release $$release --arch arm64 || exit; \
	done
	$(PYTEST) tests/package $(ARGS)

# The image by podman, docker or buildah (docs/container.md). ARGS="--target blueos --arch arm64" (docs/blueos.md).
container: setup
	$(BIN)/python -m pip install --quiet 'uv>=0.9'
	$(BIN)/python packaging/docs_site.py
	$(BIN)/python packaging/container/build_container.py $(ARGS)

bench: setup browser
	$(BIN)/python -m benchmarks $(ARGS)

# Surveys stored and registered, calls over a thousand of them, a flight recorded and replayed: some minutes.
bench-archive: setup
	$(BIN)/python -m benchmarks.archive $(ARGS)

# Twenty drawn lots, six surveys each, through the daemon's registration: half an hour.
bench-lots: setup
	$(BIN)/python -m benchmarks.lots $(ARGS)

# Photographs of simulated flights over ten drawn worlds, mapped as strangers' are: a quarter of an hour.
bench-pictures: setup
	$(BIN)/python -m benchmarks.pictures --photos $(ARGS)

# Three drawn lots, eighteen surveys each, against the simulator's history: a quarter of an hour.
study: setup
	$(BIN)/python -m benchmarks.study $(ARGS)

# The daemon on one core and 1 GiB, over three hectares: five minutes, as root, on a quiet machine.
bench-small: setup
	$(BIN)/python -m benchmarks.small $(ARGS)

# From a bare Debian 12 to a finished survey, by the README's commands: five minutes, as root, with a network. It tries
# the package in dist/ too, where `make deb` has left one.
newcomer: setup
	command -v mmdebstrap > /dev/null || packaging/apt-install mmdebstrap
	$(BIN)/python -m proving.newcomer $(ARGS)

clean:
	rm -rf $(VENV) hawk/web/static hawk/web/docs_site dist build
