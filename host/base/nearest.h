// What a user calls a thing by: its index or its name, and "did you mean" where that is mistyped.
#pragma once

#include <stdbool.h>

// Is it an index, digits alone?
bool name_is_index(const char *name);

// The one of `names` (ends with NULL) with the least Levenshtein distance to `word`, the first of equals; NULL where
// there are none. Letters beyond the 63rd do not count.
const char *nearest_name(const char *word, const char *const *names);
