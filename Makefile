# crawler-bench: `make` lists what there is to make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/installed
MINIMUM_TESTS := tests/physics tests/envs tests/agents tests/gait tests/runs tests/output

.DEFAULT_GOAL := help
.PHONY: help reproduce test test-slow test-wheel test-minimum coverage speed check docs format clean

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-10s %s\n", $$1, $$2}'

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "crawler-bench needs Python 3.11 or newer; say which with: make PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[dev]"
	@touch $@

reproduce: $(STAMP) ## train the paper's two gaits, write results/paper/ (claims, figures, animations)
	$(BIN)/crawler-bench reproduce

test: check ## run the checks and the whole fast test suite
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

test-slow: $(STAMP) ## the tests that train at full length
	$(BIN)/python -m pytest -n 2 -m slow

test-wheel: $(STAMP) ## build the wheel, install it in an empty environment, use it there
	$(BIN)/python -m pytest -m slow tests/docs/test_wheel.py

# Old releases use what their own dependencies have deprecated since; that is not ours to mend.
test-minimum: ## the environment and the agents with the oldest release of every dependency that is allowed
	$(PYTHON) -m venv $(VENV)-minimum
	$(VENV)-minimum/bin/python -m pip install --quiet -c constraints-minimum.txt -e . pytest hypothesis
	$(VENV)-minimum/bin/python -m pytest -m "not slow" -W ignore::DeprecationWarning $(MINIMUM_TESTS)

# Lines that are compiled cannot be traced, so their tests run once more as plain Python, as far as they are short.
coverage: $(STAMP) ## which lines the tests reach, compiled ones included; writes htmlcov/
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -n 2 -m "not slow" -p tests.without_compiler --cov --cov-report= \
		-W "ignore:overflow encountered:RuntimeWarning" tests/physics tests/envs tests/agents tests/gait
	$(BIN)/python -m pytest -n 2 -m "not slow" --cov --cov-append --cov-report=term --cov-report=html \
		--ignore=tests/physics --ignore=tests/speed

speed: $(STAMP) ## measure speed, append it to results/speed/, fail if a goal fails
	$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[dev,speed]"
	$(BIN)/python -m speed

check: $(STAMP) ## lint, types, spelling, import contracts
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/codespell
	$(BIN)/lint-imports
	@! grep -rniwE 'anew|of which|stands for|so many' --include='*.py' --include='*.md' crawler_bench agents speed tests docs *.md \
		|| { echo "plainer words, please: see the lines above"; exit 1; }

docs: $(STAMP) ## build the documentation site in site/, its notebook included; a warning is an error
	$(BIN)/python -m pip install --quiet -c constraints.txt -e ".[dev,docs]"
	NO_MKDOCS_2_WARNING=1 PYTHONPATH=. PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/mkdocs build --strict --quiet

format: $(STAMP) ## format and fix what can be fixed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean: ## remove the virtual environment and every cache; results stay
	rm -rf $(VENV) $(VENV)-minimum .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .coverage
	rm -rf htmlcov site
