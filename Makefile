# For users: `make demo` and `make test`. For contributors: `make check`, `make docs`. Each sets up .venv with all it needs.
PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python
STAMP := $(VENV)/.installed

.PHONY: demo test check lint format types docs pages pretrained sweep-test web web-test clean

demo: $(STAMP)
	$(VENV)/bin/adaptnet demo

test: $(STAMP)
	$(VENV)/bin/adaptnet doctor
	OMP_NUM_THREADS=1 $(RUN) -m pytest -q -n 2 --dist worksteal

check: lint types test

lint: $(STAMP)
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .

format: $(STAMP)
	$(VENV)/bin/ruff check --fix .
	$(VENV)/bin/ruff format .

types: $(STAMP)
	$(VENV)/bin/mypy -n 2

docs: $(STAMP)
	$(RUN) -m pip install --quiet -c constraints.txt -e ".[docs]"
	$(VENV)/bin/mkdocs build --strict

# What GitHub Pages shows: the site of `make docs` with the playground in its folder playground.
pages: docs web
	rm -rf site/playground
	cp -R web/dist site/playground

# All adaptations that ship, trained again: about thirty-one hours on two cores (an estimate: docs/sweeps.md).
pretrained: $(STAMP)
	$(RUN) -m pip install --quiet -c constraints.txt -e ".[sweep]"
	$(VENV)/bin/adaptnet sweep pretrained

# Sweeps by Ray, whose driver and workers are killed.
sweep-test: $(STAMP)
	$(RUN) -m pip install --quiet -c constraints.txt -e ".[sweep]"
	$(RUN) -m pytest -m slow tests/sb3_adaptnet/sweeps

# The playground in the browser: a static site in web/dist.
web: $(STAMP)
	@command -v npm > /dev/null || { echo "the playground needs npm, which is not installed"; exit 1; }
	$(RUN) web/emit.py web/public/data
	cd web && npm ci && npm run build

# Its tests: against the environments, and in a real browser.
web-test: $(STAMP)
	@if ! command -v npm > /dev/null; then echo "skipped: the playground's tests need npm, which is not installed"; \
	else $(MAKE) web && $(RUN) web/replay.py web/test/replay.json.gz && cd web && npm test; fi

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -c "import sys; sys.exit('Python 3.11 or newer is needed, this is ' + sys.version.split()[0] if sys.version_info < (3, 11) else 0)"
	$(PYTHON) -m venv $(VENV)
	$(RUN) -m pip install --quiet --upgrade pip
	$(RUN) -m pip install --quiet -c constraints.txt torch
	$(RUN) -m pip install --quiet -c constraints.txt -e ".[zoo,test,dev]"
	touch $(STAMP)

clean:
	rm -rf $(VENV) build dist site *.egg-info web/dist web/node_modules web/public
