# Everything that a fresh machine needs to run and test the project: Rust, Python 3.11, make and a C compiler.

PYTHON ?= $(shell command -v python3.11 || command -v python3)
GRID ?= 648x108
SCENE ?= fsi3-$(GRID)
RESULTS ?= results/fsi3-$(GRID)
FMI ?= 2
ARGS ?=

VENV := .venv
RUN := $(VENV)/bin/python
READY := $(VENV)/.ready
READY_DEV := $(VENV)/.ready-dev
NERVURE := $(VENV)/bin/nervure
TYPES := python/nervure/scene/types.py
RUST_STUDIES := --locked --manifest-path studies/rust/Cargo.toml

# A shell that forbids bytecode would let each of some hundred starts of Python compile all that it imports.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help fsi3 told cylinder cylinder-2d1 animation run units build test style rust-test rust-lint lint studies-lint python-test coverage package-check doc deny bindings-check schema messages descriptions record lock clean

help: ## show this list
	@sed -n 's/^\([a-z0-9-]*\):.*## \(.*\)/\1\t\2/p' $(MAKEFILE_LIST) | expand -t 18

fsi3: SCENE := fsi3-$(GRID)
fsi3: THREADS := --set fluid.threads=2
fsi3: told run ## run the benchmark FSI3 into results/fsi3-GRID; GRID=648x108 (default, trimmed), 324x54, 1296x216, or the whole box on 325x72, 650x144, 1300x288

told:
	@sed -n 's/^ *"description": "\(.*\)",$$/$(SCENE): \1/p' scenes/$(SCENE).json 2>/dev/null || true

comma := ,
# The step of a scene in proportion to the cell: the same CFL number on each grid.
step = $(shell $(PYTHON) -c 'import json; scene = json.load(open("scenes/$(1).json")); \
	print("%g" % (scene["time"]["communication_step"] * scene["fluid"]["box"]["cells"][0] / $(firstword $(subst x, ,$(GRID)))))' 2>/dev/null)
on_grid = --set fluid.box.cells=[$(subst x,$(comma),$(GRID))] --set name=$(2)-$(GRID) \
	$(foreach key,time.communication_step fluid.time_stepping.max_step,$(addprefix --set $(key)=,$(call step,$(1))))

cylinder: GRID := 900x180
cylinder: build $(READY) ## run the cylinder 2D-2 into results/cylinder-2d2-GRID; GRID=900x180 (default) or another, with a step in proportion
	$(NERVURE) run cylinder-2d2-900x180 $(call on_grid,cylinder-2d2-900x180,cylinder-2d2) $(ARGS)

cylinder-2d1: GRID := 450x90
cylinder-2d1: build $(READY) ## run the cylinder 2D-1, the steady flow at Re 20, in the same way
	$(NERVURE) run cylinder-2d1-450x90 $(call on_grid,cylinder-2d1-450x90,cylinder-2d1) $(ARGS)

