// The keys of a scene file as the options of a command.
#pragma once

#include "app/command_line.h"
#include "scene/scene_file.h"

// Reads every key of `file` that is an option's long name into `settings`, by that option's own reader. The texts
// of the settings stay in the file, whose numbers and lists become texts. Keys of scene_file_keys are passed over.
//
// Errors: STATUS_BAD_SCENE: an unknown key (the nearest is named), one of the command line alone, a value of the wrong
// type or not valid.
Status file_keys_read(void *settings, const CommandLine *line, SceneFile *file, Log *log);
