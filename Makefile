# creak: fresh clone -> `make demo` (door run, report) or `make test` (all tests).
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
H      ?= 20
NEWEST_PYTHON ?= python3.13
LOWEST_PYTHON ?= python3.11
NEWEST := build/newest
LOWEST := build/lowest
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
# Of other versions: kernels that are compiled sooner and run slower.
KERNELS     = NUMBA_OPT=1 NUMBA_CACHE_DIR=$(CURDIR)/build/$*/numba
PARALLEL   := -n 3 --dist loadfile
COMPILE    := "from creak.dynamics.flow.ahead import compile_flow; compile_flow(); compile_flow(solver=True)"
# Else each process would compile all modules of all packages anew: half of what a short command takes.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test check licences lint kernels collect docs evidence verification bench dist clean \
  $(foreach step,test install demo unit,$(step)-newest $(step)-lowest)
.DELETE_ON_ERROR:

$(VENV)/run.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --no-compile --disable-pip-version-check -e '.[report]'
	touch $@

$(VENV)/docs.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --no-compile --disable-pip-version-check -e '.[docs,report]'
	touch $@

$(VENV)/dev.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --no-compile --disable-pip-version-check -e '.[dev,report,cluster,docs]'
	touch $@

demo: $(VENV)/run.stamp
	$(BIN)/creak example door --mesh-size $(H) --out door
	$(BIN)/creak run door/door.toml --out door/results
	@echo "open door/results/report.html"

test: $(VENV)/dev.stamp
	$(ONE_THREAD) $(BIN)/python -m pytest $(PARALLEL)

# After each edit: unit tests but for those that are marked slow; a test that takes more than two seconds is named.
check: $(VENV)/dev.stamp
	$(ONE_THREAD) $(BIN)/python -m pytest $(PARALLEL) --quick 2 tests/unit tests/test_architecture.py tests/test_house.py

# The newest release of everything on the newest Python, whatever was there before, the demo at 40 mm, unit and packaging
# tests with it: before a release.
test-newest:
	$(MAKE) install-newest
	$(MAKE) demo-newest
	$(MAKE) unit-newest

# The same with the lowest version of everything that pyproject.toml names.
test-lowest:
	$(MAKE) install-lowest
	$(MAKE) demo-lowest
	$(MAKE) unit-lowest

install-newest:
	$(NEWEST_PYTHON) -m venv $(NEWEST)
	$(NEWEST)/bin/pip install --quiet --no-compile --disable-pip-version-check --upgrade --upgrade-strategy eager -e '.[dev,report,cluster]'

install-lowest:
	$(LOWEST_PYTHON) -m venv $(LOWEST)
	$(LOWEST_PYTHON) -m tools.lowest > $(LOWEST)/constraints.txt
	$(LOWEST)/bin/pip install --quiet --no-compile --disable-pip-version-check --constraint $(LOWEST)/constraints.txt -e '.[dev,report,cluster]'

demo-newest demo-lowest: demo-%:
	@build/$*/bin/pip list --format=freeze --exclude-editable | paste -s -d ' ' -
	$(KERNELS) build/$*/bin/creak example door --mesh-size 40 --out build/$*/door
	$(KERNELS) $(ONE_THREAD) build/$*/bin/creak run build/$*/door/door.toml --set time.periods=1 --set reduction.f_max=1500 --no-converge --out build/$*/door/results

# The whole suite runs with the newest versions that the default Python takes. With others what solves, reads and writes
# files of other packages, and draws; what the lowest compile is run by their demo, with its sound. Decks are text, which
# no version reads otherwise. What else creak takes of a package is looked up by tests/packaging/test_names_taken.py.
UNIT := $(addprefix tests/unit/,linalg report signals studies/file) \
  $(wildcard $(addprefix tests/unit/formats/test_,hdf5* matri* stored* tree* wav*))
unit-newest unit-lowest: unit-%:
	$(KERNELS) CREAK_TESTED=$* $(ONE_THREAD) build/$*/bin/python -m pytest $(PARALLEL) -m 'not once and not slow' $(UNIT) tests/packaging

# Rows of packages that only the lowest or the newest versions bring are kept; the last one words the others.
licences: $(VENV)/dev.stamp
	for python in $(LOWEST)/bin/python $(NEWEST)/bin/python $(BIN)/python; do \
	  if test -x $$python; then $$python -m tools.licences_page || exit 1; fi; \
	done

# The kernels of the default run, those of a small one with friction, spot checks and sound last: else each process of the
# tests would compile them.
kernels: $(VENV)/dev.stamp
	$(ONE_THREAD) $(BIN)/python -c $(COMPILE)
	$(ONE_THREAD) $(BIN)/python -m pytest tests/analytic/test_rubbing.py -k static_surplus

# Else each process of the tests would compile all of their files; build/tests.txt lists them.
collect: $(VENV)/dev.stamp
	mkdir -p build
	$(ONE_THREAD) $(BIN)/python -m pytest --collect-only > build/tests.txt

lint: $(VENV)/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check --quiet .
	$(BIN)/mypy

# Pages of what is stored: nothing is computed.
docs: $(VENV)/docs.stamp
	$(BIN)/python -m tools.commands_page
	$(BIN)/python -m tools.study_page
	$(BIN)/python -m tools.evidence_pages
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "open build/site/index.html"

verification: $(VENV)/dev.stamp
	$(BIN)/python -m pytest --measured=docs/verification.json
	$(BIN)/python -m tools.verification_page

# The figures that pages and advice rest on, those of the tutorial and of the gallery.
evidence: $(VENV)/dev.stamp
	$(BIN)/python -m benchmarks.tutorial
	$(BIN)/python -m benchmarks.evidence
	$(BIN)/python -m tools.evidence_pages
	$(BIN)/python -m benchmarks.ranking --out docs/ranking.json
	$(BIN)/python -m tools.gallery

bench: $(VENV)/dev.stamp
	$(BIN)/python -m benchmarks
	$(BIN)/python -m benchmarks.stepping --mesh-size 8.7
	$(BIN)/python -m benchmarks.million
	$(BIN)/python -m benchmarks.unreduced
	$(BIN)/python -m benchmarks.deck_size
	$(BIN)/python -m benchmarks.modes_cost
	$(BIN)/python -m benchmarks.modes_peers
	$(BIN)/python -m benchmarks.sound
	$(BIN)/python -m benchmarks.start

dist: $(VENV)/dev.stamp
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python -m pytest tests/packaging

clean:
	rm -rf $(VENV) door build dist src/*.egg-info .pytest_cache .mypy_cache .ruff_cache