animation: $(READY) ## make vorticity.gif and phases.png of RESULTS=results/NAME; without fields there, run SCENE into it first
	@ls $(RESULTS)/*.vtkhdf >/dev/null 2>&1 || $(MAKE) run ARGS="--fields-every 0.01 --output $(RESULTS) $(ARGS)"
	$(NERVURE) animate $(RESULTS)

run: ## run SCENE=scenes/NAME.json; more options in ARGS="--end-time 1 --set key=value"
	@$(MAKE) --no-print-directory build & $(MAKE) --no-print-directory $(READY); ready=$$?; wait $$! && exit $$ready
	$(NERVURE) run $(SCENE) $(THREADS) $(ARGS)

units: $(READY) ## pack the FMUs of SCENE=scenes/NAME.json into results/NAME
	$(NERVURE) build $(SCENE)

build: ## build the libraries of the units
	cargo build --release --locked

test: ## build and run all tests: those in Rust beside the set-up of Python, then pytest
	@$(MAKE) $(READY_DEV) & $(MAKE) build rust-test; rust=$$?; wait $$! && exit $$rust
	$(MAKE) python-test

style: rust-lint lint ## check style, types and layers of all code

# In the release profile, and the tool apart: so the tests share what the build made, with its features.
TOOL := nervure-cargo-fmu
LAB := nervure-lab
RUST_TEST := cargo test --release --locked

rust-test: ## run the tests in Rust, but those of the lab
	$(RUST_TEST) --workspace --exclude $(TOOL) --exclude $(LAB)
	$(RUST_TEST) -p $(TOOL)

# Not in the release profile: so it need not wait for the build.
rust-lint: ## check style and types of the code in Rust
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings

studies-lint: ## check the Rust code of the studies
	cargo clippy $(RUST_STUDIES) --bins --examples -- -D warnings

LINTED := python examples lab scripts site studies tests modelDescription hatch_build.py

lint: $(READY_DEV) ## check style, types and layers of the Python code
	$(RUN) -m ruff check $(LINTED)
	$(RUN) -m ruff format --check $(LINTED)
	$(RUN) -m mypy
	$(VENV)/bin/lint-imports

python-test: build $(READY_DEV) ## run the Python tests in three processes, of which some wait
	$(RUN) -m pytest --numprocesses 3 --dist loadfile

COVERAGE_VENV := target/coverage/venv

coverage: build $(COVERAGE_VENV)/.ready ## measure which lines of the Python package the tests run
	$(COVERAGE_VENV)/bin/coverage run -m pytest --numprocesses 3 --dist loadfile
	$(COVERAGE_VENV)/bin/coverage combine --quiet
	$(COVERAGE_VENV)/bin/coverage report --skip-covered

$(COVERAGE_VENV)/.ready: requirements/dev.lock requirements/coverage.lock
	$(PYTHON) -m venv --clear $(COVERAGE_VENV)
	$(COVERAGE_VENV)/bin/python $(LOCKED) requirements/dev.lock -r requirements/coverage.lock
	$(COVERAGE_VENV)/bin/python $(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	touch $@

package-check: ## package every crate as for a registry and build the packages (two minutes)
	cargo package --workspace --exclude nervure-lab --allow-dirty --locked --target-dir target/package-check

doc: ## build the reference of all crates, without warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked

deny: ## check licences, bans and sources of all crates; needs cargo-deny
	for manifest in Cargo.toml studies/rust/Cargo.toml; do \
	cargo deny --locked --manifest-path $$manifest check licenses bans sources || exit; done

bindings-check: $(READY_DEV) ## compare crates/fmi-export/src/sys.rs with the official headers
	LIBCLANG_PATH=$$($(RUN) -c "import clang.native; print(*clang.native.__path__)") \
	cargo run --quiet $(RUST_STUDIES) -p fmi-bindgen --target-dir target/bindgen -- --check \
	"$$($(RUN) -c "import fmpy; print(*fmpy.__path__)")/c-code" crates/fmi-export/src/sys.rs

schema: ## write modelDescription/scene.schema.json and the Python classes of scenes
	cargo run --quiet --release --locked -p nervure-scene --example schema > modelDescription/scene.schema.json.new
	mv modelDescription/scene.schema.json.new modelDescription/scene.schema.json
	$(MAKE) $(TYPES)

$(TYPES): modelDescription/scene.schema.json modelDescription/scene_types.py
	$(PYTHON) modelDescription/scene_types.py < modelDescription/scene.schema.json > $@.new
	mv $@.new $@

messages: build $(READY_DEV) ## record the messages about bad input in tests/scene/messages.csv
	$(RUN) tests/scene/bad_input.py > tests/scene/messages.csv.new
	mv tests/scene/messages.csv.new tests/scene/messages.csv

descriptions: $(READY) ## write modelDescription/*.xml of the FSI3 pair
	$(NERVURE) build fsi3-325x72 --descriptions modelDescription

record: build $(READY_DEV) ## write recorded.json and wing.json of tests, only after an intended change of the physics
	$(RUN) -m tests.simulation.record
	$(RUN) lab/record_digits.py

COMPILE := pip-compile --quiet --generate-hashes --strip-extras --no-header --allow-unsafe --no-emit-index-url \
	--no-emit-trusted-host --no-emit-find-links

lock: ## pin the packages of pyproject.toml and requirements/*.in; needs pip-tools
	$(COMPILE) --build-deps-for wheel --extra run --extra sweep --extra verify --output-file requirements/run.lock pyproject.toml
	$(COMPILE) --build-deps-for wheel --extra dev --output-file requirements/dev.lock pyproject.toml
	for name in bench coverage masters dist peers site; do $(COMPILE) --output-file requirements/$$name.lock requirements/$$name.in || exit; done

clean: ## remove everything that was built; results stay
	cargo clean
	rm -rf $(VENV)

PIP = -m pip --quiet --disable-pip-version-check
# Python compiles what it imports, a small part of what is installed.
PIP_INSTALL = $(PIP) install --no-compile
LOCKED = $(PIP_INSTALL) --require-hashes -r

$(READY): requirements/run.lock pyproject.toml | $(TYPES)
	$(PYTHON) -m venv --clear $(VENV)
	$(RUN) $(LOCKED) requirements/run.lock
	$(RUN) $(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	touch $@

$(READY_DEV): requirements/dev.lock $(READY)
	$(RUN) $(LOCKED) requirements/dev.lock
	touch $@

STUDY := $(RUN) -m studies

.PHONY: studies study bench-rod turek-hron shown-rows

studies: $(READY_DEV) ## write the tables of results.json into the documents; ARGS="--stale" lists results older than the code
	$(STUDY) $(ARGS)

shown-rows: build $(READY_DEV) ## run the stale cases that README shows
	$(STUDY) --shown README.md $(ARGS)

study: build $(READY_DEV) ## run the missing cases of a study, NAME=rod, fluid, fsi3, …; ARGS="--list", "--only 'grid/*'"
	$(STUDY) $(NAME) $(ARGS)

bench-rod: $(READY_DEV) ## time a Newton iteration of the rod and its linear solver, beside faer
	$(STUDY) rod --force --update-timings --only 'study/r*' $(ARGS)

turek-hron: GRID := 324x54
turek-hron: build $(READY_DEV) ## run the missing cases of CSM1-3, CFD1-3 and FSI1-3; GRID=324x54 (default, a minute), 648x108 or 1296x216
	$(STUDY) turek-hron --only 'csm?/*'
	$(STUDY) turek-hron --only '*/$(GRID)' $(ARGS)

