#include "app/progress.h"

#include <stdio.h>
#include <unistd.h>

#include "base/clock.h"

static double share_of_run(const Progress *progress, double share)
{
  return ((double)progress->done + share) / (double)progress->pictures;
}

// A line on a terminal for anything over a second.
static void progress_draw(void *context, double share)
{
  Progress *progress = context;
  double now_ms = clock_ms();
  if (now_ms - progress->begin_ms < 1000 || now_ms - progress->drawn_ms < 100) return;
  progress->drawn_ms = now_ms;
  progress->shown = true;
  fprintf(stderr, "\rfrugal: %3.0f %%", 100 * share_of_run(progress, share));
}

// A line for each tenth of the work.
static void progress_print(void *context, double share)
{
  Progress *progress = context;
  int tenths = (int)(10 * share_of_run(progress, share) + 1e-9);
  if (tenths == progress->tenths) return;
  progress->tenths = tenths;
  fprintf(stderr, "frugal: %d %%\n", 10 * tenths);
}

ProgressSay progress_choose(const Progress *progress)
{
  if (isatty(STDERR_FILENO)) return progress->wanted || !progress->quiet ? progress_draw : NULL;
  return progress->wanted ? progress_print : NULL;
}

void progress_end(const Progress *progress)
{
  if (progress->shown) fprintf(stderr, "\r              \r");
}
