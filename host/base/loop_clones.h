// Functions whose loops are compiled for what the processor has.
#pragma once

// On other processors, and where a checker instruments start-up code, the compiler's baseline has to do.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define LOOP_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define LOOP_CLONES
#endif
