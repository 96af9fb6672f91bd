# Everything happens in .venv; no system package and no root is needed.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PIP := PIP_CONSTRAINT=constraints.txt $(BIN)/python -m pip install --quiet --disable-pip-version-check
SOURCES := $(shell find src/circumspect native -type f -not -name '*.pyc') CMakeLists.txt pyproject.toml constraints.txt

.PHONY: demo test lint bench clean
.DEFAULT_GOAL := demo

$(VENV)/created:
	$(PYTHON) -m venv $(VENV)
	$(PIP) pip
	touch $@

$(VENV)/installed-demo: $(VENV)/created $(SOURCES)
	$(PIP) '.[sim]'
	touch $@

$(VENV)/installed-test: $(VENV)/created $(SOURCES)
	$(PIP) '.[test]'
	touch $@

demo: $(VENV)/installed-demo  ## a simulated camera circles an object and names it
	$(BIN)/circumspect demo

test: $(VENV)/installed-test  ## all tests
	$(BIN)/python -m pytest -n auto

lint: $(VENV)/installed-test  ## style, types and import floors
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

bench: $(VENV)/installed-test  ## the benchmark suite; writes benchmarks/results/
	$(BIN)/python -m benchmarks.run

clean:
	rm -rf $(VENV) build dist
