#include "support/cli.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/clock.h"
#include "support/effort.h"
#include "support/gltf_build.h"

enum { MAX_ARGUMENTS = 64, LIMIT_S = 300 };

CliSetting cli_setting;
char cli_folder[PATH_MAX / 2], cli_program[PATH_MAX], cli_build[PATH_MAX / 2];

const char *cli_path(const char *format, ...)
{
  static char paths[8][PATH_MAX];
  static int next;
  char *path = paths[next++ % 8], name[PATH_MAX / 2];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(name, sizeof name, format, arguments);
  va_end(arguments);
  snprintf(path, PATH_MAX, "%s/%s", cli_folder, name);
  return path;
}

int cli_set_up(void **state)
{
  ssize_t length = readlink("/proc/self/exe", cli_build, sizeof cli_build - 1);
  if (length < 0) return -1;
  cli_build[length] = 0;
  for (int i = 0; i < 2; i++) *strrchr(cli_build, '/') = 0;  // off build/tests/test_x
  snprintf(cli_program, sizeof cli_program, "%s/frugal", cli_build);
  char cache[PATH_MAX];
  snprintf(cache, sizeof cache, "%s/pocl_cache", cli_build);
  setenv("POCL_CACHE_DIR", cache, 0);
  strcpy(cli_folder, "/tmp/test_cli_XXXXXX");
  if (!mkdtemp(cli_folder)) return -1;
  strcpy(gltf_folder, cli_folder);
  mkdir(cli_path("tmp"), 0777);
  chmod(cli_path("tmp"), 0777);
  mkdir(cli_path("out"), 0777);
  cli_save(cli_path("out/old.png"), "old", 3);
  chmod(cli_folder, 0755);
  // Processes whose parent has ended come to this one: none can hide.
  return prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0);
}

int cli_tear_down(void **state)
{
  char command[PATH_MAX];
  snprintf(command, sizeof command, "rm -rf '%s'", cli_folder);
  return system(command);
}

// A growing copy of what a pipe gives.
typedef struct Stream {
  int fd;
  char *bytes;
  size_t size;
} Stream;

static void stream_read(Stream *stream)
{
  static char block[1 << 16];
  ssize_t got = read(stream->fd, block, sizeof block);
  if (got <= 0) {
    close(stream->fd);
    stream->fd = -1;
    return;
  }
  stream->bytes = realloc(stream->bytes, stream->size + (size_t)got + 1);
  assert_non_null(stream->bytes);
  memcpy(stream->bytes + stream->size, block, (size_t)got);
  stream->size += (size_t)got;
  stream->bytes[stream->size] = 0;
}

static _Noreturn void child_run(char *const *arguments, int out, int err)
{
  dup2(cli_setting.stdout_fd ? cli_setting.stdout_fd : out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  int null = open("/dev/null", O_RDONLY);
  dup2(null, STDIN_FILENO);
  for (int fd = STDERR_FILENO + 1; fd < 64; fd++) close(fd);
  setenv("TMPDIR", cli_path("tmp"), 1);
  for (const char *const *variable = cli_setting.environment; *variable; variable++)
    if (strchr(*variable, '='))
      putenv((char *)*variable);
    else
      unsetenv(*variable);
  if (cli_setting.address_space)
    setrlimit(RLIMIT_AS, &(struct rlimit){cli_setting.address_space, cli_setting.address_space});
  if (cli_setting.ignore_interrupt) signal(SIGINT, SIG_IGN);
  if (cli_setting.user && setuid(cli_setting.user) != 0) _exit(126);
  execv(cli_program, arguments);
  _exit(127);
}

static bool signal_is_due(const char *err)
{
  if (cli_setting.signal_after) return strstr(err, cli_setting.signal_after);
  return cli_setting.signal_while && strstr(cli_list(cli_setting.signal_while), ".frugal-");
}

// Reads both pipes to their end, sending the signal that the setting asks for; returns when, or 0.
static double streams_read(Stream streams[2], pid_t child)
{
  double end_ms = clock_ms() + 1000.0 * LIMIT_S, signalled_ms = 0;
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    struct pollfd polled[2] = {{.fd = streams[0].fd, .events = POLLIN}, {.fd = streams[1].fd, .events = POLLIN}};
    if (poll(polled, 2, cli_setting.signal_while ? 2 : 1000) > 0)
      for (int i = 0; i < 2; i++)
        if (polled[i].revents) stream_read(&streams[i]);
    if (!signalled_ms && signal_is_due(streams[1].bytes)) {
      kill(child, cli_setting.signal);
      signalled_ms = clock_ms();
    }
    if (clock_ms() < end_ms) continue;
    kill(child, SIGKILL);
    fail_msg("the program ran for over %d s", LIMIT_S);
  }
  return signalled_ms;
}

// Waits for processes that the program left to this one; fails where one is still there after a second, or after ten in
// a build that is slow: a helper ends when it has started.
static void strays_check(void)
{
  double end_ms = clock_ms() + (effort_is_quick() ? 10000 : 1000);
  for (;;) {
    pid_t stray = waitpid(-1, NULL, WNOHANG);
    if (stray < 0) return;
    if (stray == 0 && clock_ms() > end_ms) fail_msg("a process was left behind");
    if (stray == 0) usleep(10000);
  }
}

