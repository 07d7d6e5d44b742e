# make            build/frugal, and the image helper beside it
# make demo       install what is missing, build, render a picture
# make test       install what is missing, build, run the tests (some 4 minutes); TEST=part of a name runs fewer
# make lint       format, includes as the rooms allow, warnings as errors; WERROR=1: in the build that was made so
# make format     put the C, C++ and OpenCL C files into the project's format
# make sanitize   the tests under address, leak and undefined-behaviour checks; TEST= as above
# make oclgrind   the kernels under a simulator that watches each access; QUICK=1: a minute or two
# make fuzz       damaged files into the code that reads them, for FUZZ_SECONDS (60)
# make test-full  what takes longer: tests with larger counts, all of oclgrind, fuzz, comparison with other programs
# make bench      speed of rays beside Embree's, of raster beside Mesa's llvmpipe, each in the same run
# make install    to PREFIX (/usr/local), under DESTDIR: program, manual page, completion for bash; make uninstall
#
# BUILD=folder builds elsewhere. CC, CXX, CPPFLAGS, CFLAGS, CXXFLAGS, LDFLAGS: as usual. WERROR=1: warnings are errors.
BUILD ?= build
CC ?= cc
CXX ?= c++
CFLAGS ?= -O2 -g
CXXFLAGS ?= -O2 -g
PREFIX ?= /usr/local
WARNINGS := -Wall -Wextra -Wshadow -Wpointer-arith -Wvla -Wno-unused-parameter
FLAGS := -Ihost -Icl -Itests -D_GNU_SOURCE -DCL_TARGET_OPENCL_VERSION=120 $(WARNINGS) $(if $(WERROR),-Werror) -pthread

