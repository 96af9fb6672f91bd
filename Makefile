# Everything happens in .venv; no system package and no root is needed.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
DRIVER ?= realsense
# Relative, for pip takes several files from the variables and splits them at spaces.
PINS := constraints.txt
PIP := PIP_CONSTRAINT=$(PINS) PIP_BUILD_CONSTRAINT=$(PINS) $(BIN)/python -m pip install \
	--quiet --disable-pip-version-check
# Gigabytes come over the network: a second try keeps what the first has fetched.
INSTALL = $(PIP) '.[$(EXTRAS)]' || { sleep 20; $(PIP) '.[$(EXTRAS)]'; }
SOURCES := $(shell find src/circumspect native -type f -not -name '*.pyc') \
	CMakeLists.txt pyproject.toml constraints.txt README.md

.PHONY: demo viewer ros2 test lint audit fuzz sanitize docs bench constraints clean
.DEFAULT_GOAL := demo

$(VENV)/created:
	$(PYTHON) -m venv $(VENV)
	$(PIP) pip
	touch $@

$(VENV)/installed-demo: EXTRAS = sim
$(VENV)/installed-demo: $(VENV)/created $(SOURCES)
	$(INSTALL)
	touch $@

$(VENV)/installed-viewer: EXTRAS = sim,viewer
$(VENV)/installed-viewer: $(VENV)/created $(SOURCES)
	$(INSTALL)
	touch $@ $(VENV)/installed-demo

$(VENV)/installed-ros2: EXTRAS = ros2
$(VENV)/installed-ros2: $(VENV)/created $(SOURCES)
	$(INSTALL)
	touch $@

$(VENV)/installed-test: EXTRAS = test
$(VENV)/installed-test: $(VENV)/created $(SOURCES)
	$(INSTALL)
	touch $@ $(VENV)/installed-demo $(VENV)/installed-viewer $(VENV)/installed-ros2

demo: $(VENV)/installed-demo  ## a simulated robot drives round an object and names it
	$(BIN)/circumspect demo

viewer: $(VENV)/installed-viewer  ## the same, shown and steered in the browser
	$(BIN)/circumspect demo --viewer

ros2: $(VENV)/installed-ros2  ## names what a ROS 2 robot's depth camera sees
	$(BIN)/circumspect ros2 --driver $(DRIVER)

test: $(VENV)/installed-test  ## all tests
	$(BIN)/python -m pytest -n auto --dist loadgroup

lint: $(VENV)/installed-test  ## style, types and import floors
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

audit: $(VENV)/installed-test  ## known faults of the packages that are pinned and installed
	$(BIN)/python .ci/audit.py

SECONDS_EACH ?= 3600
fuzz: $(VENV)/installed-test  ## mutated files for every reader; long, before a release
	$(BIN)/python -m tests.fuzz all --seconds $(SECONDS_EACH)

# The tests of the kernels, with the kernels built to find wrong accesses and undefined behaviour.
NATIVE_TESTS := $(wildcard tests/*/test_*native*.py tests/*/test_*twin*.py) \
	tests/grid tests/sensing/test_depth_blocks.py
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

constraints:  ## newest versions of everything, written to constraints.txt
	rm -rf build/constraints && $(PYTHON) -m venv build/constraints
	build/constraints/bin/python -m pip install --quiet --upgrade pip
	build/constraints/bin/python -m pip install --quiet '.[test]' scikit-build-core nanobind cmake ninja
	head -1 constraints.txt > build/constraints.txt
	build/constraints/bin/python -m pip freeze --exclude circumspect >> build/constraints.txt
	build/constraints/bin/python -m pip list --format=freeze | grep '^pip==' >> build/constraints.txt
	mv build/constraints.txt constraints.txt

clean:
	rm -rf $(VENV) build dist