CliRun cli_run(const char *first, ...)
{
  char *arguments[MAX_ARGUMENTS] = {cli_program};
  int count = 1, ending = 0, out[2], err[2];
  va_list list;
  va_start(list, first);
  for (const char *word = first; word && count < MAX_ARGUMENTS - 1; word = va_arg(list, const char *))
    arguments[count++] = (char *)word;
  va_end(list);
  assert_int_equal(pipe(out), 0);
  assert_int_equal(pipe(err), 0);

  pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) child_run(arguments, out[1], err[1]);
  close(out[1]);
  close(err[1]);
  Stream streams[2] = {{.fd = out[0], .bytes = calloc(1, 1)}, {.fd = err[0], .bytes = calloc(1, 1)}};
  double signalled_ms = streams_read(streams, child);
  struct rusage usage;
  while (wait4(child, &ending, 0, &usage) < 0) assert_int_equal(errno, EINTR);
  CliRun run = {
      .exit_code = WIFEXITED(ending) ? WEXITSTATUS(ending) : -1,
      .signal = WIFSIGNALED(ending) ? WTERMSIG(ending) : 0,
      .cpu_s = (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
               1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec),
      .signal_ms = signalled_ms ? clock_ms() - signalled_ms : 0,
      .max_rss_kb = usage.ru_maxrss,
      .out = streams[0].bytes,
      .err = streams[1].bytes,
      .out_size = streams[0].size,
  };
  cli_setting = (CliSetting){0};
  strays_check();
  if (*cli_list(cli_path("tmp"))) fail_msg("left in the temporary folder: %s", cli_list(cli_path("tmp")));
  return run;
}

void cli_free(CliRun *run)
{
  free(run->out);
  free(run->err);
  *run = (CliRun){0};
}

// Where the last line of a text begins.
static const char *last_line(const char *text)
{
  const char *line = text;
  for (const char *c = text; *c; c++)
    if (*c == '\n' && c[1]) line = c + 1;
  return line;
}

void cli_expect(const CliRun *run, int exit_code, const char *message, const char *file, int line)
{
  bool as_expected = run->exit_code == exit_code && strstr(run->err, message);
  bool tidy = exit_code == 0 || (strncmp(last_line(run->err), "frugal: ", 8) == 0 && run->out_size == 0 &&
                                 run->cpu_s < 5 && run->max_rss_kb < 1 << 20);
  if (as_expected && tidy) return;
  print_error(
      "exit code %d (signal %d), %.1f s of CPU time, %ld kB, %zu bytes on standard output;\n"
      "exit code %d and '%s' expected; standard error:\n%s",
      run->exit_code, run->signal, run->cpu_s, run->max_rss_kb, run->out_size, exit_code, message, run->err);
  _fail(file, line);
}

void cli_old_check(void)
{
  char *bytes = cli_load(cli_path("out/old.png"), NULL);
  assert_non_null(bytes);
  assert_string_equal(bytes, "old");
  free(bytes);
  assert_string_equal(cli_list(cli_path("out")), "old.png");
}

char *cli_load(const char *path, size_t *size)
{
  struct stat file;
  int fd = open(path, O_RDONLY);
  if (fd < 0 || fstat(fd, &file) != 0) return NULL;
  char *bytes = calloc((size_t)file.st_size + 1, 1);
  assert_non_null(bytes);
  assert_int_equal(read(fd, bytes, (size_t)file.st_size), file.st_size);
  close(fd);
  if (size) *size = (size_t)file.st_size;
  return bytes;
}

void cli_save(const char *path, const void *bytes, size_t size)
{
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
}

const char *cli_list(const char *folder)
{
  static char list[4096];
  struct dirent **entries;
  int count = scandir(folder, &entries, NULL, alphasort);
  list[0] = 0;
  for (int i = 0; i < count; i++) {
    bool is_itself = !strcmp(entries[i]->d_name, ".") || !strcmp(entries[i]->d_name, "..");
    size_t used = strlen(list);
    if (!is_itself) snprintf(list + used, sizeof list - used, "%s%s", used ? " " : "", entries[i]->d_name);
    free(entries[i]);
  }
  if (count >= 0) free(entries);
  return list;
}

const char *cli_scene(void)
{
  static char path[PATH_MAX];
  if (*path) return path;
  GltfBuild build = {0};
  static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
  GLTF_FLOATS(&build, "VEC3", 4, -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0);
  gltf_array(&build, 5123, "SCALAR", corners, sizeof corners, 6, "");
  const char *made =
      gltf_save(&build,
                "'scene':0,'scenes':[{'nodes':[0,1,2,3]}],"
                "'nodes':[{'name':'square','mesh':0,'rotation':[0,0,0.0998334,0.9950042]},"
                "{'name':'front','camera':0,'translation':[0,0,4]},{'name':'flat','camera':1,'translation':[0,0,4]},"
                "{'name':'lamp','translation':[0,0,4],'extensions':{'KHR_lights_punctual':{'light':0}}}],"
                "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]}],"
                "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[0.8,0.6,0.4,1],'metallicFactor':0}}],"
                "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1}},"
                "{'type':'orthographic','orthographic':{'xmag':1.5,'ymag':1.5,'znear':0.1,'zfar':10}}],"
                "'extensionsUsed':['KHR_lights_punctual'],"
                "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':20}]}}");
  snprintf(path, sizeof path, "%s/scene.glb", cli_folder);
  assert_int_equal(rename(made, path), 0);
  return path;
}
