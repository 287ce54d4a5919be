# SPDX-License-Identifier: MIT
#
#   make                 the library and the examples, in build/
#   make help            this list
#   make deps            installs the packages that examples and tests need (Debian and Ubuntu; elsewhere it names them)
#   make test            builds and runs every test
#   make test-mutants    breaks rules of the paper's method, and of covers, one at a time, in copies of the sources
#                        (tests/mutants.txt), and shows that a test fails each time: minutes. MUTANTS="cover mailbox": those whose titles have such a word
#   make hunt            looks for a wrong answer in scenes and rays that nobody has seen: CASES of them, from the number FIRST
#                        on (if not given, the time in seconds)
#   make test-python     tests the Python package in bindings/python, and its types if pyright is installed
#   make test-bindings   tests the bindings of other languages whose tools are installed
#   make deps-bindings   installs those of these tools that Debian has: LuaJIT, LuaRocks, g++ and clang
#   make bindings-coverage  tests the bindings and writes the table in bindings/README.md of what they reach
#   make package-rust    packs a binding, with the library inside, in build/packages; also package-go, package-node,
#                        package-java, package-lua
#   make test-wheel      builds the Python package's source distribution and wheel, installs and tests them; pip fetches
#                        from PyPI
#   make test-trimesh    runs trimesh's own tests of rays through the drop-in for it: those of its source distribution, which pip
#                        fetches, or of a checkout, TRIMESH=folder
#   make deps-python     installs, in build/python, what tests and reference of the Python package use if it is there: Dask, trimesh
#                        with embreex, pytest, pdoc, pyright
#   make docs-python     a page for each class of the Python package, in build/docs-python
#   make demo            renders build/demo.png
#   make reproduce       the paper's tables on the procedural scenes, or on those of SCENES=folder VIEWS=cameras.json
#   make bench           measures speed, beside Embree 3 if `make deps-study` installed it: on procedural scenes, and on
#                        files with SCENES=folder VIEWS=cameras.json; BENCH='--threads 2' has options of build/bin/bench
#   make measure         docs/data, all of it, then charts and tables, on the same scenes and one machine: an hour or more;
#                        measure-NAME: docs/data/NAME.csv alone. It goes on after failures, and what was measured already
#                        on this machine and commit is not measured again (AGAIN=1: it is); docs/data/measured.csv tells
#                        the machine and commit
#   make charts          of these what charts show, and docs/*.png: charts-accuracy draws accuracy-* (speed against wrong
#                        decisions, stability, stages), charts-speed draws speed-* (beside Embree)
#   make data            and those of tables: data-reproduction (the paper), data-price (exactness), data-depth
#                        (kd-trees), data-python (the Python package: needs deps-python)
#   make sweep           compares the choices that tiles make with fixed ones, on the same scenes: docs/data/sweep.csv
#                        measure-costs compares trees by other settings of the builder, and says which is the fastest
#   make tables          writes the tables of README.md, docs/ and bindings/ from docs/data
#   make deps-study      installs what these need besides: Embree 3 to compare with, matplotlib to draw
#   make docs            a page for each function, and the rest of docs/, in build/docs/html; make deps-docs installs
#                        doxygen
#   make install         installs headers, libraries, a manual page and files for pkg-config and CMake in
#                        $(DESTDIR)$(PREFIX), without debugging information unless KEEP_DEBUG=1; make uninstall
#   make test-install    installs into build/, then builds and runs programs that use the installed files
#   make test-packaging  uses the sources from projects with CMake (FetchContent), Meson (a wrap) and vcpkg (a port), in
#                        fresh folders; make deps-packaging installs these tools, but for vcpkg
#   make check-abi       compares exported names, layouts and types with tests/abi; checks the size of the shared object
#                        and the libraries that it needs
#   make update-abi      writes tests/abi anew, after an intended change
#   make check-header    compiles mlrt.h alone, in every C and C++ of the compilers here
#   make check-layers    checks all includes in src: no circle, no arrow upward, each header compiles alone; no crowded struct
#   make check-lemmas    proves bounds of docs/accuracy.md, if Gappa is installed
#   make check-tables    compares tables, watched figures and charts of README.md, docs/ and bindings/ with docs/data, and tests
#                        the scripts that make them
#   make check-copies    runs three copies of the library in one process
#   make check-churn     makes and destroys 10,000 trees and pools under valgrind
#   make fuzz CC=clang SAN=address,undefined,fuzzer-no-link   fuzzes the loading of trees; FUZZ has options of libFuzzer
#   make amalgamation    the library as one mlrt.c and one mlrt.h, in build/amalgamation
#   make dist            the sources of the last commit, the amalgamation, and checksums of both, in build/dist
#   make test-amalgamation  compiles the amalgamation with gcc and clang: golden numbers, exported names, nothing fused
#   make test-cross      library and amalgamation for aarch64, 32-bit x86, s390x and Windows: the same golden numbers
#                        from emulators; make deps-cross installs compilers and emulators (Debian and Ubuntu), make
#                        deps-emulated those of aarch64 and 32-bit x86
#   make format          runs clang-format on every source file
#   make clean
#
# Settings: CC=clang, OPTIMIZE=-O0, SAN=address,undefined or SAN=thread (builds in build/san-...), WERROR=1, V=1,
# RENAME=game_, which names functions game_... in place of mlrt_... (builds in build/renamed-game_), SCALAR=1, which
# compiles the kernels in plain C that other processors have (builds in build/scalar), and GUESS=1, which drops
# exactness to measure its price (builds in build/guess).

PREFIX   ?= /usr/local
LIBDIR   ?= $(PREFIX)/lib
MANDIR   ?= $(PREFIX)/share/man
OPTIMIZE ?= -O2
SAN      ?=
RENAME   ?=
SCALAR   ?=
V        ?=
OBJCOPY  ?= objcopy

VERSION  := 0.1.0
SOVERSION := 0

empty :=
comma := ,
BUILD := build$(if $(SAN),/san-$(subst $(comma),-,$(SAN)))$(if $(GUESS),/guess)$(if $(SCALAR),/scalar)$(if $(RENAME),/renamed-$(RENAME))
TARGET := $(shell $(CC) -dumpmachine)
IS_X86 := $(filter x86_64% i386% i486% i586% i686%,$(TARGET))
Q := $(if $(V),,@)

CFLAGS   ?= -g
STANDARD := -std=c99 -pedantic -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wvla $(if $(WERROR),-Werror)
GUESS    ?=
EXACT    := $(if $(GUESS),-DMLRT_GUESS=1) $(if $(SCALAR),-DMLRT_SCALAR=1) -ffp-contract=off $(if $(filter i386% i486% i586% i686%,$(TARGET)),-msse2 -mfpmath=sse) \
            $(if $(filter s390x%,$(TARGET)),-fexcess-precision=fast)