BENCH_VENV := target/fluid-bench/venv

.PHONY: bench-fluid

WITH_FFTW = FFTW_LIBRARY="$$(echo $(BENCH_VENV)/lib/python*/site-packages/pyfftw.libs/libfftw3-*)"

bench-fluid: $(BENCH_VENV)/.ready $(READY_DEV) ## compare the speed of the fluid with FFTW and with the machine, by phase and by threads
	$(WITH_FFTW) $(STUDY) fluid-speed --force --update-timings $(ARGS)

$(BENCH_VENV)/.ready: requirements/bench.lock
	$(PYTHON) -m venv --clear $(BENCH_VENV)
	$(BENCH_VENV)/bin/python $(LOCKED) requirements/bench.lock
	touch $@

.PHONY: reliability masters-test

reliability: build $(READY_DEV) ## mistreat the units, a quarter of an hour; ARGS="--list", "--only 'check/forks*'"
	$(STUDY) reliability --force $(ARGS)

MASTERS_VENV := target/masters/venv

masters-test: dist-libraries $(MASTERS_VENV)/.ready ## run the units of `make dist` in libcosim, Ecos, fmpy, a container FMU and the crate fmi
	LIBCLANG_PATH=$$($(MASTERS_VENV)/bin/python -c "import clang.native; print(*clang.native.__path__)") \
	BINDGEN_EXTRA_CLANG_ARGS="-I$$(cc -print-file-name=include)" \
	cargo build --quiet $(RUST_STUDIES) -p fmi-master --target-dir target/masters/fmi
	NERVURE_LIBRARIES=$(DIST_LIBRARIES) $(MASTERS_VENV)/bin/python -m pytest tests/masters

