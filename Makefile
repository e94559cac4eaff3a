# make run | test | lint | bench | bench-crossing | bench-baselines | bench-conflicts |
# bench-motion | bench-crowd | bench-real | bench-store | bench-street | bench-rl |
# bench-reproduction | paper | soak | lock | audit: each sets up what it needs in .venv first.

VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
export PYTHONDONTWRITEBYTECODE = 1
# What is installed for development and CI, to the version; `make LOCK= test` takes the newest.
LOCK ?= -c constraints.txt
# One thread each for the linear algebra: the work is spread over processes, and figures repeat.
export OPENBLAS_NUM_THREADS = 1

.PHONY: run test test-postgres lint format bench bench-crossing bench-baselines bench-delay bench-conflicts \
	bench-motion bench-crowd bench-real bench-scaling bench-store bench-street bench-rl \
	bench-reproduction paper soak pictures chromium postgres nginx \
	lock audit clean

run: $(VENV)/.installed
	$(BIN)/evastudio

# Side by side; which tests stay together is in tests/conftest.py.
WORKERS ?= 2
SIDE_BY_SIDE = -n $(WORKERS) --dist loadscope --no-loadscope-reorder

test: $(VENV)/.rl chromium postgres nginx
	$(BIN)/python -m pytest $(SIDE_BY_SIDE)

# The store, its recorder and the stages are tested on both databases by `make test`; this runs
# everything that goes over HTTP on PostgreSQL too.
test-postgres: $(VENV)/.dev postgres
	EVASTUDIO_TESTS_ON=postgres $(BIN)/python -m pytest $(SIDE_BY_SIDE) tests/api tests/client

lint: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(VENV)/.dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(VENV)/.bench
	$(BIN)/python benchmarks/performance.py

bench-crossing: $(VENV)/.dev
	$(BIN)/python benchmarks/crossing.py

bench-baselines: $(VENV)/.dev
	$(BIN)/python -m benchmarks.baselines

bench-scaling: $(VENV)/.dev
	$(BIN)/python -m benchmarks.scaling

# Twenty hours of takes in SQLite and in PostgreSQL, into docs/store.md; about 5 minutes.
bench-store: $(VENV)/.dev postgres
	$(BIN)/python -m benchmarks.store

bench-delay: $(VENV)/.dev
	$(BIN)/python -m benchmarks.delay

bench-conflicts: $(VENV)/.dev
	$(BIN)/python benchmarks/conflicts.py

# How fast a crowd is posed and how far feet slide, into docs/motion.md; it reads recordings too.
bench-motion: $(VENV)/.dev
	$(BIN)/python benchmarks/motion.py

# How a crowd walks and flees, into docs/crowd.md, and how fast it decides, into
# docs/performance.md.
bench-crowd: $(VENV)/.dev
	$(BIN)/python -m benchmarks.crowd

# Recordings of people: EVASTUDIO_DATA names their folder, else it is ../shared/data.
bench-real: $(VENV)/.bench
	$(BIN)/python benchmarks/real_data.py

# People who walk by a policy fitted to people, into docs/street.md; it reads recordings.
bench-street: $(VENV)/.dev
	$(BIN)/python -m benchmarks.street

# Reinforcement learning, by networks and tables, and cloning by the library imitation, which needs
# an older gymnasium and so an environment of its own; into docs/baselines.md. About 10 CPU minutes.
bench-rl: $(VENV)/.rl $(VENV)/.bench $(VENV)-imitation/.installed
	$(BIN)/python -m benchmarks.rl --imitation $(VENV)-imitation/bin/python

# The paper's tables measured here, into docs/paper.md.
paper: $(VENV)/.dev
	$(BIN)/python -m benchmarks.paper

# Where the paper's plain state is enough, into docs/reproduction.md; about 10 minutes.
bench-reproduction: $(VENV)/.dev
	$(BIN)/python -m benchmarks.reproduction