SANITIZE := $(if $(SAN),-fsanitize=$(SAN) -fno-sanitize-recover=all -fno-omit-frame-pointer)
# Functions, jumps and loops that are not aligned: 18 kB less, 6 of them by functions, and no slower: of 44 ratios of kinds
# of rays the middle one is 1.01 for functions, of 20 1.01 for the others. No expressions computed ahead on paths that do
# not need them (-ftree-pre): 5 kB less, and of 44 ratios the middle one is 1.00. No common subexpressions of whole functions
# (-fgcse) and no invariants moved out of loops before registers are known (-ftree-loop-im): 5 kB less, and of 66 ratios
# the middle one is 1.00. clang does not know them all.
PLAIN    := -fno-align-functions -fno-align-jumps -fno-align-loops -fno-tree-pre -fno-gcse -fno-tree-loop-im
LAYOUT   := $(shell $(CC) -Werror $(PLAIN) -E -x c /dev/null >/dev/null 2>&1 && echo $(PLAIN))
# A message per thread (src/base/message.c) is found without a call of __tls_get_addr, which would need ld-linux, could
# allocate, and would end the process if it could not. Other processors do so anyway; clang does not know the flag.
TLS      := $(if $(IS_X86),$(shell $(CC) -Werror -mtls-dialect=gnu2 -fPIC -S -x c /dev/null -o /dev/null 2>/dev/null && echo -mtls-dialect=gnu2))
COMPILE  = $(CC) $(STANDARD) $(OPTIMIZE) $(LAYOUT) $(TLS) $(CFLAGS) $(EXACT) $(SANITIZE) $(if $(RENAME),-DMLRT_PREFIX=$(RENAME)) $(CPPFLAGS) -pthread -Iinclude -Isrc -MMD -MP
LINK     = $(CC) $(OPTIMIZE) $(CFLAGS) $(SANITIZE) $(LDFLAGS) -pthread

# One object of kernels per instruction set. Kernels in plain C exist only where there is neither SSE2 nor NEON (or with
# SCALAR=1), but their words are tested anywhere.
KERNELS     := $(if $(SCALAR),scalar,$(if $(IS_X86),sse avx2 avx512,$(if $(filter aarch64-% arm64-%,$(TARGET)),neon,scalar)))
ISAS        := scalar $(filter-out scalar,$(KERNELS))
ISA_FLAGS_avx2   := -mavx2 -mfma
ISA_FLAGS_avx512 := -mavx512f -mavx512dq -mfma
# On Windows gcc may leave the stack unaligned (bug 54412); with this flag, a recent assembler makes moves unaligned.
UNALIGNED := -Wa$(comma)-muse-unaligned-vector-move
ifneq ($(filter %-mingw32,$(TARGET)),)
ISA_FLAGS_avx2   += $(shell $(CC) $(UNALIGNED) -c -x c /dev/null -o /dev/null 2>/dev/null && echo $(UNALIGNED))
ISA_FLAGS_avx512 += $(filter -Wa%,$(ISA_FLAGS_avx2))
endif
SOURCES := $(wildcard src/*/*.c)
# The order is that of CMake and Meson (src/packaging), so that libraries are the same, byte for byte.
LIBRARY_OBJECTS := $(patsubst src/%.c,$(BUILD)/obj/%.o,$(filter-out src/isa/%,$(SOURCES))) \
                   $(KERNELS:%=$(BUILD)/obj/isa/%.o)

# Packages are looked up when they are needed, so that `make deps demo` works in one call.
pkg = $(shell pkg-config $(1) $(2) 2>/dev/null)
HAVE_PNG    = $(call pkg,--exists libpng && echo 1)
HAVE_ASSIMP = $(call pkg,--exists assimp && echo 1)
HAVE_CJSON  = $(call pkg,--exists libcjson && echo 1)
HAVE_GMP    = $(call pkg,--exists gmp && echo 1)
# tinybvh is a header of C++; make deps-study puts it there.
TINYBVH     ?= build/tinybvh
HAVE_TINYBVH = $(if $(wildcard $(TINYBVH)/tiny_bvh.h),$(and $(IS_X86),1))
HAVE_EMBREE = $(shell $(CC) $(CPPFLAGS) -fsyntax-only -include embree3/rtcore.h -x c /dev/null 2>/dev/null && echo 1)
EXAMPLE_COMMON := $(patsubst examples/%.c,$(BUILD)/examples/%.o,$(wildcard examples/common/*.c))
STUDY        = $(patsubst examples/%.c,$(BUILD)/examples/%.o,$(wildcard examples/study/*.c)) $(BUILD)/tests/reference.o \
               $(if $(HAVE_TINYBVH),$(BUILD)/examples/study/tinybvh-cpp.o)
ENGINE      := $(patsubst examples/%.c,$(BUILD)/examples/%.o,$(wildcard examples/engine/*.c))
BENCH_OBJECTS := $(patsubst examples/%.c,$(BUILD)/examples/%.o,$(wildcard examples/bench/*.c))
EXAMPLES    = $(filter-out $(if $(HAVE_PNG),,render) $(if $(HAVE_GMP),,accuracy) $(if $(and $(HAVE_GMP),$(HAVE_PNG)),,errors),$(basename $(notdir $(wildcard examples/*.c))))
EXAMPLE_FLAGS = $(if $(HAVE_ASSIMP),-DHAVE_ASSIMP=1 $(call pkg,--cflags,assimp)) $(if $(HAVE_PNG),-DHAVE_PNG=1 $(call pkg,--cflags,libpng)) \
                $(if $(HAVE_CJSON),-DHAVE_CJSON=1 $(call pkg,--cflags,libcjson))
EXAMPLE_LIBS  = $(if $(HAVE_ASSIMP),$(call pkg,--libs,assimp)) $(if $(HAVE_PNG),$(call pkg,--libs,libpng)) \
                $(if $(HAVE_CJSON),$(call pkg,--libs,libcjson)) -lm -ldl

TESTS := $(basename $(notdir $(wildcard tests/test_*.c)))
TEST_COMMON := $(patsubst tests/%.c,$(BUILD)/tests/%.o,$(filter-out tests/print_golden.c $(wildcard tests/test_*.c),$(wildcard tests/*.c)))

.PHONY: all library examples docs docs-python demo reproduce format clean
.PHONY: deps deps-study deps-docs deps-bindings deps-python
.PHONY: package-rust package-go package-node package-java package-lua bindings-coverage
.PHONY: test test-mutants test-python fuzz hunt test-bindings test-install check-abi update-abi check-header check-copies check-churn check-layers test-wheel test-trimesh
.PHONY: install install-strip uninstall
.PHONY: help test-packaging deps-packaging
.PHONY: bench charts charts-accuracy charts-speed data data-reproduction data-price data-depth data-python
.PHONY: tables check-tables check-lemmas sweep measure
.SECONDARY:

all: library examples

# The list at the head of this file.
help:
	@awk 'NR > 2 {if (!sub(/^#/, "")) exit; sub(/^   /, ""); sub(/^ /, ""); print}' $(firstword $(MAKEFILE_LIST))

library: $(BUILD)/libmlrt.a $(BUILD)/libmlrt.so

# ---- library -------------------------------------------------------------------------------------------------------

# Every object has the same OPTIMIZE; docs/tried.md, "Compiler flags", compares -O2 and -O3.
#
# The shared library leaves out functions that only tests call (--gc-sections). Assertions, which would abort the
# caller's program, are in builds with SAN only.
INSIDE := -fPIC -fvisibility=hidden -ffunction-sections $(if $(SAN),,-DNDEBUG)

$(BUILD)/obj/isa/%.o: src/isa/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(INSIDE) $(ISA_FLAGS_$*) -c $< -o $@

$(BUILD)/obj/%.o: src/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(INSIDE) -c $< -o $@

# For tests and studies, which call internal functions.
$(BUILD)/libmlrt-internal.a: $(LIBRARY_OBJECTS)
	$(Q)rm -f $@ && $(AR) rcs $@ $^

# For other programs: one object, whose internal names are hidden and clash with no others.
$(BUILD)/libmlrt.a: $(LIBRARY_OBJECTS)
	$(Q)sh src/packaging/hide_names.sh $@ $(AR) $(OBJCOPY) $^ -- $(CC) $(CFLAGS)

# Exports every function that is declared with MLRT_API, by its name after preprocessing, as version MLRT_0.
$(BUILD)/mlrt.map: include/mlrt.h
	@mkdir -p $(@D)
	$(Q){ echo 'MLRT_$(SOVERSION) {'; echo 'global:'; $(EXPORTED_NAMES) | sed 's/.*/    &;/'; echo 'local:'; echo '    *;'; echo '};'; } > $@

