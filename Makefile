# make            build/frugal, and the image helper beside it
# make demo       install what is missing, build, render a picture
# make test       install what is missing, build, run the tests (under 5 minutes)
# make lint       format, includes as the rooms allow, warnings as errors
# make bench      ray speed beside Embree in the same run
BUILD ?= build
CC ?= cc
CXX ?= c++
CFLAGS ?= -O2 -g
CXXFLAGS ?= -O2 -g
WARNINGS := -Wall -Wextra -Wshadow -Wpointer-arith -Wvla -Wno-unused-parameter
CPPFLAGS += -Ihost -Icl -Itests -D_GNU_SOURCE -DCL_TARGET_OPENCL_VERSION=120
FLAGS := $(WARNINGS) $(if $(WERROR),-Werror) -MMD -MP -pthread

LIBRARY_C := $(filter-out host/app/main.c,$(wildcard host/*/*.c))
LIBRARY_CXX := $(wildcard host/scene/*.cpp)
HELPER_C := $(wildcard host/image/helper/*.c)
HELPER_CXX := $(wildcard host/image/helper/*.cpp)
KERNELS := $(sort $(wildcard cl/*/*.cl cl/*/*.h))
TESTS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/test_*.c))
TEST_SUPPORT_C := $(wildcard tests/support/*.c)

objects = $(patsubst %,$(BUILD)/%.o,$(1))
LIBRARY_O := $(call objects,$(LIBRARY_C) $(LIBRARY_CXX)) $(BUILD)/kernels.o
HELPER_O := $(call objects,$(HELPER_C) $(HELPER_CXX)) $(call objects,host/base/log.c host/base/status.c)
TEST_SUPPORT_O := $(call objects,$(TEST_SUPPORT_C))
ALL_O := $(LIBRARY_O) $(HELPER_O) $(TEST_SUPPORT_O) $(BUILD)/host/app/main.c.o

LIBS := -lOpenCL -ltinygltf -ljansson -lstdc++ -lm
HELPER_LIBS := -lOpenImageIO -lOpenImageIO_Util -lstdc++ -lm

.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all demo test lint bench clean
all: $(BUILD)/frugal $(BUILD)/frugal-image

$(BUILD)/frugal: $(BUILD)/host/app/main.c.o $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) -o $@

$(BUILD)/frugal-image: $(HELPER_O)
	$(CC) $(LDFLAGS) -pthread $^ $(HELPER_LIBS) -o $@

$(BUILD)/libfrugal.a: $(LIBRARY_O)
	rm -f $@
	ar rcs $@ $^

$(BUILD)/%.c.o: %.c
	@mkdir -p $(@D)
	$(CC) -std=c11 $(CPPFLAGS) $(FLAGS) $(CFLAGS) -c $< -o $@

$(BUILD)/%.cpp.o: %.cpp
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(CPPFLAGS) $(FLAGS) $(CXXFLAGS) -c $< -o $@

$(BUILD)/kernels.c: $(KERNELS) scripts/embed_kernels
	@mkdir -p $(@D)
	scripts/embed_kernels $(KERNELS) > $@

$(BUILD)/kernels.o: $(BUILD)/kernels.c
	$(CC) -std=c11 $(CPPFLAGS) $(FLAGS) $(CFLAGS) -c $< -o $@

$(BUILD)/tests/%: $(BUILD)/tests/%.c.o $(TEST_SUPPORT_O) $(BUILD)/libfrugal.a
	$(CC) $(LDFLAGS) -pthread $^ $(LIBS) -lcmocka -o $@

demo:
	@scripts/setup
	@$(MAKE) --no-print-directory -s all
	@scripts/demo

test:
	@scripts/setup
	@$(MAKE) --no-print-directory -s all tests
	@scripts/run_tests $(BUILD)

.PHONY: tests
tests: $(TESTS)

lint:
	@scripts/lint

bench:
	@scripts/bench

clean:
	rm -rf $(BUILD)

-include $(ALL_O:.o=.d) $(TESTS:=.c.d)