$(MASTERS_VENV)/.ready: requirements/dev.lock requirements/masters.lock
	$(PYTHON) -m venv --clear $(MASTERS_VENV)
	$(MASTERS_VENV)/bin/python $(LOCKED) requirements/dev.lock -r requirements/masters.lock
	touch $@

.PHONY: lab lab-rust-test lab-test

PAGE := target/lab/index.html
AXE := target/axe/package/axe.min.js
BROWSERS := wasm32-unknown-unknown

lab: ## build the lab, a page that simulates in the browser, as the file PAGE=target/lab/index.html; needs rustup
	[ -d "$$(rustc --print target-libdir --target $(BROWSERS))" ] || rustup target add $(BROWSERS)
	$(PYTHON) lab/make_lab.py $(PAGE) $(HOME_OF_LAB)

lab-rust-test: ## test the lab as a program; with the features of the build, so that only the lab is compiled
	$(RUST_TEST) --workspace --exclude $(TOOL) --test digits --test pictures

lab-test: lab lab-rust-test $(AXE) $(READY_DEV) ## test the lab, as a program and in Chromium
	$(RUN) -m pytest tests/lab/test_lab.py

# Without npm the tests of accessibility are left out.
$(AXE):
	mkdir -p target/axe
	cd target/axe && npm pack --silent axe-core@4.14.1 | xargs tar xzf || echo "axe-core was not fetched"

.PHONY: site gallery gallery-space

SITE_VENV := target/site/venv

site: $(READY_DEV) $(SITE_VENV)/.ready ## build the site with its generated reference into target/site/html
	$(RUN) site/make_pages.py target/site/pages
	$(MAKE) lab PAGE=target/site/pages/lab/index.html HOME_OF_LAB="--home ../index.html"
	$(SITE_VENV)/bin/python site/equations.py target/site/pages
	cp site/mkdocs.yml target/site
	$(SITE_VENV)/bin/zensical build --strict --config-file target/site/mkdocs.yml

$(SITE_VENV)/.ready: requirements/site.lock
	$(PYTHON) -m venv --clear $(SITE_VENV)
	$(SITE_VENV)/bin/python $(LOCKED) requirements/site.lock
	touch $@

MOVING := vein-forward-288x144 vein-hover-216x192 vein-hover-tapered-288x256 vein-pitching-320x240 vein-3d csm1 csm3 \
	vein-pair-hover-256x288 vein-pair-forward-288x192 filament-swimming-144x48