LIBRARY_C := $(filter-out host/app/main.c,$(wildcard host/*/*.c))
LIBRARY_CXX := $(wildcard host/scene/*.cpp)
HELPER_C := $(wildcard host/image/helper/*.c)
HELPER_CXX := $(wildcard host/image/helper/*.cpp)
KERNELS := $(sort $(wildcard cl/*/*.cl cl/*/*.h))
TESTS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/test_*.c))
BENCHES := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/bench/bench_*.c))
OCLGRIND_TESTS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/oclgrind/*.c))
FUZZERS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/fuzz/fuzz_*.c))
TEST_SUPPORT_C := $(wildcard tests/support/*.c)

objects = $(patsubst %,$(BUILD)/%.o,$(1))
LIBRARY_O := $(call objects,$(LIBRARY_C) $(LIBRARY_CXX)) $(BUILD)/kernels.o
HELPER_O := $(call objects,$(HELPER_C) $(HELPER_CXX)) $(call objects,host/base/log.c host/base/status.c)
TEST_SUPPORT_O := $(call objects,$(TEST_SUPPORT_C))
GL_PEER_O := $(call objects,tests/bench/gl_peer.c tests/bench/raster_peer.c)
BENCH_SCENE_O := $(call objects,tests/bench/scene.c tests/bench/raster_stages.c tests/bench/raster_views.c)
ALL_O := $(LIBRARY_O) $(HELPER_O) $(TEST_SUPPORT_O) $(BUILD)/host/app/main.c.o $(TESTS:=.c.o) $(BENCHES:=.c.o) \
  $(OCLGRIND_TESTS:=.c.o) $(FUZZERS:=.c.o) $(BUILD)/tests/fuzz/shrink_scene.c.o $(GL_PEER_O) $(BENCH_SCENE_O)

LIBS := -lOpenCL -ltinygltf -ljansson -lstdc++ -lm
HELPER_LIBS := -lOpenImageIO -lOpenImageIO_Util -lstdc++ -lm
EMBREE_LIB := $(if $(wildcard /usr/include/embree4/rtcore.h),-lembree4,-lembree3)

# A file that holds $(2), rewritten only when $(2) changes: what depends on it is made again then, and only then.
remember = $(if $(subst x$(2)x,,x$(file <$(1))x),$(shell mkdir -p $(BUILD))$(file >$(1),$(2)))
$(call remember,$(BUILD)/flags,$(CC) $(CXX) $(FLAGS) $(CPPFLAGS) $(CFLAGS) $(CXXFLAGS) $(LDFLAGS))
$(call remember,$(BUILD)/members,$(LIBRARY_O) $(TEST_SUPPORT_O))
$(call remember,$(BUILD)/kernel_names,$(KERNELS))

# One job for each core, unless the caller has said how many.
SUBMAKE = +@$(MAKE) --no-print-directory -s $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(shell nproc))

.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all tests fuzzers demo test test-full lint format sanitize oclgrind fuzz bench install uninstall clean
.PHONY: needs help
all: $(BUILD)/frugal $(BUILD)/frugal-image
tests: $(TESTS) $(OCLGRIND_TESTS)
fuzzers: $(FUZZERS)

# Says what is missing in one line, rather than by the compiler's hundreds.
needs:
	@scripts/setup --check

$(ALL_O): $(BUILD)/flags | needs

$(BUILD)/frugal: $(BUILD)/host/app/main.c.o $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) -o $@

$(BUILD)/frugal-image: $(HELPER_O)
	$(CC) $(LDFLAGS) -pthread $^ $(HELPER_LIBS) -o $@

$(BUILD)/libfrugal.a: $(LIBRARY_O) $(BUILD)/members
	rm -f $@
	ar rcs $@ $(LIBRARY_O)

$(BUILD)/%.c.o: %.c
	@mkdir -p $(@D)
	$(CC) -std=c11 $(FLAGS) $(CPPFLAGS) $(CFLAGS) -MMD -MP -c $< -o $@

$(BUILD)/%.cpp.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(FLAGS) $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$(BUILD)/kernels.c: $(KERNELS) $(BUILD)/kernel_names scripts/embed_kernels
	@mkdir -p $(@D)
	bash scripts/embed_kernels $(KERNELS) > $@

$(BUILD)/kernels.o: $(BUILD)/kernels.c
	$(CC) -std=c11 $(FLAGS) $(CPPFLAGS) $(CFLAGS) -MMD -MP -c $< -o $@

$(BUILD)/tests/%: $(BUILD)/tests/%.c.o $(TEST_SUPPORT_O) $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) $(WRAP) -pthread $^ $(LIBS) -lcmocka -o $@

# It looks at what is asked to be compiled, and compiles nothing.
$(BUILD)/tests/test_kernel_options: WRAP = -Wl,--wrap=program_build -Wl,--wrap=program_kernel -Wl,--wrap=device_launch

$(BUILD)/tests/bench/bench_rays: PEER_LIBS = $(EMBREE_LIB)
$(BUILD)/tests/bench/bench_raster: PEER_LIBS = -lEGL -lGLESv2
$(BUILD)/tests/bench/bench_raster: $(GL_PEER_O)
$(BUILD)/tests/bench/%: $(BUILD)/tests/bench/%.c.o $(BENCH_SCENE_O) $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) $(PEER_LIBS) -o $@

# -fsanitize=fuzzer brings the main function; the image helper's part of image reading is the fuzzer's own.
$(BUILD)/tests/fuzz/fuzz_%: $(BUILD)/tests/fuzz/fuzz_%.c.o $(BUILD)/host/image/helper/signature.c.o $(BUILD)/libfrugal.a
	$(CXX) $(LDFLAGS) -fsanitize=fuzzer -pthread -Wl,--wrap=image_read $^ $(LIBS) -o $@

demo:
	@scripts/setup
	$(SUBMAKE) all
	@scripts/demo $(BUILD)

test:
	@scripts/setup
	$(SUBMAKE) all tests
	@TEST_JOBS=$${TEST_JOBS:-2} scripts/run_tests $(BUILD) $(TEST)

test-full: export FRUGAL_TEST_FULL = 1
test-full: export TEST_SECONDS = 1200
test-full:
	@scripts/setup
	$(SUBMAKE) all tests
	@scripts/run_tests $(BUILD) $(TEST)
	+@$(MAKE) --no-print-directory oclgrind
	+@$(MAKE) --no-print-directory fuzz
	@tests/compare_flip_reference $(BUILD)

lint:
	@BUILD=$(BUILD)$(if $(WERROR),,/lint) scripts/lint

format:
	@scripts/lint --fix

SANITIZE := -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all
sanitize:
	@scripts/setup
	$(SUBMAKE) all tests BUILD=$(BUILD)/sanitize CFLAGS='$(SANITIZE)' CXXFLAGS='$(SANITIZE)' LDFLAGS='$(SANITIZE)'
	@scripts/sanitize $(BUILD)/sanitize $(TEST)

oclgrind:
	@scripts/setup oclgrind
	$(SUBMAKE) all tests
	@scripts/oclgrind $(BUILD) $(if $(QUICK),--quick)

FUZZ := -O1 -g -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow \
  -fno-sanitize-recover=all
fuzz:
	@scripts/setup fuzz
	$(SUBMAKE) all tests $(BUILD)/tests/fuzz/shrink_scene
	$(SUBMAKE) fuzzers BUILD=$(BUILD)/fuzz $$(scripts/find_clang) \
	  CFLAGS='$(FUZZ)' CXXFLAGS='$(FUZZ)' LDFLAGS='$(FUZZ)'
	@scripts/fuzz $(BUILD)

bench:
	@scripts/setup bench
	$(SUBMAKE) all $(BENCHES)
	@scripts/bench $(BUILD)

install: all
	@scripts/install "$(BUILD)" "$(PREFIX)" "$(DESTDIR)"

uninstall:
	@scripts/install --uninstall "$(PREFIX)" "$(DESTDIR)"

clean:
	rm -rf $(BUILD)

help:
	@sed -n '/^#/!q; s/^# *//p' Makefile

-include $(ALL_O:.o=.d)
