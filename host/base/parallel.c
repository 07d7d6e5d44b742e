#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>

enum { MAX_THREADS = 256 };

static unsigned requested_threads = 0;

void parallel_set_threads(unsigned count) { requested_threads = count < MAX_THREADS ? count : MAX_THREADS; }

unsigned parallel_threads(void)
{
  if (requested_threads) return requested_threads;
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return 1;
  unsigned cores = (unsigned)CPU_COUNT(&allowed);
  if (cores < 1) return 1;
  return cores < MAX_THREADS ? cores : MAX_THREADS;
}

typedef struct Loop {
  ParallelBody body;
  void *context;
  size_t count;
  atomic_size_t next;
} Loop;

static void *loop_run(void *argument)
{
  Loop *loop = argument;
  for (;;) {
    size_t index = atomic_fetch_add(&loop->next, 1);
    if (index >= loop->count) return NULL;
    loop->body(loop->context, index);
  }
}

void parallel_for(size_t count, ParallelBody body, void *context)
{
  Loop loop = {.body = body, .context = context, .count = count};
  size_t helpers = parallel_threads() - 1;
  if (helpers >= count) helpers = count ? count - 1 : 0;
  pthread_t threads[MAX_THREADS];
  size_t started = 0;
  while (started < helpers && pthread_create(&threads[started], NULL, loop_run, &loop) == 0) started++;
  loop_run(&loop);
  for (size_t i = 0; i < started; i++) pthread_join(threads[i], NULL);
}
