# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
#
#   make demo    set up, run the sample dive, print where its report lies
#   make test    set up, run all tests
#   make test-fast   the tests for every commit: no chain is run
#   make web     rebuild the script and the style of the report page (needs Node and npm; nothing else does)
#   make bench-peers   the environment of the peers that benchmarks/peers.py measures (pycolmap, GTSAM)
#   make outside-readers   read the demo's files with other people's programs (GDAL, pycolmap, laspy, the glTF validator, evo ...)
#   make docs    build the documents as a site in build/site (mkdocs, in an environment of its own)
#   make check   lint, types, imports and format (what CI checks besides)
#
# Set-up needs `make` and `git` alone. It lists the system packages that are missing and installs them with apt-get as root or
# with sudo; SKIP_SYSTEM_PACKAGES=1 leaves the system as it is. All else goes into .venv.

SHELL := /bin/bash
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO ?= sample_data/demo
RUNS ?= out
JOBS ?= 2
FAST := $(addprefix tests/,artifacts dive/config estimation findings geometry native records test_new_folder.py test_rig.py)
NATIVE := $(shell find native -type f 2>/dev/null)

export OPENBLAS_NUM_THREADS = 1
export OMP_NUM_THREADS = 1
# Compiled modules are kept, whatever the caller's environment says: else each process compiles all that it imports.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: docs setup demo test test-fast check lint types imports format sanitize web bench-peers outside-readers clean
.DELETE_ON_ERROR:

setup: $(VENV)/.installed

$(VENV)/.packages: requirements.lock pipelines/setup.sh
	@PYTHON=$(PYTHON) bash pipelines/setup.sh packages $(VENV)
	@touch $@

$(VENV)/.installed: $(VENV)/.packages pyproject.toml $(NATIVE)
	@bash pipelines/setup.sh install $(VENV)
	@touch $@

demo: setup
	@$(BIN)/hullrecon run $(DEMO) --runs $(RUNS) --jobs $(JOBS)
	@echo "Open the report: $(abspath $(RUNS))/$(notdir $(DEMO))/deliver/report/index.html"

test: setup
	@bash pipelines/setup.sh browser
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -q

# FAST: the folders whose tests take a twentieth of a second each. No chain is run, and no test that is marked slow.
test-fast: setup
	$(BIN)/python -m pytest -n $(JOBS) --dist loadfile --no-loadscope-reorder -q -m "not slow" $(FAST)

check: lint types imports format

lint: setup
	$(BIN)/ruff check .

types: setup
	$(BIN)/mypy

imports: setup
	PYTHONPATH=. $(BIN)/lint-imports

format: setup
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror $(filter %.h %.cpp,$(NATIVE))

# The native tests once more with the address and undefined-behaviour sanitizers.
sanitize: setup
	$(BIN)/cmake -S native -B build/sanitize -G Ninja -DCMAKE_MAKE_PROGRAM=$(abspath $(BIN))/ninja \
		-DCMAKE_BUILD_TYPE=RelWithDebInfo -DHULLRECON_SANITIZE=ON
	$(BIN)/cmake --build build/sanitize -j $(JOBS)
	$(BIN)/ctest --test-dir build/sanitize --output-on-failure

# Sources in hullrecon/report/web; what is built lies in hullrecon/report/templates and in the repository.
web:
	cd hullrecon/report/web && npm ci --ignore-scripts --no-fund --no-audit && npm run build

# Never part of the project's own environment or lock.
PEERS := $(abspath build)/peers

bench-peers: $(PEERS)/.installed

$(PEERS)/.installed: benchmarks/requirements-peers.txt
	@$(PYTHON) -m venv $(PEERS)
	@$(PEERS)/bin/python -m pip install -q -r $<
	@touch $@

# Readers that are no part of the project's environment or lock: wheels, npm packages, and GDAL's programs of the system.
READERS := $(abspath tests/outside_readers)
OUTSIDE := $(abspath build)/outside-readers

outside-readers: demo $(OUTSIDE)/.installed
	@command -v gdalinfo >/dev/null && command -v ogrinfo >/dev/null || { echo "gdalinfo and ogrinfo are missing: apt-get install gdal-bin"; exit 1; }
	@rm -rf $(OUTSIDE)/colmap
	@$(BIN)/hullrecon export colmap $(RUNS)/$(notdir $(DEMO)) $(OUTSIDE)/colmap
	@$(OUTSIDE)/venv/bin/python -m pytest -q -c $(READERS)/pytest.ini --rootdir $(READERS) --confcutdir $(READERS) -p no:cacheprovider \
		$(READERS) --run $(abspath $(RUNS))/$(notdir $(DEMO)) --colmap $(OUTSIDE)/colmap --node $(OUTSIDE)

$(OUTSIDE)/.installed: $(wildcard tests/outside_readers/*.txt tests/outside_readers/*.json tests/outside_readers/*.mjs)
	@command -v npm >/dev/null || { echo "npm is missing, for the glTF validator and Foxglove's reader: apt-get install nodejs npm"; exit 1; }
	@mkdir -p $(OUTSIDE)
	@$(PYTHON) -m venv $(OUTSIDE)/venv
	@$(OUTSIDE)/venv/bin/python -m pip install -q -r $(READERS)/requirements.txt
	@cp $(READERS)/*.json $(READERS)/*.mjs $(OUTSIDE)
	@cd $(OUTSIDE) && npm ci --ignore-scripts --no-fund --no-audit --silent
	@touch $@

# The site, by reader: operator, developer, method. mkdocs has an environment of its own.
DOCS := $(abspath build)/docs

docs: $(DOCS)/.installed
	@rm -rf build/site-source && mkdir -p build/site-source
	@cp -r docs *.md build/site-source
	@$(DOCS)/bin/mkdocs build --quiet && echo "Open the documents: $(abspath build)/site/index.html"

$(DOCS)/.installed: docs/requirements.txt
	@$(PYTHON) -m venv $(DOCS)
	@$(DOCS)/bin/python -m pip install -q -r $<
	@touch $@

clean:
	rm -rf build $(VENV) .mypy_cache .ruff_cache .pytest_cache
