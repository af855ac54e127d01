# CableTwin: make help tells what there is.  Every target makes .venv first, by itself and only once.

PY := .venv/bin/python
SEEDS ?= 1 2 3
SEED ?= 11

# sums in BLAS depend on how many threads share them, and small matrices lose by sharing
export OPENBLAS_NUM_THREADS ?= 1
export PYTHONHASHSEED ?= 0
# a plot needs no window
export MPLBACKEND ?= Agg

.DEFAULT_GOAL := help
.PHONY: help setup demo demo-steel test accuracy lint bench assets extension install-extension test-ui clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 26

setup: .venv/.ready ## make .venv with Python 3.13 and the pinned packages

.venv/.ready: requirements.lock pyproject.toml
	@sh tools/setup.sh

demo: .venv/.ready ## render a survey, reconstruct it, print the diameters against truth
	@sh tools/demo.sh specs/demo.toml out/demo

demo-steel: .venv/.ready ## scan a steel frame, register the stations, measure nodes and columns against truth
	@sh tools/demo_steel.sh specs/steel/small.toml out/demo-steel

test: .venv/.ready ## run the tests
	@$(PY) -m pytest
	@$(PY) -m pytest tests/addon

accuracy: .venv/.ready ## the gate: paper and sway in small, each figure between two bounds (SEED=11): minutes
	@$(PY) -m synth.gate --seed $(SEED) --out out/accuracy

lint: .venv/.ready ## check style and types
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .
	@$(PY) -m mypy
	@$(PY) -m mypy -p tools.observability
	@$(PY) -m mypy -p tools.extension

bench: .venv/.ready ## every scenario with several seeds (SEEDS="1 2 3") and stock COLMAP, to docs/benchmark.md: hours
	@$(PY) -m synth suite --seeds $(SEEDS) --out out/bench --stock --keep-runs --docs docs

extension: .venv/.ready ## the Blender extension, a zip for each platform, in build/extension/all
	@$(PY) -m tools.extension build

install-extension: .venv/.ready ## build it for a Blender of this machine and install it there (BLENDER=blender)
	@$(PY) -m tools.extension install --blender "$(or $(BLENDER),blender)"

test-ui: .venv/.ready ## walk the flow in a real Blender's window (BLENDER=blender), pictures in out/ui
	@$(PY) -m tests.ui --blender "$(or $(BLENDER),blender)"

assets: .venv/.ready ## the asset library of the extension, to build/assets
	@$(PY) -m blend_assets.build build/assets

clean: ## remove what demo, bench and the checks made; .venv stays
	rm -rf out build .pytest_cache .mypy_cache .ruff_cache
	find addon blend_assets pipeline synth tests tools -type d -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
