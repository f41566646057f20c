# Everything a reader or a contributor runs. `make` alone lists the targets.

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help

UV ?= $(shell command -v uv)# makes .venv if there, else pip does
PYTHON ?=# … with this Python; if empty, uv finds or fetches one, pip looks on the PATH
PROFILE ?= quick# or full: how much the chapters compute
JOBS ?= 2# processes at a time
PORT ?= 8000# of `make serve`
TWICE ?=# options of `make twice`, as --all
LAB ?=# options of `make lab`, as --no-browser
CHROMIUM ?= $(shell command -v chromium)# looks at the built book

VENV := .venv
BIN := $(VENV)/bin/python
STAMP := $(VENV)/installed
INDEX := _build/html/index.html
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1# a process: there are JOBS of them

# What JupyterLab writes into a notebook that is run and saved, besides its outputs.
LAB_KEYS := $(addprefix metadata.language_info.,codemirror_mode file_extension mimetype \
	nbconvert_exporter pygments_lexer version) $(addprefix metadata.,toc toc-autonumbering \
	toc-showcode toc-showmarkdowntxt toc-showtags vscode) $(addprefix cell.metadata., \
	editable jupyter slideshow trusted vscode)

quoted = '$(subst ','\'',$1)'# a path in a command, whatever it holds

.PHONY: help env book release pdf twice test test-browser test-slow lint serve lab hooks data results savings worlds bench lock clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' Makefile

env: $(STAMP) ## make .venv, exactly the lock; every other target does so when needed

book: $(STAMP) ## execute the chapters and build the book (PROFILE=quick, JOBS=2)
	@$(BIN) -m msc book --profile $(PROFILE) --jobs $(JOBS)

release: book ## pack the book as a zip that opens without a network
	@$(BIN) -m msc release

pdf: book ## print the book as one PDF; needs Chromium
	@$(BIN) -m msc pdf

twice: $(STAMP) ## build the book again elsewhere and compare all bytes
	@$(BIN) -m msc twice --profile $(PROFILE) --jobs $(JOBS) $(TWICE)

test: $(STAMP) ## run all tests but those in a browser and the slow ones
	@$(ONE_THREAD) $(BIN) -m pytest --numprocesses $(JOBS) \
		--dist loadfile --no-loadscope-reorder
	@echo "$(if $(CHROMIUM),Not run here:,There is no chromium on the PATH; left out:) \
	the tests of the built book in a browser (make book test-browser)."

test-browser: $(STAMP) ## look at the built book in Chromium: every page, slider, link
	@CHROMIUM=$(call quoted,$(CHROMIUM)) $(BIN) -m pytest --numprocesses $(JOBS) \
		--dist worksteal tests/browser

test-slow: $(STAMP) ## run what takes long: a hundred settings of chapters, all that is kept
	@$(ONE_THREAD) $(BIN) -m pytest --numprocesses $(JOBS) tests/slow

