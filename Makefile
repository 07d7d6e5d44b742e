# make            build/frugal, and the image helper beside it
# make demo       install what is missing, build, render a picture
# make test       install what is missing, build, run the tests (under 5 minutes); TEST=part of a name runs fewer
# make lint       format, includes as the rooms allow, warnings as errors
# make format     put the C, C++ and OpenCL C files into the project's format
# make sanitize   the tests under address, leak and undefined-behaviour checks, in build/sanitize
# make bench      ray speed beside Embree in the same run
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
BENCHES := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/bench/*.c))
TEST_SUPPORT_C := $(wildcard tests/support/*.c)

objects = $(patsubst %,$(BUILD)/%.o,$(1))
LIBRARY_O := $(call objects,$(LIBRARY_C) $(LIBRARY_CXX)) $(BUILD)/kernels.o
HELPER_O := $(call objects,$(HELPER_C) $(HELPER_CXX)) $(call objects,host/base/log.c host/base/status.c)
TEST_SUPPORT_O := $(call objects,$(TEST_SUPPORT_C))
ALL_O := $(LIBRARY_O) $(HELPER_O) $(TEST_SUPPORT_O) $(BUILD)/host/app/main.c.o $(TESTS:=.c.o) $(BENCHES:=.c.o)

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
.PHONY: all tests demo test lint format sanitize bench install uninstall clean needs help
all: $(BUILD)/frugal $(BUILD)/frugal-image
tests: $(TESTS)

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
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) -lcmocka -o $@

$(BUILD)/tests/bench/%: $(BUILD)/tests/bench/%.c.o $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) $(EMBREE_LIB) -o $@

demo:
	@scripts/setup
	$(SUBMAKE) all
	@scripts/demo $(BUILD)

test:
	@scripts/setup
	$(SUBMAKE) all tests
	@scripts/run_tests $(BUILD) $(TEST)

lint:
	@BUILD=$(BUILD)/lint scripts/lint

format:
	@scripts/lint --fix

SANITIZE := -O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=undefined
sanitize: export UBSAN_OPTIONS = print_stacktrace=1
sanitize: export LSAN_OPTIONS = suppressions=$(CURDIR)/tests/support/leaks.supp:print_suppressions=0
sanitize:
	+@$(MAKE) --no-print-directory test BUILD=$(BUILD)/sanitize \
	  CFLAGS='$(SANITIZE)' CXXFLAGS='$(SANITIZE)' LDFLAGS='$(SANITIZE)'

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
