# make setup | demo | test | lint | check | docs | bare | benchmarks | hidden | paper | clean
SEED ?= 1
WORKERS ?= 2
STAMP := .venv/.servosight-is-set-up
BIN := .venv/bin
# Where it is set, each process of the tests would compile every module anew
unexport PYTHONDONTWRITEBYTECODE

.PHONY: setup demo test lint check docs bare benchmarks hidden paper fuzz fuzz-fmu kill-test sweep-kill-test bench-faults older-sdk clean
.DEFAULT_GOAL := setup

setup: $(STAMP)

$(STAMP): pyproject.toml uv.lock hatch_build.py src/servosight/__init__.py tools/setup.sh tools/check_opengl.py
	@tools/setup.sh
	@touch $@

# The same recording, model, diagnosis and report for the same seed: make demo SEED=7
demo: setup
	@echo "demo: films, tracks and diagnoses a servo; one to three minutes, 200 MB in out/demo"
	@$(BIN)/servosight demo -o out/demo --seed $(SEED)

# Pass more to pytest by ARGS: make test ARGS="tests/models -k friction"
test: setup
	@echo "test: pytest in $(WORKERS) processes (WORKERS=N changes that); all tests take about 12 minutes on two cores"
	@[ -n "$$SERVOSIGHT_DATA" ] || echo "test: tests on recordings of real servos are skipped, because SERVOSIGHT_DATA names no folder"
	@$(BIN)/python -m pytest -n $(WORKERS) $(ARGS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

check: lint test

# Both commands in a bare root made by debootstrap; as root
bare:
	@tools/bare_root.sh

# What the groups of the lock add to .venv: peers that benchmarks compare with, and what builds the site
UV ?= $(shell command -v uv || echo .venv-uv/bin/uv)
ADD = UV_PROJECT_ENVIRONMENT=.venv $(UV) sync --frozen --quiet --inexact --group
PEERS = $(ADD) benchmarks

# The documentation as a site in out/docs, with the API reference from the docstrings
docs: setup
	@$(ADD) docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "docs: open out/docs/index.html"

benchmarks: setup
	@$(PEERS)
	@set -e; for script in $(wildcard benchmarks/[a-z]*.py); do \
		[ -e "$$script" ] || { echo "benchmarks/ holds no script yet"; break; }; \
		echo "== $$script"; $(BIN)/python "$$script"; \
	done

# Hours: TRIALS a row. It goes on from what stands in out/hidden/; make hidden ARGS="--rows single"
TRIALS ?= 300
hidden: setup
	$(BIN)/python benchmarks/hidden --trials $(TRIALS) --processes $(WORKERS) $(ARGS)
	$(BIN)/python benchmarks/hidden --page

# docs/paper.md anew, beside its peers from the lock's benchmarks group; some parts: ARGS="table-1"
paper: setup
	$(PEERS)
	$(BIN)/python benchmarks/paper $(ARGS)

# Damaged inputs through the command line, each failure with its smallest reproducer: INPUTS=20000
INPUTS ?= 20000
fuzz: setup
	$(BIN)/python tests/fuzz/run.py --count $(INPUTS) --workers $(WORKERS) $(ARGS)

# Damaged FMUs, each given to the four commands that take one: FMUS=500
FMUS ?= 500
fuzz-fmu: setup
	$(BIN)/python tests/fuzz/fmus.py $(FMUS) $(ARGS)

# Commands killed at random moments, and what they leave behind: KILLS=200
KILLS ?= 200
kill-test: setup
	$(BIN)/python tests/fuzz/kills.py --count $(KILLS) $(ARGS)

# Sweeps killed with all their workers at random moments, and their rows beside those of an undisturbed one: SWEEPKILLS=20
SWEEPKILLS ?= 20
sweep-kill-test: setup
	$(BIN)/python tests/fuzz/sweep_kills.py --count $(SWEEPKILLS) --workers $(WORKERS) $(ARGS)

# The bench's stand-in under version 3 of Dynamixel's SDK, beside version 4 of the environment
older-sdk: setup
	@tools/older_sdk.sh

# Runs before a virtual camera with faults of wire, servo, camera, host and disk at once: RUNS=100
RUNS ?= 100
bench-faults: setup
	$(BIN)/python tests/fuzz/bench_runs.py --count $(RUNS) $(ARGS)

clean:
	rm -rf .venv .venv-uv out dist build .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
	find src/servosight -type l -delete