lint: $(STAMP) ## check style, types, docstrings, words, and that notebooks carry no outputs
	@$(BIN) -m ruff check
	@$(BIN) -m ruff format --check
	@$(BIN) -m mypy
	@$(BIN) -m numpydoc lint $$(find msc press -name "*.py")
	@find book -maxdepth 1 -name '*.ipynb' \
		-exec $(BIN) -m nbstripout --verify --extra-keys '$(LAB_KEYS)' {} +
	@$(BIN) -m press._prose book/*.md book/*.ipynb README.md CONTRIBUTING.md

serve: $(STAMP) ## show the built book on localhost (PORT=8000)
	@test -f $(INDEX) || $(MAKE) --no-print-directory book
	@echo "The book is at http://localhost:$(PORT) until Ctrl-C."
	@$(BIN) -m http.server $(PORT) --bind 127.0.0.1 --directory _build/html

lab: $(STAMP) ## open the repository in JupyterLab (LAB=--no-browser)
	@JUPYTER_PATH= JUPYTER_PREFER_ENV_PATH=1 $(BIN) -m jupyterlab \
		--ServerApp.root_dir=$(call quoted,$(CURDIR)) --LabApp.default_url=/lab/tree/book \
		--FileContentsManager.post_save_hook=press._lab.forget_size $(LAB)

hooks: $(STAMP) ## check every commit of this clone, and keep outputs out of notebooks
	@$(BIN) -m pre_commit install
	@$(BIN) -m nbstripout --install --python $(BIN)
	@git config filter.nbstripout.extrakeys '$(LAB_KEYS)'

data: $(STAMP) ## search every policy in data/ again, resuming where it stopped
	$(BIN) -m msc survey cut --jobs $(JOBS) --out data/results/cut.json
	$(BIN) -m msc survey layout --jobs $(JOBS) --out data/results/layout.json
	for world in free obstacles; do \
		$(BIN) -m msc search --workspace $$world --tasks 360 \
			--jobs $(JOBS) --out data/$$world.csv; \
		$(BIN) -m msc search --workspace $$world --tasks 120 --offset 1.5 \
			--guide data/$$world.csv --jobs $(JOBS) --out data/$${world}_test.csv; \
		$(BIN) -m msc audit data/$$world.csv --jobs $(JOBS) \
			--out data/results/audit_$$world.json; \
	done
	for picture in png gif; do \
		$(BIN) -m msc render --workspace obstacles --task 60 \
			--out book/_static/reach.$$picture; \
	done

results: $(STAMP) ## compare all methods again and judge the claims (takes its time)
	$(BIN) -m msc evaluate --profile full --jobs $(JOBS)
	$(BIN) -m msc claims --out data/results/claims.json --readme README.md

savings: $(STAMP) ## search from what methods predict, and from scratch (about an hour)
	$(BIN) -m msc savings --jobs $(JOBS)

worlds: $(STAMP) ## draw, search and study many worlds, resuming (ten core-hours and more)
	for step in make search jumps study bands moves engines judge; do \
		$(ONE_THREAD) $(BIN) -m msc worlds $$step --jobs $(JOBS); \
	done

bench: $(STAMP) ## measure the speed of each part against a reference, and of all methods
	@$(BIN) benchmarks/bench.py
	@$(BIN) benchmarks/methods.py

lock: $(STAMP) ## resolve requirements.in anew into requirements.txt
	@CUSTOM_COMPILE_COMMAND="make lock" $(BIN) -m piptools compile --quiet \
		--no-emit-index-url --no-emit-find-links --strip-extras \
		--allow-unsafe --generate-hashes requirements.in

clean: ## remove everything built, but not .venv
	@rm -rf _build .mypy_cache .pytest_cache .ruff_cache .hypothesis

# The environment: exactly the lock, made anew whenever the lock changes. The lock is
# complete, and what is imported is compiled then: pip need do neither.
NEEDED := 3.11# the newest that PyBullet supports
version = $(or $(shell $(call quoted,$1) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null),missing)
on_path = $(firstword $(foreach name,python$(NEEDED) python3,$(if $(filter $(NEEDED),$(call version,$(name))),$(name))))
python = $(or $(PYTHON),$(if $(UV),$(NEEDED),$(on_path)),python3)
found = $(if $(and $(UV),$(filter $(NEEDED),$(python))),$(NEEDED),$(call version,$(python)))
name_one = install Python $(NEEDED), or name it with make PYTHON=/path/to/python$(NEEDED)

$(STAMP): requirements.txt
	$(if $(filter $(NEEDED),$(found)),,$(error msc needs Python $(NEEDED), the newest that \
		PyBullet supports, but $(python) is $(found): $(if $(UV),leave it to uv,install uv), \
		which brings it, or $(name_one)))
	@echo "Making $(VENV) from requirements.txt with $(if $(UV),uv,pip (a few minutes, once))"
ifneq ($(UV),)
	@UV_VENV_CLEAR=1 $(call quoted,$(UV)) venv --python $(call quoted,$(python)) $(VENV) \
	|| { echo "uv brought no Python $(NEEDED): $(name_one)." >&2; exit 1; }
	@$(call quoted,$(UV)) pip install --python $(BIN) \
		--require-hashes -r requirements.txt
	@$(call quoted,$(UV)) pip install --python $(BIN) --no-deps --no-build-isolation \
		--editable .
else
	@$(call quoted,$(python)) -m venv --clear $(VENV) || { rm -rf $(VENV); exit 1; }
	@total=$$(grep -c '^[^ #]' requirements.txt); n=0; \
	{ PYTHONUNBUFFERED=1 $(BIN) -m pip install --require-hashes --no-deps \
		--no-compile -r requirements.txt 2>&1; } \
	| tee $(VENV)/pip.log | while read -r word rest; do case $$word in \
		Collecting|Processing) n=$$((n + 1)); \
			(( n % 30 )) || echo "  found $$n of $$total packages";; \
		Installing) echo "  installing $$total packages";; \
	esac; done || { grep -v ^WARNING $(VENV)/pip.log | tail -n 12 >&2; exit 1; }
	@$(BIN) -m pip install --quiet --no-deps --no-build-isolation --editable . \
		2>>$(VENV)/pip.log || { tail -n 12 $(VENV)/pip.log >&2; exit 1; }
endif
	@touch $(STAMP)