EXPORTED_NAMES = $(CC) -E -P $(if $(RENAME),-DMLRT_PREFIX=$(RENAME)) -DMLRT_API=MLRT_API include/mlrt.h | tr '\n;' ' \n' | \
                 sed -n 's/.*MLRT_API[^(]*[ *]\([A-Za-z0-9_]*\)(.*/\1/p' | LC_ALL=C sort

# noseparate-code: code and constants share pages, which saves 8 kB of padding. now, relro: addresses of functions are
# looked up on loading, and their table is read-only from then on. -Bsymbolic-functions: the library calls its own
# functions, whatever a program exports.
SHARED := -shared -Wl,--gc-sections -Wl,-z,noseparate-code -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack -Wl,-Bsymbolic-functions $(if $(SAN),,-Wl,-z,defs)

$(BUILD)/libmlrt.so.$(VERSION): $(LIBRARY_OBJECTS) $(BUILD)/mlrt.map
	$(Q)$(LINK) $(SHARED) -Wl,-soname,libmlrt.so.$(SOVERSION) -Wl,--version-script=$(BUILD)/mlrt.map $(LIBRARY_OBJECTS) -lm -o $@

$(BUILD)/libmlrt.so: $(BUILD)/libmlrt.so.$(VERSION)
	$(Q)ln -sf libmlrt.so.$(VERSION) $(BUILD)/libmlrt.so.$(SOVERSION) && ln -sf libmlrt.so.$(SOVERSION) $@

# ---- examples ------------------------------------------------------------------------------------------------------

examples: $(addprefix $(BUILD)/bin/,$(EXAMPLES))
	$(if $(HAVE_PNG),,@echo "examples: no libpng, so no 'render': make deps installs it")
	$(if $(HAVE_GMP),,@echo "examples: no GMP, so no 'accuracy': make deps installs it")

$(BUILD)/examples/study/%.o: examples/study/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(EXAMPLE_FLAGS) $(if $(HAVE_EMBREE),-DHAVE_EMBREE=1) $(if $(HAVE_TINYBVH),-DHAVE_TINYBVH=1) -Iexamples -Itests -c $< -o $@

# As its makers compile it.
$(BUILD)/examples/study/tinybvh-cpp.o: examples/study/tinybvh.cpp
	@mkdir -p $(@D)
	$(Q)$(CXX) -std=c++20 -O3 -mavx2 -mfma -w -I$(TINYBVH) -Iexamples/study -c $< -o $@

# The benchmark's own code, the same for every library it measures, is compiled for this machine.
NATIVE = $(if $(filter -O2 -O3,$(OPTIMIZE)),$(shell $(CC) -march=native -E -x c /dev/null >/dev/null 2>&1 && echo -march=native)) -fno-math-errno -fno-trapping-math

$(BUILD)/examples/bench/%.o: examples/bench/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(EXAMPLE_FLAGS) $(NATIVE) $(if $(HAVE_EMBREE),-DHAVE_EMBREE=1) -Iexamples -c $< -o $@

$(BUILD)/examples/%.o: examples/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(EXAMPLE_FLAGS) -Iexamples -c $< -o $@

$(BUILD)/bin/%: $(BUILD)/examples/%.o $(EXAMPLE_COMMON) $(BUILD)/libmlrt.a
	@mkdir -p $(@D)
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) -o $@

$(BUILD)/bin/accuracy $(BUILD)/bin/errors: $(BUILD)/bin/%: $(BUILD)/examples/%.o $(STUDY) $(EXAMPLE_COMMON) $(BUILD)/libmlrt-internal.a
	@mkdir -p $(@D)
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) $(if $(HAVE_EMBREE),-lembree3) $(if $(HAVE_TINYBVH),-lstdc++) -lgmp -o $@

$(BUILD)/bin/depth $(BUILD)/bin/pays: $(BUILD)/bin/%: $(BUILD)/examples/%.o $(BUILD)/examples/study/meshes.o $(EXAMPLE_COMMON) $(BUILD)/libmlrt.a
	@mkdir -p $(@D)
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) -o $@

$(BUILD)/bin/engine: $(BUILD)/examples/engine.o $(ENGINE) $(EXAMPLE_COMMON) $(BUILD)/libmlrt.a
	@mkdir -p $(@D)
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) -o $@