# Kills, loads, hours and animators against a real studio, into docs/reliability.md; ONLY=kills for
# one part. How soon a pose follows a key (ONLY=response) and whether a stage keeps its step beside
# a job (ONLY=fitting) want a machine that does nothing else.
soak: $(VENV)/.dev chromium
	$(BIN)/python -m benchmarks.soak $(if $(ONLY),--only $(ONLY))

# The screenshots in the docs, made by the browser tests.
pictures: $(VENV)/.dev chromium
	EVASTUDIO_PICTURES=docs/images $(BIN)/python -m pytest tests/browser/test_flight.py \
	  tests/browser/test_crowd.py tests/browser/test_comparing.py tests/browser/test_takes.py \
	  tests/browser/test_tour.py tests/browser/test_sharing.py tests/browser/test_conflicts.py \
	  tests/browser/test_looks.py

# The newest versions that go together, into constraints.txt.
lock:
	rm -rf $(VENV)-lock
	$(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/python -m pip install -q --upgrade pip
	$(VENV)-lock/bin/python -m pip install -q -e '.[dev,bench,rl]'
	head -n 1 constraints.txt > constraints.new
	$(VENV)-lock/bin/python -m pip freeze --exclude-editable --exclude torch \
	  >> constraints.new
	mv constraints.new constraints.txt
	rm -rf $(VENV)-lock

# Whether any of them has a known weakness; asks the registry, before every release.
audit: $(VENV)-audit/.installed
	$(VENV)-audit/bin/pip-audit --strict --no-deps --disable-pip -r constraints.txt

$(VENV)-audit/.installed:
	$(PYTHON) -m venv $(VENV)-audit
	$(VENV)-audit/bin/python -m pip install -q pip-audit
	touch $@

# Debian's package where it can be installed, else Playwright's own.
chromium: $(VENV)/.dev
	@command -v chromium >/dev/null 2>&1 \
	  || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 \
	       && apt-get update -q && apt-get install -y -q chromium; } \
	  || $(BIN)/python -m playwright install chromium

# The server that tests start for themselves; the service Debian would start is not wanted.
postgres:
	@ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || command -v initdb >/dev/null 2>&1 \
	  || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -q \
	       && apt-get install -y -q --no-install-recommends postgresql-common \
	       && sed -i 's/^#*create_main_cluster.*/create_main_cluster = false/' \
	            /etc/postgresql-common/createcluster.conf \
	       && apt-get install -y -q --no-install-recommends postgresql; } \
	  || { echo "The tests need PostgreSQL 13 or newer: install it, with initdb on the path." >&2; \
	       exit 1; }

# The proxy that a test puts in front of the studio; the service Debian would start is not wanted.
nginx:
	@PATH="$$PATH:/usr/sbin" command -v nginx >/dev/null 2>&1 \
	  || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1 && apt-get update -q \
	       && apt-get install -y -q --no-install-recommends nginx-light; } \
	  || { echo "The tests need nginx: install it." >&2; exit 1; }

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install -q --upgrade pip

$(VENV)/.installed: $(VENV)/bin/python pyproject.toml
	$(BIN)/python -m pip install -q -e .
	touch $@

$(VENV)/.dev: $(VENV)/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install -q $(LOCK) -e '.[dev]'
	touch $@ $(VENV)/.installed

$(VENV)/.bench: $(VENV)/.dev
	$(BIN)/python -m pip install -q $(LOCK) -e '.[bench]'
	touch $@

# Practice by reward; PyTorch's own version is in pyproject.toml.
$(VENV)/.rl: $(VENV)/.dev
	$(BIN)/python -m pip install -q $(LOCK) -e '.[rl]' \
	  || { echo "PyTorch's build for the processor alone is needed: docs/baselines.md says how pip" \
	       "is told where it is." >&2; exit 1; }
	touch $@

$(VENV)-imitation/.installed:
	$(PYTHON) -m venv $(VENV)-imitation
	$(VENV)-imitation/bin/python -m pip install -q imitation==1.0.1 \
	  'torch==2.13.0+cpu; sys_platform == "linux"'
	touch $@

clean:
	rm -rf $(VENV) $(VENV)-imitation $(VENV)-audit build dist .mypy_cache .ruff_cache .pytest_cache
