# make demo, make test and make check work from nothing but Python 3.11.

PYTHON  ?= python3.11
VENV    := .venv
MEMBERS := $(patsubst %/pyproject.toml,%,$(wildcard */pyproject.toml services/*/pyproject.toml))
READY   := $(VENV)/.ready

.PHONY: install demo test test-long check clean
install: $(READY)

demo: $(READY)
	$(VENV)/bin/surefetch run --scene covered:1 --out runs/demo

test: $(READY)
	$(VENV)/bin/pytest -q

test-long: $(READY)
	$(VENV)/bin/pytest -q -m long --timeout 3600

check: $(READY)
	$(VENV)/bin/ruff format --check . && $(VENV)/bin/ruff check .
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports

$(READY): pyproject.toml constraints.txt $(MEMBERS:%=%/pyproject.toml)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null || \
	  { echo "surefetch needs Python 3.11 (PyBullet has no wheels for newer ones). Install it, or name it: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --upgrade "pip>=25.1"
	$(VENV)/bin/pip install --quiet --constraint constraints.txt --group dev $(MEMBERS:%=--editable ./%)
	touch $@

clean:
	rm -rf $(VENV)
