# make install, demo, test and check work from nothing but Python 3.11.

PYTHON  ?= python3.11
VENV    := .venv
MEMBERS := $(patsubst %/pyproject.toml,%,$(wildcard */pyproject.toml services/*/pyproject.toml))
READY   := $(VENV)/.ready
PIP     := $(VENV)/bin/python -m pip -qq --disable-pip-version-check
IS_3_11 := -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null

.PHONY: install demo test test-long check clean
install: $(READY)

demo: $(READY)
	$(VENV)/bin/surefetch run --scene covered:109 --out runs/demo

test: $(READY)
	$(VENV)/bin/pytest -q

test-long: $(READY)
	$(VENV)/bin/pytest -q -m long --timeout 3600

check: $(READY)
	$(VENV)/bin/ruff format --check . && $(VENV)/bin/ruff check .
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports

$(READY): pyproject.toml constraints.txt $(MEMBERS:%=%/pyproject.toml)
	@$(PYTHON) $(IS_3_11) || \
	  { echo "surefetch needs Python 3.11 (PyBullet has no wheels for newer ones), and $(PYTHON) is not it. Install it, or name it: make PYTHON=/path/to/python3.11 $(MAKECMDGOALS)" >&2; exit 2; }
	@echo "Installing into $(VENV) …"
	@$(VENV)/bin/python $(IS_3_11) || $(PYTHON) -m venv --clear $(VENV)
	@$(PIP) install --upgrade "pip>=25.1"
	@$(PIP) install --constraint constraints.txt --group dev $(MEMBERS:%=--editable ./%)
	@touch $@

clean:
	rm -rf $(VENV)