gallery: build $(READY_DEV) ## run the scripts of the gallery and make its pictures in docs/pictures (some minutes)
	$(RUN) site/gallery.py
	for name in $(MOVING); do $(NERVURE) run $$name --fields-every 0.04 --output results/gallery/$$name --force --quiet || exit; done
	$(NERVURE) run cylinder-oscillating-460x100 --fields-every 0.1 --force --quiet \
	--output results/gallery/cylinder-oscillating-460x100
	$(NERVURE) run cylinder-2d1-450x90 --end-time 5 --fields-every 0.12 --force --quiet \
	--output results/gallery/cylinder-2d1-450x90
	$(NERVURE) run cylinder-2d2-900x180 --set fluid.box.cells=[450,90] --fields-every 0.015 --force --quiet \
	--output results/gallery/cylinder-2d2-450x90
	$(NERVURE) run cfd3-650x144 --set fluid.box.cells=[325,72] --fields-every 0.01 --force --quiet \
	--output results/gallery/cfd3-325x72
	$(NERVURE) run cylinder-settling-140x392 --fields-every 0.02 --force --quiet --output results/gallery/cylinder-settling-140x392
	$(NERVURE) run sphere-settling-80x80x120 --fields-every 0.08 --force --quiet --output results/gallery/sphere-settling-80x80x120
	$(NERVURE) run examples/drafting-disks.json --fields-every 0.01 --force --quiet --output results/gallery/drafting-disks
	for folder in results/gallery/*; do $(NERVURE) animate $$folder && $(RUN) site/small_gif.py $$folder docs/pictures || exit; done
	$(NERVURE) run examples/plate-falling.json --fields-every 0.02 --output results/plate-falling --force --quiet
	$(NERVURE) animate results/plate-falling --begin 0.2 --end 1.2 --crop=-0.035,0.035,-0.17,0
	$(RUN) site/small_gif.py results/plate-falling docs/pictures

gallery-space: build $(READY_DEV) ## make the pictures of wing, flyer and plate in docs/pictures; needs pyvista
	$(NERVURE) build wing-hover-64x64x84 --output results/space/units
	$(NERVURE) run wing-hover-64x64x84 --fields-every 0.25 --output results/space/wing --force --quiet
	$(NERVURE) animate results/space/wing --begin 10 --end 20
	cp results/space/wing/motion.gif docs/pictures/wing-hover.gif
	cp results/space/wing/vortices.gif docs/pictures/wing-hover-vortices.gif
	$(NERVURE) run examples/flyer-pid.json --drive examples/flyer_pid.py --fields-every 0.00025 --output results/space/flyer --force --quiet
	$(NERVURE) animate results/space/flyer --begin 0.045 --end 0.05
	cp results/space/flyer/vortices.gif docs/pictures/flyer-vortices.gif
	$(NERVURE) run examples/flyer-pid.json --drive examples/flyer_climb.py --fields-every 0.00025 --output results/space/climb --force --quiet \
	--set "description=A flyer that climbs under flyer_climb.py."
	$(NERVURE) animate results/space/climb --begin 0.02
	cp results/space/climb/motion.gif docs/pictures/flyer-climb.gif
	$(NERVURE) run plate-stream-96x72x72 --end-time 12 --fields-every 0.25 --output results/space/plate --force --quiet
	$(NERVURE) animate results/space/plate --begin 3 --end 12
	cp results/space/plate/vortices.gif docs/pictures/plate-stream.gif

.PHONY: dist dist-libraries wheel wheel-told foreign-test

DIST_TARGETS := x86_64-unknown-linux-gnu aarch64-unknown-linux-gnu x86_64-pc-windows-gnu x86_64-apple-darwin aarch64-apple-darwin
DIST_BUILDS := $(addsuffix .2.17,$(wordlist 1,2,$(DIST_TARGETS))) $(word 3,$(DIST_TARGETS))
DIST_UNITS := nervure-fmu-rod nervure-fmu-wing nervure-fmu-body nervure-fmu-fluid nervure-fmu-contact
UNIVERSAL := universal2-apple-darwin
DIST_LIBRARIES := $(CURDIR)/target/dist/$(firstword $(DIST_TARGETS))/release
DIST_VENV := target/dist/venv
CARGO_FOLDER = $(or $(CARGO_HOME),$(HOME)/.cargo)
ZIGBUILD = PATH="$(abspath $(DIST_VENV))/bin:$$PATH" RUSTFLAGS="--remap-path-prefix=$(CURDIR)=nervure \
	--remap-path-prefix=$(CARGO_FOLDER)=cargo" CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_STRIP=symbols \
	cargo zigbuild --release --locked --config 'profile.release.package.nervure-scene.opt-level="s"' # half as large

dist-libraries: $(DIST_VENV)/.ready ## build the libraries for Linux (glibc 2.17), Windows and macOS; needs rustup
	rustup target add $(DIST_TARGETS)
	for target in $(DIST_BUILDS); do $(ZIGBUILD) $(addprefix --package ,$(DIST_UNITS)) --target $$target \
	--target-dir target/dist || exit; done
# Each unit in a call of its own: from several, cargo-zigbuild joins the Intel part of one to the ARM part of another.
	for unit in $(DIST_UNITS); do $(ZIGBUILD) --package $$unit --target $(UNIVERSAL) --target-dir target/dist || exit; done

dist: dist-libraries $(READY) ## pack FMUs and SSP of SCENE=scenes/NAME.json for all systems, with checksums and manifest, into dist/; FMI=3
	NERVURE_LIBRARIES=$(DIST_LIBRARIES) $(NERVURE) dist $(SCENE) dist --fmi $(FMI)

wheel: wheel-told dist-libraries $(READY) ## make a wheel for each of these systems and the source archive in target/wheel; needs rustup
	for target in $(wordlist 1,3,$(DIST_TARGETS)) $(UNIVERSAL); do \
	NERVURE_LIBRARIES=$(CURDIR)/target/dist/$$target/release $(RUN) $(PIP) wheel --no-deps --no-build-isolation \
	--wheel-dir target/wheel . || exit; done
	$(RUN) -m hatchling build --target sdist --directory target/wheel
	@ls -1 $(CURDIR)/target/wheel/*.whl $(CURDIR)/target/wheel/*.tar.gz

wheel-told:
	@echo "wheels go into target/wheel; the units are built for five systems, which takes five times as long as make build"

foreign-test: dist $(READY_DEV) ## run dist/ under wine and qemu, and check the libraries for macOS; needs wine, qemu-user and libc6-arm64-cross
	for target in $(wordlist 1,3,$(DIST_TARGETS)); do \
	$(ZIGBUILD) --manifest-path studies/rust/Cargo.toml -p foreign-master --target-dir target/foreign --target $$target || exit; done
	cd target/foreign/$(word 3,$(DIST_TARGETS))/release && $(abspath $(DIST_VENV))/bin/python -m ziglang cc \
	-target x86_64-windows-gnu -shared -O2 -o bcryptprimitives.dll $(CURDIR)/tests/foreign/bcryptprimitives.c -ladvapi32
	$(RUN) -m pytest tests/foreign

$(DIST_VENV)/.ready: requirements/dist.lock
	$(PYTHON) -m venv --clear $(DIST_VENV)
	$(DIST_VENV)/bin/python $(LOCKED) requirements/dist.lock
	touch $@

.PHONY: fuzz

fuzz: build $(READY_DEV) ## fuzz scene files and states of the units, 90 s each; needs nightly and cargo-fuzz
	$(STUDY) reliability --force --only 'fuzz/*' $(ARGS)

.PHONY: sanitizers

SANITIZERS := $(RUST_STUDIES) -p sanitizers --profile sanitizers --bins --target-dir target/sanitizers

sanitizers: $(READY_DEV) ## call the units under AddressSanitizer and valgrind; needs nightly and valgrind
	RUSTFLAGS=-Zsanitizer=address cargo +nightly build $(SANITIZERS)/asan --target x86_64-unknown-linux-gnu
	cargo build $(SANITIZERS)/plain
	$(RUN) -m pytest tests/sanitizers

.PHONY: report report-full report-pictures

PEERS_VENV := target/report/venv
report: build $(READY_DEV) $(PEERS_VENV)/.ready ## measure the short form of the report (ten minutes on a free machine)
	$(STUDY) report leave-out --force $(ARGS)

# All but lab and reliability, which have commands of their own.
STUDIES := fluid-speed rod contact fluid fluid-measures fsi3 coupling driven-bar turek-hron vein flapping thin slit \
	slip two-grids fine-box grid-pairs grid-far grid-cost space settling flight wing coverage bars scenes running gym \
	report leave-out
report-full: build $(READY_DEV) $(PEERS_VENV)/.ready $(BENCH_VENV)/.ready ## run the stale or missing cases of every study, long cases included, and draw all figures; hours of one core
	$(WITH_FFTW) $(STUDY) $(STUDIES) --full $(ARGS)
	$(MAKE) ARGS= report-pictures

report-pictures: build $(READY_DEV) ## animate the vorticity of FSI3 over a period, in docs/pictures/fsi3.gif
	$(NERVURE) run fsi3-650x144 --output results/report-pictures --fields-every 0.005 --quiet
	$(NERVURE) animate results/report-pictures --begin 7.7222 --end 7.9044
	$(RUN) site/small_gif.py results/report-pictures docs/pictures/fsi3.gif

$(PEERS_VENV)/.ready: requirements/peers.lock
	$(PYTHON) -m venv --clear $(PEERS_VENV)
	$(PEERS_VENV)/bin/python $(LOCKED) requirements/peers.lock
	touch $@