PEER_FRAME := $(patsubst %,$(BUILD)/examples/bench/%.o,peer_frame embree task shade crew library) $(BUILD)/examples/study/meshes.o
$(BUILD)/bin/reproduce: $(BUILD)/examples/reproduce.o $(PEER_FRAME) $(EXAMPLE_COMMON) $(BUILD)/libmlrt.a
	@mkdir -p $(@D)
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) $(if $(HAVE_EMBREE),-lembree3) -o $@

# Linked with the shared object, since Embree and the library of another commit (--against) are shared objects too.
$(BUILD)/bin/bench: $(BUILD)/examples/bench.o $(BENCH_OBJECTS) $(BUILD)/examples/study/meshes.o $(EXAMPLE_COMMON) $(BUILD)/libmlrt.so
	@mkdir -p $(@D)
	$(Q)$(LINK) $(filter %.o,$^) -L$(BUILD) -lmlrt -Wl,-rpath,'$$ORIGIN/..' $(EXAMPLE_LIBS) $(if $(HAVE_EMBREE),-lembree3) -o $@

# ---- dependencies --------------------------------------------------------------------------------------------------

APT_PACKAGES := gcc libc6-dev pkg-config libpng-dev libcmocka-dev libgmp-dev libassimp-dev libcjson-dev
MISSING = $(strip $(foreach p,$(APT_PACKAGES),$(if $(filter installed,$(shell dpkg-query -W -f='$${db:Status-Status}' $(p) 2>/dev/null)),,$(p))))
SUDO = $(if $(filter 0,$(shell id -u)),,sudo)
# Not empty: the lists of packages are fresh, so they are not fetched again.
APT_UPDATED ?=

deps:
	@if ! command -v apt-get >/dev/null; then \
	    echo "Please install: a C compiler, pkg-config, and the development files of libpng, cmocka, GMP and (optional, to"; \
	    echo "read mesh files and files of views) assimp and cJSON. The library itself needs none of them."; exit 1; \
	elif [ -n "$(MISSING)" ]; then \
	    echo "installing: $(MISSING)"; \
	    $(if $(APT_UPDATED),,$(SUDO) apt-get update -qq &&) $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(MISSING) >/dev/null; \
	fi

deps-study: deps
	@$(MAKE) --no-print-directory deps APT_PACKAGES='libembree-dev python3-matplotlib g++'
	@sh examples/study/fetch_tinybvh.sh $(TINYBVH)

deps-docs:
	@command -v apt-get >/dev/null || { echo "Please install doxygen (1.9.3 or later) and python3."; exit 1; }
	@$(MAKE) --no-print-directory deps APT_PACKAGES='doxygen python3'

# Everything that the tests and the reference of bindings/python can use, in an environment of its own.
deps-python:
	@python3 -m venv $(BUILD)/python 2>/dev/null || { echo "deps-python: no python3 with venv (apt-get install python3-venv)"; exit 1; }
	@$(BUILD)/python/bin/python -m pip --disable-pip-version-check install -q numpy tqdm 'dask[array]' distributed \
	    trimesh embreex pytest scipy networkx rtree shapely manifold3d pdoc pyright

deps-bindings: deps
	@$(MAKE) --no-print-directory deps APT_PACKAGES='g++ clang luajit luarocks'

EMULATED_PACKAGES := gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-i686-linux-gnu libc6-dev-i386-cross qemu-user clang

deps-emulated:
	@$(MAKE) --no-print-directory deps APT_PACKAGES='$(EMULATED_PACKAGES)'

deps-cross:
	@$(MAKE) --no-print-directory deps \
	    APT_PACKAGES='$(EMULATED_PACKAGES) gcc-s390x-linux-gnu libc6-dev-s390x-cross gcc-mingw-w64-x86-64 wine64'

deps-packaging:
	@$(MAKE) --no-print-directory deps APT_PACKAGES='gcc g++ libc6-dev pkg-config cmake ninja-build meson git'

# `make deps test` must look for packages after deps has run: a second make does the work.
AFTER_DEPS := $(filter deps deps-%,$(MAKECMDGOALS))

# ---- demo ----------------------------------------------------------------------------------------------------------

demo: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory $(BUILD)/bin/render
	$(BUILD)/bin/render --scene office --shadows --stats -o $(BUILD)/demo.png

# ---- reproduction of the paper's tables -----------------------------------------------------------------------------

PAPER_SCENES := erw6 conference_mgf cruiser_mgf dragon_x9
SCENE_FILES = $(if $(SCENES),$(or $(wildcard $(PAPER_SCENES:%=$(SCENES)/%.ply)),$(error $(SCENES): none of $(PAPER_SCENES:%=%.ply))))

# Only tables go to standard output: make reproduce > tables.md
reproduce: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory $(BUILD)/bin/reproduce >&2
	@$(BUILD)/bin/reproduce $(addprefix --scene ,$(SCENE_FILES)) $(addprefix --views ,$(VIEWS))

# ---- data of charts and tables --------------------------------------------------------------------------------------

# measure-NAME writes docs/data/NAME.csv by the command DATA_NAME, and what it was measured on to docs/data/measured.csv; files
# of this machine and commit stay (examples/common/measure.sh). `make measure` goes through all, the most important first, and
# on after failures. The scenes are the procedural ones, and those of SCENES. Numbers of rays are per generator and scene, and
# per value of a sweep. RUNS: of each contender in turns; LIVES: of the libraries that bench-avx512, bench-avx2 and price compare.
STUDY_RAYS ?= 131072
SWEEP_RAYS ?= 8192
RUNS ?= 3
LIVES ?= 4
BENCH ?=
PYTHON ?= $(firstword $(foreach p,python3 /usr/bin/python3,$(shell $(p) -c 'import matplotlib' 2>/dev/null && echo $(p))) python3)
OF_SCENES = $(addprefix --scene ,$(1) $(if $(SCENES),$(wildcard $(2:%=$(SCENES)/%.ply)))) $(addprefix --views ,$(VIEWS))

PAPER_FILES := erw6 conference_mgf
BENCH_FILES := erw6 conference_mgf sponza_dabrovic clinic_bim cruiser_mgf dragon
STUDY_ALL = $(call OF_SCENES,room office building scan sphere,$(PAPER_FILES))
BENCH_ALL = $(call OF_SCENES,$(if $(SCENES),doubled,room office building doubled scan sphere),$(BENCH_FILES))
PAPER_ALL = $(addprefix --scene ,$(SCENE_FILES)) $(addprefix --views ,$(VIEWS))
PAPER_ROOMS = $(call OF_SCENES,$(if $(SCENES),,room office),$(PAPER_FILES))
IN_LIVES = python3 examples/bench/lives.py --lives $(LIVES) $(BUILD)/bin/bench --csv
PAPER_TILES = --its 128 --mts 8 --sf 16

