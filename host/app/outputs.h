// Can the outputs be written? Asked before any work is done for them.
#pragma once

#include "app/options.h"

// Opens each output as it will be opened at the end, and leaves things as they were. Standard output, devices and pipes
// are taken on trust. Errors: STATUS_OUTPUT (no such folder, not writable, there already with --no-clobber, a picture
// to a terminal), STATUS_USAGE (an output that is the scene file).
Status outputs_check(const RenderOptions *options, Log *log);
