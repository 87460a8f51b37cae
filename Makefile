PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
SYSTEM ?= two_stage
OUT    ?= out/$(SYSTEM)

# The evidence about the emitted C, each piece a target of its own; what a target needs beyond gcc
# it says itself. `servogen check list` has them with their packages.
SYSTEMS  := two_stage servo_drive command_governor contour_lq
CHECKS   := counts compilers coverage sanitizers misra pil prove fuzz dsp
PROJECTS := two_stage/servogen two_stage/sprg_alone two_stage/unequal_axes two_stage/active_set \
            servo_drive/servogen command_governor/small contour_lq/servogen
# out/two_stage for the project that `make run` is about, else out/<file>
out_of = out/$(if $(filter servogen,$(notdir $(1))),$(patsubst %/,%,$(dir $(1))),$(notdir $(1)))

.PHONY: run test test-tools lint format golden bench bench-docs browser clean seeded $(CHECKS) evidence certificate

run: $(STAMP)
	$(BIN)/servogen run examples/$(SYSTEM)/servogen.toml -o $(OUT)

test: $(STAMP)
	$(BIN)/ruff format --check codegen tests
	$(BIN)/ruff check codegen tests
	$(BIN)/mypy
	$(BIN)/python -m pytest -n auto --dist loadgroup

# The tests of the checks with what they start (Frama-C, QEMU, cppcheck, libFuzzer, a C6000's gcc), and
# the larger of those that gcc alone makes: a small case of each of these is in the default run.
test-tools: $(STAMP)
	$(BIN)/python -m pytest -n auto --dist loadgroup -m tools

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

# The committed output of the bundled examples.
golden: $(STAMP)
	for system in $(SYSTEMS); do \
	  $(BIN)/servogen build examples/$$system/servogen.toml -o generated/$$system || exit 1; done

# Ratios against peers, each within one run, and what they must reach: critical regions and lookups
# against PPOPT, the sizes of search trees, instruction counts of QP back ends (needs valgrind, g++).
# All of them run, whatever one says; the tables of docs/benchmarks.md are made by bench-docs.
bench: $(STAMP)
	@for tool in valgrind g++; do command -v $$tool > /dev/null || \
	  { echo "make bench needs $$tool: apt-get install $$tool"; exit 1; }; done
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[bench]'
	@failed=; begin=$$(date +%s); \
	for each in explicit_regions pqp_iteration lookups qp_solvers; do \
	  $(BIN)/python benchmarks/$$each.py; status=$$?; \
	  if [ $$status = 130 ]; then exit 130; fi; \
	  [ $$status = 0 ] || failed="$$failed $$each"; done; \
	echo "make bench: $$(( ($$(date +%s) - begin) / 60 )) minutes"; \
	test -z "$$failed" || { echo "promises broken, or not judged:$$failed"; exit 1; }

bench-docs: $(STAMP)
	$(BIN)/python benchmarks/write_docs.py out/bench

$(CHECKS): $(STAMP)
	$(foreach p,$(PROJECTS),$(BIN)/servogen check $@ examples/$(p).toml -o $(call out_of,$(p)) && ) :

# All of it, then the line itself, so that its report and certificate show what was found. What
# could not run is told, and makes the target fail.
evidence: $(STAMP)
	@failed=; for check in $(CHECKS); do \
	  $(MAKE) --no-print-directory $$check || failed="$$failed $$check"; done; \
	for project in $(PROJECTS); do \
	  case $$project in */servogen) out=out/$${project%/servogen};; *) out=out/$${project##*/};; esac; \
	  $(BIN)/servogen run examples/$$project.toml -o $$out || failed="$$failed run:$$project"; done; \
	test -z "$$failed" || { echo "FAILED OR NOT RUN:$$failed"; exit 1; }

# What is kept in out/ about the present build, as one certificate per project.
certificate: $(STAMP)
	$(foreach p,$(PROJECTS),$(BIN)/servogen certificate examples/$(p).toml -o $(call out_of,$(p)) && ) :

# Ten kinds of fault planted in copies of the emitted C, and which check finds which: an hour or more
# with all tools. ONLY="coverage misra" runs those checks and the quick ones. What was found out about
# the same C before is taken from out/seeded.json.
seeded: $(STAMP)
	for project in servogen active_set; do $(BIN)/python -m servogen.steps.plant_faults \
	  examples/two_stage/$$project.toml docs/seeded-faults.md out/seeded.json $(ONLY) || exit 1; done

# The reports in headless Chromium: every plot drawn, no console error. Judges those of "make run" and
# "make evidence" where there are any.
browser: $(STAMP)
	for system in $(SYSTEMS); do \
	  test -f out/$$system/report.html || \
	    $(BIN)/servogen report examples/$$system/servogen.toml -o out/$$system/report.html || exit 1; \
	  $(BIN)/python -m servogen.reports.browser out/$$system/report.html || exit 1; done