# The library without exactness, for what exactness costs.
GUESSING := build/guess/libmlrt.so
ifeq ($(GUESS),)
$(GUESSING): $(wildcard src/*/*.[ch]) include/mlrt.h
	@$(MAKE) --no-print-directory GUESS=1 $@
endif
ACCURACY = $(BUILD)/bin/accuracy --csv --guess $(GUESSING)

DATA_bench-avx512 = $(IN_LIVES) --isa avx512 --runs $(RUNS) $(BENCH_ALL) $(BENCH)
DATA_bench-avx2 = $(IN_LIVES) --isa avx2 --peer-isa avx2 --runs $(RUNS) $(BENCH_ALL) $(BENCH)
DATA_bench-calls = $(BUILD)/bin/bench --study calls --alone --runs 7 $(call OF_SCENES,$(if $(SCENES),,room),erw6) $(BENCH)
DATA_bench-build-1 = $(BUILD)/bin/bench --study build --threads 1 --runs $(RUNS) $(BENCH_ALL) $(BENCH)
DATA_bench-build-2 = $(BUILD)/bin/bench --study build --threads 2 --runs $(RUNS) $(BENCH_ALL) $(BENCH)
DATA_bench-triangles = $(BUILD)/bin/bench --study triangles --isa avx512 --runs $(RUNS) $(BENCH)
DATA_bench-resolution = $(BUILD)/bin/bench --study resolution --isa avx512 --runs $(RUNS) --scene room,office,building,scan $(BENCH)
DATA_costs = $(PYTHON) examples/bench/sweep.py --trees --rounds $(RUNS) $(call OF_SCENES,$(if $(SCENES),,room office),erw6 conference_mgf sponza_dabrovic clinic_bim cruiser_mgf dragon office_mgf)
DATA_methods = $(ACCURACY) $(STUDY_ALL) --generator camera,edge --rays $(STUDY_RAYS) --runs $(RUNS)
DATA_stability = $(ACCURACY) --study stability --rays $(SWEEP_RAYS)
DATA_stages = $(ACCURACY) --study stages $(STUDY_ALL) --generator camera,random,edge --rays $(STUDY_RAYS)
DATA_errors = $(BUILD)/bin/errors --guess $(GUESSING) -o docs/errors.png
DATA_pays = $(BUILD)/bin/pays --csv --largest 9 && $(BUILD)/bin/pays --csv --scene room,doubled,office,building | tail -n +2
DATA_price = $(IN_LIVES) --alone --against $(GUESSING) --runs $(RUNS) $(call OF_SCENES,room office building scan sphere doubled,$(PAPER_FILES))
DATA_price-guess = $(BUILD)/bin/price --csv --guess $(GUESSING) --runs 5 $(call OF_SCENES,room office building scan,$(PAPER_FILES) clinic_bim cruiser_mgf dragon)
DATA_price-worst = $(BUILD)/bin/price --csv --worst --runs 5 $(call OF_SCENES,building,$(PAPER_FILES) dragon lost_empire)
DATA_depth-small = $(BUILD)/bin/depth --csv
DATA_depth-limits = $(BUILD)/bin/depth --csv --runs $(RUNS) $(call OF_SCENES,building,$(PAPER_FILES) dragon cruiser_mgf)
DATA_steps-forms = $(BUILD)/bin/steps --study forms --runs 9 $(PAPER_ROOMS)
DATA_steps-parts = $(BUILD)/bin/steps --study parts $(call OF_SCENES,$(if $(SCENES),,room office),$(PAPER_FILES) sponza_dabrovic)
DATA_steps-views = $(BUILD)/bin/steps --study views $(PAPER_ROOMS)
DATA_reproduce-1 = $(BUILD)/bin/reproduce $(PAPER_ALL) $(PAPER_TILES) --only 1
DATA_reproduce-2 = $(BUILD)/bin/reproduce $(PAPER_ROOMS) $(PAPER_TILES) --only 2,3,4 --runs $(RUNS)
DATA_mutants = python3 tests/mutants.py --csv $(BUILD)/mutants
DATA_reproduce-5 = $(BUILD)/bin/reproduce $(PAPER_ROOMS) --only 5,6,7
PYTHON_BENCH = PYTHONPATH=bindings/python $(TEST_PYTHON) bindings/python/bench.py --csv $(BUILD)/bench.py.csv --only $(1) >&2 && cat $(BUILD)/bench.py.csv
PYTHON_SCENES = $(call OF_SCENES,,erw6 conference_mgf dragon)
DATA_python-arrays = $(call PYTHON_BENCH,arrays $(PYTHON_SCENES) --rounds 5)
DATA_python-trimesh = $(call PYTHON_BENCH,trimesh $(PYTHON_SCENES) --rounds 5)
DATA_python-calls = $(call PYTHON_BENCH,calls)
DATA_python-distributed = $(call PYTHON_BENCH,distributed)
DATA_sweep = $(PYTHON) examples/bench/sweep.py $(call OF_SCENES,$(if $(SCENES),,room office building scan),$(PAPER_FILES) sponza_dabrovic cruiser_mgf dragon)

SPEED_DATA := bench-avx512 bench-avx2 bench-calls bench-build-1 bench-build-2 bench-triangles bench-resolution
ACCURACY_DATA := methods errors price pays stages stability
PAPER_DATA := steps-forms reproduce-5 reproduce-1 reproduce-2 steps-views steps-parts
PRICE_DATA := price-guess price-worst
DEPTH_DATA := depth-small depth-limits
PYTHON_DATA := python-arrays python-trimesh python-calls python-distributed
ALL_DATA := $(SPEED_DATA) $(PAPER_DATA) $(ACCURACY_DATA) $(PRICE_DATA) $(DEPTH_DATA) $(PYTHON_DATA) costs sweep mutants

measure-methods measure-stability measure-stages measure-errors measure-price measure-price-guess: $(GUESSING)
measure-%:
	@mkdir -p docs/data
	@sh examples/common/measure.sh docs/data/$*.$(if $(filter reproduce-%,$*),md,csv) '$(DATA_$*)'

# Programs are built once, before any is timed; then each file by itself, one after the other.
MEASURING = accuracy bench depth errors pays price reproduce steps
measure_each = @failed=; for one in $(1); do $(MAKE) --no-print-directory measure-$$one || failed="$$failed $$one"; done; \
               [ -z "$$failed" ] || { echo "measure: failed:$$failed" >&2; exit 1; }

programs-to-measure: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory -k $(MEASURING:%=$(BUILD)/bin/%) $(BUILD)/libmlrt.so $(GUESSING) >&2

# Charts and tables are drawn even if some data could not be measured: then from those that were there.
measure: programs-to-measure
	@rc=0; $(MAKE) --no-print-directory measure-all || rc=1; $(MAKE) --no-print-directory draw tables || rc=1; exit $$rc
measure-all:
	$(call measure_each,$(ALL_DATA))

draw:
	$(PYTHON) examples/common/stamp.py docs/errors.png docs/data/errors.csv
	$(PYTHON) examples/study/charts.py docs/data docs
	$(PYTHON) examples/bench/charts.py docs/data docs

charts: charts-accuracy charts-speed
charts-accuracy: programs-to-measure
	$(call measure_each,$(ACCURACY_DATA))
	@$(MAKE) --no-print-directory draw
charts-speed: programs-to-measure
	$(call measure_each,$(SPEED_DATA) costs)
	@$(MAKE) --no-print-directory draw

data: data-reproduction data-price data-depth data-python
data-reproduction: programs-to-measure
	$(call measure_each,$(PAPER_DATA))
data-price: programs-to-measure
	$(call measure_each,$(PRICE_DATA))
data-depth: programs-to-measure
	$(call measure_each,$(DEPTH_DATA))
data-python: library
	$(call measure_each,$(PYTHON_DATA))
sweep: programs-to-measure
	$(call measure_each,sweep)

bench: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory $(BUILD)/bin/bench >&2
	@$(BUILD)/bin/bench $(BENCH_ALL) $(BENCH)

# Documents whose tables are made from docs/data, and charts that are drawn from it; the other pictures are renderings.
DOCUMENTS := README.md $(wildcard docs/*.md bindings/*.md bindings/*/README.md)
CHARTS := $(filter-out docs/office.png docs/engine.png docs/map-tests.png,$(wildcard docs/*.png))
tables:
	@$(PYTHON) examples/common/tables.py docs/data $(DOCUMENTS) $(CHARTS)
check-tables:
	@$(PYTHON) examples/common/tables.py --check docs/data $(DOCUMENTS) $(CHARTS)
	@sh tests/tables.sh $(PYTHON) $(BUILD)/tables
	@$(PYTHON) tests/check_lives.py examples/bench/lives.py
	@$(PYTHON) examples/bench/sweep.py --check

# ---- tests ---------------------------------------------------------------------------------------------------------

$(BUILD)/tests/%.o: tests/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(EXAMPLE_FLAGS) -Iexamples -Itests -c $< -o $@

$(BUILD)/tests/words/%.o: tests/words/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(ISA_FLAGS_$*) -c $< -o $@

$(BUILD)/tests/test_simd: $(ISAS:%=$(BUILD)/tests/words/%.o)

$(BUILD)/tests/close/%.o: tests/close/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(ISA_FLAGS_$*) -c $< -o $@

$(BUILD)/tests/test_close_calls: $(ISAS:%=$(BUILD)/tests/close/%.o)

$(BUILD)/tests/read/%.o: tests/read/%.c
	@mkdir -p $(@D)
	$(Q)$(COMPILE) $(ISA_FLAGS_$*) -c $< -o $@

$(BUILD)/tests/test_packed_rays $(BUILD)/tests/test_read_arrays: $(patsubst %,$(BUILD)/tests/read/%.o,$(ISAS) readers)

$(BUILD)/tests/test_%: $(BUILD)/tests/test_%.o $(TEST_COMMON) $(EXAMPLE_COMMON) $(BUILD)/libmlrt-internal.a
	$(Q)$(LINK) $(WRAP) $^ $(EXAMPLE_LIBS) -lcmocka -lgmp -o $@

# Functions that the test replaces, to pretend what cannot be had everywhere.
$(BUILD)/tests/test_messages: private WRAP := $(patsubst %,-Wl$(comma)--wrap=%,pthread_create mlrt_select_kernels mlrt_build_binary)

# Arrays in all forms, and a tenth as many whole worlds (tests/worlds.h). A failure prints the command that repeats it.
CASES ?= 20000
FIRST ?= $(shell date +%s)

hunt: $(BUILD)/tests/test_bundles $(BUILD)/tests/test_stability
	$(BUILD)/tests/test_bundles $(CASES) $(FIRST)
	$(BUILD)/tests/test_stability --worlds $$(($(CASES) / 10)) $(FIRST)

# Fuzzes loading, from files that test_save writes, for as long as FUZZ says. Needs clang: see tests/fuzz_load.c.
FUZZ ?= -max_total_time=60

$(BUILD)/tests/fuzz_load: $(TEST_COMMON) $(EXAMPLE_COMMON) $(BUILD)/libmlrt-internal.a
	$(Q)$(LINK) -fsanitize=fuzzer $^ $(EXAMPLE_LIBS) -lcmocka -lgmp -o $@

fuzz: $(BUILD)/tests/fuzz_load $(BUILD)/tests/test_save
	@mkdir -p $(BUILD)/fuzz
	FUZZ_FILES=$(BUILD)/fuzz $(BUILD)/tests/test_save
	$(BUILD)/tests/fuzz_load $(FUZZ) -artifact_prefix=$(BUILD)/fuzz- $(BUILD)/fuzz

# The structs and constants of the header, as a list.
$(BUILD)/abi/interface.inc: include/mlrt.h tests/abi/interface.awk
	@mkdir -p $(@D)
	$(Q)$(CC) -E -P -dD include/mlrt.h | awk -f tests/abi/interface.awk > $@

$(BUILD)/tests/test_abi.o: $(BUILD)/abi/interface.inc
$(BUILD)/tests/test_abi.o: CPPFLAGS += -I$(BUILD)/abi

$(BUILD)/tests/test_churn: $(BUILD)/tests/test_churn.o $(BUILD)/libmlrt.a
	$(Q)$(LINK) $^ -lcmocka -lm -o $@

$(BUILD)/tests/test_copies: | $(BUILD)/libmlrt.so

# print_golden needs only the library and the procedural scenes: the same list as in tests/golden.sh.
GOLDEN_COMMON := $(patsubst %,$(BUILD)/examples/common/%.o,scene import ply_check file room office building doubled scan furniture shapes steady_math)
$(BUILD)/tests/print_golden: $(BUILD)/tests/print_golden.o $(BUILD)/tests/golden.o $(GOLDEN_COMMON) $(BUILD)/libmlrt.a
	$(Q)$(LINK) $^ $(EXAMPLE_LIBS) -o $@

# Two of the tests run the examples.
build-tests: $(addprefix $(BUILD)/tests/,$(TESTS)) $(if $(filter test_engine test_programs,$(TESTS)),examples)

test: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory build-tests
	@BUILD=$(BUILD) CC="$(CC)" sh tests/run.sh $(addprefix $(BUILD)/tests/,$(TESTS))

MUTANTS ?=
test-mutants: | $(AFTER_DEPS)
	@python3 tests/mutants.py $(BUILD)/mutants $(MUTANTS)

check-abi update-abi: $(BUILD)/libmlrt.so $(BUILD)/abi/interface.inc
	@CC='$(CC)' sh tests/abi/check.sh $(if $(filter update-abi,$@),update) $(BUILD)/abi $(BUILD)/libmlrt.so

# The program exports all of its names (-rdynamic), so that a copy which looked outside itself would find another's.
COPIES := $(BUILD)/tests/copies
check-copies: library
	@$(MAKE) --no-print-directory RENAME=game_ $(BUILD)/renamed-game_/libmlrt.a
	@mkdir -p $(COPIES)
	$(Q)$(COMPILE) -DCOPY=plain_copy -c tests/copies/copy.c -o $(COPIES)/plain.o
	$(Q)$(COMPILE) -DCOPY=renamed_copy -DMLRT_PREFIX=game_ -c tests/copies/copy.c -o $(COPIES)/renamed.o
	$(Q)$(COMPILE) -c tests/copies/main.c -o $(COPIES)/main.o
	$(Q)$(LINK) -rdynamic $(COPIES)/*.o $(BUILD)/libmlrt.a $(BUILD)/renamed-game_/libmlrt.a -lm -ldl -o $(COPIES)/copies
	$(COPIES)/copies $(BUILD)/libmlrt.so

# A cycle takes some 5 ms under valgrind.
CHURN_CYCLES ?= 10000
check-churn: $(BUILD)/tests/test_churn
	@command -v valgrind >/dev/null || echo "check-churn: no valgrind: what malloc holds is looked at, not each block"
	CHURN_CYCLES=$(CHURN_CYCLES) $(if $(shell command -v valgrind),valgrind --leak-check=full --show-leak-kinds=all \
	    --errors-for-leak-kinds=all --error-exitcode=1) $(BUILD)/tests/test_churn

check-header:
	@CC='$(CC)' sh tests/check_header.sh

check-layers:
	@python3 tests/check_layers.py $(CC)

check-lemmas:
	@if ! command -v gappa >/dev/null; then echo "check-lemmas: no gappa: nothing proven"; \
	else for lemma in tests/lemmas/*.g; do gappa $$lemma || { echo "check-lemmas: $$lemma: not proven"; exit 1; }; done; \
	    echo "check-lemmas: all proven"; fi

# ---- one file, other machines --------------------------------------------------------------------------------------

.PHONY: amalgamation dist test-amalgamation test-cross deps-cross deps-emulated

ONE_FILE := $(BUILD)/amalgamation

amalgamation: $(ONE_FILE)/mlrt.c

$(ONE_FILE)/mlrt.c: src/amalgamate.py include/mlrt.h $(wildcard src/*/*.[ch])
	$(Q)python3 src/amalgamate.py $(@D)

DIST := $(BUILD)/dist
AMALGAMATED := mlrt-$(VERSION)-amalgamation

# The same bytes from the same commit.
dist: amalgamation
	$(Q)rm -rf $(DIST) && mkdir -p $(DIST)/$(AMALGAMATED)
	$(Q)git archive --prefix=mlrt-$(VERSION)/ HEAD | gzip -n9 >$(DIST)/mlrt-$(VERSION).tar.gz
	$(Q)cp $(ONE_FILE)/mlrt.c $(ONE_FILE)/mlrt.h LICENSE $(DIST)/$(AMALGAMATED)
	$(Q)tar -C $(DIST) -c --sort=name --owner=0 --group=0 --numeric-owner --mtime=@$$(git log -1 --format=%ct) $(AMALGAMATED) | \
	    gzip -n9 >$(DIST)/$(AMALGAMATED).tar.gz && rm -r $(DIST)/$(AMALGAMATED)
	$(Q)cd $(DIST) && sha256sum *.tar.gz >SHA256SUMS && cat SHA256SUMS

X86_32_FLAGS = $(if $(filter i386% i486% i586% i686%,$1),-msse2 -mfpmath=sse)

test-amalgamation: amalgamation
	@for cc in gcc clang; do \
	    if command -v $$cc >/dev/null; then sh tests/amalgamation.sh $(ONE_FILE) "" "" $$cc $(call X86_32_FLAGS,$(TARGET)) || exit 1; \
	    else echo "test-amalgamation: no $$cc: not tested"; fi; \
	done

CROSS := aarch64-linux-gnu i686-linux-gnu s390x-linux-gnu x86_64-w64-mingw32

test-cross: $(CROSS:%=test-cross-%)

# Programs are static, so that they need no library of the other machine to run.
test-cross-%: amalgamation
	@if ! command -v $*-gcc >/dev/null; then echo "test-cross, $*: no $*-gcc: not tested (make deps-cross installs it)"; \
	else $(MAKE) --no-print-directory CC=$*-gcc AR=$*-ar OBJCOPY=$*-objcopy BUILD=$(BUILD)/cross/$* CFLAGS= WERROR=1 EXAMPLE_FLAGS= \
	        EXAMPLE_LIBS='-lm -static' $(BUILD)/cross/$*/tests/print_golden && \
	    sh tests/cross.sh $* $(BUILD)/cross/$* $(ONE_FILE) $(call X86_32_FLAGS,$*); fi

# What deps-python installs, else whatever python3 has.
TEST_PYTHON = $(abspath $(firstword $(wildcard $(BUILD)/python/bin/python) $(shell command -v python3)))

test-python: library
	@if ! $(TEST_PYTHON) -c 'import numpy' 2>/dev/null; then echo "test-python: no python3 with numpy: nothing tested"; \
	else cd bindings/python/tests && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=.. $(TEST_PYTHON) -m unittest discover; fi
	@if ! $(TEST_PYTHON) -m pyright --version >/dev/null 2>&1; then \
	    echo "test-python: no pyright: types are not checked (make deps-python installs it)"; \
	else cd bindings/python && $(TEST_PYTHON) -m pyright --pythonpath $(TEST_PYTHON) mlrt bench.py setup.py; fi

test-bindings: | $(AFTER_DEPS)
	@$(MAKE) --no-print-directory library amalgamation
	@$(MAKE) --no-print-directory install PREFIX=$(abspath $(BUILD))/bindings/prefix LIBDIR=$(abspath $(BUILD))/bindings/prefix/lib DESTDIR= >/dev/null
	@CC='$(CC)' CXX='$(CXX)' VERSION=$(VERSION) sh bindings/test.sh $(BUILD)/bindings

bindings-coverage:
	@COVERAGE=write $(MAKE) --no-print-directory test-bindings

package-rust package-go package-node package-java package-lua: library amalgamation
	@CC='$(CC)' VERSION=$(VERSION) sh bindings/package.sh $(@:package-%=%) $(BUILD) $(BUILD)/packages

test-wheel:
	@sh bindings/python/tests/wheel.sh $(BUILD)/wheel

test-trimesh: library
	@sh bindings/python/tests/trimesh_own.sh "$(TEST_PYTHON)" $(BUILD)/trimesh $(TRIMESH)

# ---- reference -----------------------------------------------------------------------------------------------------

docs: | $(AFTER_DEPS)
	@command -v doxygen >/dev/null || { echo "docs: no doxygen: make deps-docs installs it"; exit 1; }
	@rm -rf build/docs && mkdir -p build/docs
	$(Q){ cat docs/doxygen/Doxyfile; echo PROJECT_NUMBER = $(VERSION); } | doxygen -
	@echo "docs: build/docs/html/index.html"

docs-python: library
	@$(TEST_PYTHON) -c 'import pdoc' 2>/dev/null || { echo "docs-python: no pdoc: make deps-python installs it"; exit 1; }
	$(Q)PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=bindings/python $(TEST_PYTHON) -W ignore::UserWarning -m pdoc -o $(BUILD)/docs-python \
	    mlrt mlrt.typing mlrt.trimesh $$($(TEST_PYTHON) -c 'import distributed; print("mlrt.distributed")' 2>/dev/null)
	@echo "docs-python: $(BUILD)/docs-python/index.html"

# ---- install -------------------------------------------------------------------------------------------------------

# If LIBDIR is below PREFIX, the files for pkg-config and CMake have paths relative to themselves, else absolute ones.
space := $(empty) $(empty)
LIB_BELOW  = $(patsubst $(PREFIX)/%,%,$(filter $(PREFIX)/%,$(LIBDIR)))
UP         = $(subst $(space),/,$(patsubst %,..,$(subst /, ,$(LIB_BELOW))))
FILL_IN    = sed -e 's|@VERSION@|$(VERSION)|g' -e 's|@SOVERSION@|$(SOVERSION)|g' \
             -e 's|@PC_PREFIX@|$(if $(LIB_BELOW),$${pcfiledir}/../$(UP),$(PREFIX))|' \
             -e 's|@PC_LIBDIR@|$(if $(LIB_BELOW),$${prefix}/$(LIB_BELOW),$(LIBDIR))|' \
             -e 's|@CMAKE_INCLUDE@|$(if $(LIB_BELOW),$${_mlrt_libdir}/$(UP),$(PREFIX))/include|' \
             -e "s|@POINTER_SIZE@|$$($(CC) -dM -E -x c /dev/null | sed -n 's/^.define __SIZEOF_POINTER__ //p')|"
INSTALLED_LIBRARIES := libmlrt.a libmlrt.so.$(VERSION) libmlrt.so.$(SOVERSION) libmlrt.so pkgconfig/mlrt.pc \
                       cmake/mlrt/mlrtConfig.cmake cmake/mlrt/mlrtConfigVersion.cmake

# install_library STRIP MODE FILE: a library of the build folder, without what objcopy's option STRIP removes.
install_library = install -m $(2) $(BUILD)/$(3) "$(DESTDIR)$(LIBDIR)/" $(if $(KEEP_DEBUG),,&& \
    { $(OBJCOPY) $(1) "$(DESTDIR)$(LIBDIR)/$(3)" || echo "install: $(OBJCOPY) did not strip $(3)"; })

install: library
	$(if $(GUESS),$(error GUESS=1 is for measuring only))
	install -d "$(DESTDIR)$(PREFIX)/include" "$(DESTDIR)$(LIBDIR)/pkgconfig" "$(DESTDIR)$(LIBDIR)/cmake/mlrt" "$(DESTDIR)$(MANDIR)/man3"
	install -m 644 include/mlrt.h bindings/cpp/mlrt.hpp "$(DESTDIR)$(PREFIX)/include/"
	$(call install_library,--strip-debug,644,libmlrt.a)
	$(call install_library,--strip-all,755,libmlrt.so.$(VERSION))
	ln -sf libmlrt.so.$(VERSION) "$(DESTDIR)$(LIBDIR)/libmlrt.so.$(SOVERSION)"
	ln -sf libmlrt.so.$(SOVERSION) "$(DESTDIR)$(LIBDIR)/libmlrt.so"
	$(FILL_IN) src/packaging/mlrt.pc.in > "$(DESTDIR)$(LIBDIR)/pkgconfig/mlrt.pc"
	$(FILL_IN) src/packaging/mlrtConfig.cmake.in > "$(DESTDIR)$(LIBDIR)/cmake/mlrt/mlrtConfig.cmake"
	$(FILL_IN) src/packaging/mlrtConfigVersion.cmake.in > "$(DESTDIR)$(LIBDIR)/cmake/mlrt/mlrtConfigVersion.cmake"
	awk -f src/packaging/man.awk include/mlrt.h > "$(DESTDIR)$(MANDIR)/man3/mlrt.3"

# The name that others use for what install does.
install-strip: install

uninstall:
	for file in $(INSTALLED_LIBRARIES); do rm -f "$(DESTDIR)$(LIBDIR)/$$file"; done
	rm -f "$(DESTDIR)$(PREFIX)/include/mlrt.h" "$(DESTDIR)$(PREFIX)/include/mlrt.hpp" "$(DESTDIR)$(MANDIR)/man3/mlrt.3"
	-rmdir "$(DESTDIR)$(LIBDIR)/cmake/mlrt"

test-install: library
	@CC='$(CC)' CXX='$(CXX)' MAKE='$(MAKE)' VERSION=$(VERSION) sh tests/consumer/check.sh $(BUILD)/install

test-packaging: library
	@CC='$(CC)' CXX='$(CXX)' sh tests/consumer/check_build.sh $(BUILD)/packaging $(BUILD)/libmlrt.so $(BUILD)/libmlrt.a

# ---- housekeeping --------------------------------------------------------------------------------------------------

format:
	clang-format -i include/*.h src/*/*.[ch] examples/*.c examples/common/*.[ch] examples/study/*.[ch] examples/bench/*.[ch] examples/engine/*.[ch] tests/*.[ch] tests/words/*.[ch] tests/close/*.[ch] bindings/c/*.[ch] bindings/cpp/*.[ch]pp \
	    tests/abi/*.[ch] tests/copies/*.[ch] tests/consumer/*.c tests/consumer/*.cpp

clean:
	rm -rf build

# Of this build alone: builds with other settings lie below build/ too, and may be running.
-include $(shell find $(BUILD)/obj $(BUILD)/examples $(BUILD)/tests -name copies -prune -o -name '*.d' -print 2>/dev/null)
