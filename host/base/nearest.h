// "Did you mean": the known word nearest to a mistyped one.
#pragma once

// The one of `names` (ends with NULL) with the least Levenshtein distance to `word`, the first of equals; NULL where
// there are none. Letters beyond the 63rd do not count.
const char *nearest_name(const char *word, const char *const *names);
