#include "device/kernel_cache.h"

#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

static char temporary_folder[PATH_MAX], unusable_reason[PATH_MAX + 64];

// As PoCL finds it (lib/CL/pocl_cache.c, versions 3 to 6), save that without a home folder it would take /tmp/pocl,
// where others may have put kernels of their own. False where there is none, or the path is too long.
static bool pocl_folder(char out[PATH_MAX])
{
  const char *folder = getenv("POCL_CACHE_DIR"), *xdg = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
  int length = folder          ? snprintf(out, PATH_MAX, "%s", folder)
               : xdg && *xdg   ? snprintf(out, PATH_MAX, "%s/pocl/kcache", xdg)
               : home && *home ? snprintf(out, PATH_MAX, "%s/.cache/pocl/kcache", home)
                               : 0;
  return length > 0 && length < PATH_MAX;
}

// As NVIDIA's driver does (CUDA C++ Programming Guide, "CUDA Environment Variables").
static bool nvidia_folder(char out[PATH_MAX])
{
  const char *folder = getenv("CUDA_CACHE_PATH"), *home = getenv("HOME");
  if (!folder && !home) return false;
  int length = folder ? snprintf(out, PATH_MAX, "%s", folder) : snprintf(out, PATH_MAX, "%s/.nv/ComputeCache", home);
  return length > 0 && length < PATH_MAX;
}

// A scene's kernels take some 2 MB.
static const uint64_t least_free_bytes = 32 << 20;

static bool folder_is_usable(const char *path)
{
  char part[PATH_MAX];
  for (size_t i = 1; i <= strlen(path); i++) {
    if (path[i] != '/' && path[i] != 0) continue;
    memcpy(part, path, i);
    part[i] = 0;
    if (mkdir(part, 0700) != 0 && errno != EEXIST && access(part, F_OK) != 0) return false;
  }
  struct statvfs disk;
  return access(path, W_OK | X_OK) == 0 && statvfs(path, &disk) == 0 &&
         (uint64_t)disk.f_bavail * disk.f_frsize >= least_free_bytes;
}

static int entry_remove(const char *path, const struct stat *file, int type, struct FTW *where)
{
  remove(path);
  return 0;
}

static void temporary_remove(void) { nftw(temporary_folder, entry_remove, 16, FTW_DEPTH | FTW_PHYS); }

void kernel_cache_prepare(void)
{
  static bool done;
  char folder[PATH_MAX];
  if (done) return;
  done = true;
  bool is_there = pocl_folder(folder);
  if (is_there && folder_is_usable(folder)) return;
  snprintf(unusable_reason, sizeof unusable_reason, "%s%s", is_there ? folder : "no home folder",
           is_there ? " cannot be written or is full" : "");
  const char *const places[] = {getenv("TMPDIR"), "/tmp"};
  for (int i = 0; i < 2; i++) {
    if (!places[i] || snprintf(folder, sizeof folder, "%s/frugal-kernels-XXXXXX", places[i]) >= (int)sizeof folder)
      continue;
    if (!mkdtemp(folder)) continue;
    memcpy(temporary_folder, folder, sizeof folder);
    setenv("POCL_CACHE_DIR", folder, 1);
    atexit(temporary_remove);
    return;
  }
}

const char *kernel_cache_unusable(void) { return temporary_folder[0] ? unusable_reason : NULL; }

void kernel_cache_remove_temporary(void)
{
  // Kernels may still be compiling on other threads, into a folder that is being emptied.
  for (int i = 0; i < 3 && temporary_folder[0] && access(temporary_folder, F_OK) == 0; i++) {
    pid_t child = _Fork();  // fork() waits for malloc's locks, which the interrupted thread may hold
    if (child == 0) {
      execl("/bin/rm", "rm", "-rf", temporary_folder, (char *)NULL);
      _exit(1);
    }
    if (child < 0) return;
    while (waitpid(child, NULL, 0) < 0 && errno == EINTR) continue;
  }
}

bool kernel_cache_is_kept(void)
{
  const char *kept = getenv("POCL_KERNEL_CACHE");
  return !kept || strtol(kept, NULL, 10) != 0;
}

static KernelCache *counted;  // by the walk under way

static int entry_count(const char *path, const struct stat *file, int type, struct FTW *where)
{
  if (type != FTW_F) return 0;
  counted->files++;
  counted->bytes += (uint64_t)file->st_size;
  return 0;
}

bool kernel_cache_read(KernelCache *out, bool nvidia)
{
  KernelCache cache = {.is_temporary = !nvidia && temporary_folder[0]};
  if (!(nvidia ? nvidia_folder : pocl_folder)(cache.folder) || access(cache.folder, F_OK) != 0) return false;
  *out = cache;
  counted = out;
  nftw(out->folder, entry_count, 16, FTW_PHYS);
  counted = NULL;
  return true;
}
