# `make` lists the targets. `make peen` and `make test` do all set-up themselves on a bare Debian 12.
SCENE    ?= al2024-s390
RUN      ?=
ACCURACY ?=
# Debian's interpreter, not whatever `python3` the shell finds first: the wheels and YADE's Python are then one version.
PYTHON   ?= /usr/bin/python3

# g++, libfreefem++-dev: ff-c++ for the kernels. libsuitesparse-dev: CHOLMOD, the contact model's one factorisation;
# libopenblas-dev: its dense blocks, ten times slower with Debian's reference BLAS (which kernels: glue/solvers/blas.py). libegl1, libgl1, libxrender1: pyvista draws off-screen and aborts without.
PACKAGES := yade freefem++ libfreefem++ libfreefem++-dev g++ libsuitesparse-dev libopenblas-dev python3-venv libegl1 libgl1 libxrender1
BIN      := .venv/bin
YADE_CHECKS := $(filter-out rows,$(basename $(notdir $(wildcard yade_scripts/checks/*.py))))
STAMP    := .venv/.ready
SUDO     := $(shell [ "$$(id -u)" = 0 ] || echo sudo)

export OMP_NUM_THREADS ?= 1

.DEFAULT_GOAL := help
.PHONY: help setup peen test test-all tools plugin doctor checks bench-dimple bench-flow bench-target bench-oblique bench-presets bench-uncertainty bench-target-error bench-intensity tradeoff fit-collisions fit-layers extremes thresholds check-report readme bench-design bench-dilute bench-trends slurm-up slurm-down check-cluster bench-sweep studies

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

setup: $(STAMP) ## install what is missing: Debian packages (apt) and the virtual environment .venv

# Old package lists answer most installs; they are fetched anew only when they do not.
$(STAMP): pyproject.toml Makefile
	@missing=; for p in $(PACKAGES); do \
	  dpkg-query -W -f '$${db:Status-Status}' $$p 2>/dev/null | grep -qx installed || missing="$$missing $$p"; done; \
	if [ -n "$$missing" ]; then \
	  echo "installing:$$missing" >&2; \
	  install="$(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends$$missing"; \
	  $$install || { $(SUDO) apt-get update -q && $$install; }; \
	fi
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "$(PYTHON) is older than 3.11: make setup PYTHON=...")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -q -e '.[test]'
	@touch $@

peen: plugin ## the main job: run a scene from nozzle to metrics [SCENE=al2024-s390 RUN=folder ACCURACY=fast|balanced|reference]
	$(BIN)/peen run "$(SCENE)" $(if $(RUN),--out "$(RUN)") $(if $(ACCURACY),--accuracy "$(ACCURACY)")

# A missing solver is a failure here, never a skip.  On all cores; a file's tests stay together, they share what they solved.
test: plugin ## all tests, those that run YADE and FreeFem++ included
	PEEN_REQUIRE_SOLVERS=1 $(BIN)/python -m pytest -n auto --dist loadfile

test-all: plugin tools test ## make test, and what needs CalculiX and headless Chromium (installed when missing)
tools: setup
	@command -v ccx >/dev/null && command -v chromium >/dev/null && command -v chromedriver >/dev/null || { \
	  install="$(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends calculix-ccx chromium chromium-driver"; \
	  $$install >&2 || { $(SUDO) apt-get update -q >&2 && $$install >&2; }; }
	@$(BIN)/python -c 'import selenium' 2>/dev/null || $(BIN)/python -m pip install -q -e '.[browser]'
test-all: export PEEN_REQUIRE_TOOLS := 1

plugin: setup ## compile the FreeFEM kernels into build/plugin (skipped when up to date)
	@$(BIN)/python -c 'from glue.solvers import build_plugin; print("kernels:", build_plugin())'

doctor: setup ## versions; do the plugins load, do both solvers answer
	@$(BIN)/peen doctor

# YADE leaves a temporary folder per run: it gets one that goes with it.
checks: plugin ## exact checks of both codes: restitution, Hertz, time step, conservation; Hill sphere, uniaxial cycle
	@mkdir -p build/checks; status=0; scratch=$$(mktemp -d); \
	for check in $(YADE_CHECKS); do \
	  TMPDIR=$$scratch yade -n -x -j1 yade_scripts/checks/$$check.py --json build/checks/$$check.json </dev/null || status=1; \
	done; rm -rf $$scratch; \
	$(BIN)/python freefem/checks/run.py --json build/checks/freefem.json || status=1; exit $$status

bench-dimple: plugin ## the single impact against finer meshes, CalculiX (installed when missing), extremes; times (10 minutes) [DIMPLE=--only NAME]
	@command -v ccx >/dev/null || $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends calculix-ccx >&2 || true
	$(BIN)/python tests/benchmarks/bench_dimple.py $(DIMPLE)

bench-flow: plugin ## speed and agreement of the flow models, side by side with LIGGGHTS (10 minutes) [FLOW=--only NAME, --quick]
	$(BIN)/python tests/benchmarks/bench_flow.py $(FLOW)

fit-collisions: plugin ## collisions per shot: fit them to event-driven runs again, measure the error on other scenes
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/collision_fit.py --json build/bench/collision_fit.json

bench-target: plugin ## contact block, periodic cell, layers and stamp against each other; cost, saving, laws (half an hour) [TARGET=--only NAME]
	$(BIN)/python tests/benchmarks/bench_target.py $(TARGET)
fit-layers: plugin ## the layer model: fit it to periodic cells, judge it on others (15 minutes; cells are kept in build/bench/layers)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/layers_fit.py --json build/bench/layers_fit.json

tradeoff: plugin ## what every choice costs and how far off it is, on four scenes (an hour); goes on where it was stopped [TRADE=al2024-s390, --only GROUP]
	@# nproc follows OMP_NUM_THREADS
	$(BIN)/peen tradeoff --jobs $$(env -u OMP_NUM_THREADS nproc) $(TRADE)
	cp build/tradeoff/measured.json glue/study/tradeoff/measured.json

bench-presets: plugin ## seconds that presets fast and balanced take on the built-in scenes, warm dimples, no figures (15 minutes)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_presets.py --json build/bench/presets.json

bench-uncertainty: plugin ## stated 95 % intervals against other seeds' results, mean width (10 minutes)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_uncertainty.py --json build/bench/uncertainty.json

bench-target-error: plugin ## error promised by peen run --target-error against what it is, on scenes not in the table (half an hour) [ERROR=15%]
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_target_error.py $(if $(ERROR),--error $(ERROR)) --json build/bench/target-error.json

bench-oblique: plugin ## oblique impacts in three dimensions against the rule for their dimples (10 minutes)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/oblique.py --json build/bench/oblique.json

bench-intensity: plugin ## Almen intensity: standards' numbers, round trips, a noisy machine, tables of thumb rules (10 minutes) [INTENSITY=--only NAME]
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_intensity.py --json build/bench/intensity.json $(INTENSITY)

check-report: plugin tools ## the reports of a run and of a study in headless Chromium (installed when missing): console, slider, figures, widths, paper
	$(BIN)/python tests/report/browser_check.py --json build/report/check.json
bench-design: plugin ## a design, and its proposal re-run at balanced with fresh seeds (20 minutes; goes on where it was)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_design.py --json build/bench/design.json

bench-dilute: setup ## coverage in the dilute limit against Avrami, mean and scatter of 1000 seeds (20 minutes)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_dilute.py --json build/bench/dilute.json

bench-trends: plugin ## how t98 and the dimple go with mass flow, angle, diameter and speed; collisions against Avrami (5 minutes)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_trends.py --json build/bench/trends.json

extremes: plugin ## the stability map: 500 cells far past normal use, each right, refused with the range, or red (half an hour; goes on where it was)
	@mkdir -p build/extremes
	$(BIN)/python tests/extremes/run.py --json build/extremes/rows.json --cells build/extremes/map.json --picture docs/stability_map.png

thresholds: plugin ## optional physics: each piece swept off and on over its number; what the examples leave out changes nothing (5 minutes)
	@mkdir -p build/bench; status=0; \
	$(BIN)/python tests/benchmarks/thresholds.py --json build/bench/thresholds.json || status=1; \
	$(BIN)/python tests/benchmarks/left_out.py --json build/bench/left_out.json || status=1; exit $$status

slurm-up: ## start a real SLURM of one node (installed when missing); all it writes is in build/slurm
	@tests/cluster/slurm.sh up

slurm-down: ## stop it
	@tests/cluster/slurm.sh down

CLUSTER = $(BIN)/python -c 'import snakemake, snakemake_executor_plugin_slurm' 2>/dev/null || $(BIN)/python -m pip install -q -e '.[cluster]'

check-cluster: plugin slurm-up ## one small study by local workers, Snakemake, and Snakemake with SLURM: the same table (5 minutes)
	@$(CLUSTER)
	@mkdir -p build/bench; status=0; \
	$(BIN)/python tests/cluster/check_cluster.py --json build/bench/cluster.json || status=1; \
	tests/cluster/slurm.sh down; exit $$status

bench-sweep: plugin ## the study of 200 runs, killed in the middle and gone on with; the same through Snakemake (half an hour) [SWEEP=--runs 12]
	@$(CLUSTER)
	@mkdir -p build/bench
	$(BIN)/python tests/benchmarks/bench_sweep.py --json build/bench/sweep.json $(SWEEP)

STUDIES := coverage-mass-flow coverage-speed coverage-diameter coverage-angle coverage-feed stress-coverage stress-speed stress-diameter stress-shots

studies: plugin ## the shipped studies: tables, figures, summary, trends, into build/studies (4 minutes; goes on where it was stopped)
	@mkdir -p build/bench
	for study in $(STUDIES); do $(BIN)/peen sweep $$study --out build/studies/$$study >/dev/null || exit; done
	$(BIN)/python -m glue.report.study_figures build/studies --docs docs/studies.png
	$(BIN)/python tests/benchmarks/bench_studies.py --json build/bench/studies.json

README_RUNS := $(addprefix build/readme/,fast balanced reference)
$(README_RUNS): build/readme/%: plugin
	PEEN_CACHE=build/readme/cache-$* $(BIN)/peen run al2024-s390 --accuracy $* --out $@ >/dev/null

# A benchmark's miss is shown in the table, it does not keep the table from being written.
readme: checks $(README_RUNS) ## measure again what README.md shows: the default run at three presets, checks, benchmarks (some hours)
	-$(MAKE) bench-flow
	-$(MAKE) bench-dimple
	-$(MAKE) bench-target
	-$(MAKE) bench-intensity
	-$(MAKE) bench-target-error
	-$(MAKE) bench-sweep
	-$(MAKE) check-cluster
	-$(MAKE) studies
	-$(MAKE) bench-design
	-$(MAKE) bench-dilute
	-$(MAKE) bench-trends
	$(BIN)/python -m glue.report.readme $(README_RUNS)
