# creak: fresh clone -> `make demo` (door run, report) or `make test` (all tests).
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
H      ?= 20

.PHONY: demo test lint docs verification bench dist clean
.DELETE_ON_ERROR:

$(VENV)/run.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[report,cluster]'
	touch $@

$(VENV)/docs.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[docs,report]'
	touch $@

$(VENV)/dev.stamp: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -e '.[dev,report,cluster,docs]'
	touch $@

demo: $(VENV)/run.stamp
	$(BIN)/creak example door --mesh-size $(H) --out door
	$(BIN)/creak run door/door.toml --out door/results
	@echo "open door/results/report.html"

test: $(VENV)/dev.stamp
	$(BIN)/python -m pytest

lint: $(VENV)/dev.stamp
	$(BIN)/ruff check .
	$(BIN)/mypy

docs: $(VENV)/docs.stamp
	$(BIN)/python -m tools.commands_page
	$(BIN)/python -m tools.study_page
	$(BIN)/python -m tools.gallery
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet
	@echo "open build/site/index.html"

verification: $(VENV)/dev.stamp
	$(BIN)/python -m pytest --measured=docs/verification.json
	$(BIN)/python -m tools.verification_page

bench: $(VENV)/dev.stamp
	$(BIN)/python -m benchmarks
	$(BIN)/python -m benchmarks.stepping --mesh-size 8.7
	$(BIN)/python -m benchmarks.million
	$(BIN)/python -m benchmarks.unreduced
	$(BIN)/python -m benchmarks.deck_size
	$(BIN)/python -m benchmarks.modes_cost
	$(BIN)/python -m benchmarks.modes_peers

dist: $(VENV)/dev.stamp
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python -m pytest tests/packaging

clean:
	rm -rf $(VENV) door build dist src/*.egg-info .pytest_cache .mypy_cache .ruff_cache
