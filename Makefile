PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
OUT    ?= out/two_stage

.PHONY: run test lint format golden clean

run: $(STAMP)
	$(BIN)/servogen run examples/two_stage/servogen.toml -o $(OUT)

test: $(STAMP)
	$(BIN)/ruff format --check codegen tests
	$(BIN)/ruff check codegen tests
	$(BIN)/mypy
	$(BIN)/python -m pytest -n auto --dist loadgroup

lint: $(STAMP)
	$(BIN)/ruff check codegen tests
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff format codegen tests
	$(BIN)/ruff check --fix codegen tests

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "servogen needs Python 3.11 or newer; try: make PYTHON=python3.12 run"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' || \
	  { echo "Python's venv module is missing: apt-get install python3-venv"; exit 1; }
	@command -v gcc > /dev/null || { echo "gcc is missing: apt-get install gcc"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	@touch $@

clean:
	rm -rf $(VENV) out build
