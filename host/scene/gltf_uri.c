#include "scene/gltf_uri.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#define HINT_OUTSIDE "move it there or give --allow-outside"

bool gltf_uri_is_data(const char *uri) { return strncasecmp(uri, "data:", 5) == 0; }

static int base64_value(char c)
{
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

// Decodes into `out`, which has room for 3/4 of the text; false where a character does not belong.
static bool base64_decode(uint8_t *out, uint64_t *size, const char *text)
{
  uint32_t bits = 0;
  int bit_count = 0;
  *size = 0;
  for (; *text && *text != '='; text++) {
    int value = base64_value(*text);
    if (value < 0) return false;
    bits = bits << 6 | (uint32_t)value;
    bit_count += 6;
    if (bit_count < 8) continue;
    bit_count -= 8;
    out[(*size)++] = (uint8_t)(bits >> bit_count);
  }
  return strspn(text, "=") == strlen(text) && bit_count < 6;
}

static int hex_value(char c)
{
  if (!isxdigit((unsigned char)c)) return -1;
  return isdigit((unsigned char)c) ? c - '0' : tolower((unsigned char)c) - 'a' + 10;
}

// Decodes into `out`, which has room for all of the text; false for a % that no two hex digits follow.
static bool percent_decode(uint8_t *out, uint64_t *size, const char *text)
{
  *size = 0;
  for (; *text; text++) {
    int high = *text == '%' ? hex_value(text[1]) : 0, low = *text == '%' && high >= 0 ? hex_value(text[2]) : 0;
    if (high < 0 || low < 0) return false;
    out[(*size)++] = *text == '%' ? (uint8_t)(16 * high + low) : (uint8_t)*text;
    if (*text == '%') text += 2;
  }
  return true;
}

Status gltf_uri_decode_data(GltfBytes *out, Gltf *gltf, const char *uri)
{
  Status status = STATUS_OK;
  GltfBytes data = {0};
  const char *comma = strchr(uri, ',');
  if (!comma) return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "a data: URI has no comma");
  bool is_base64 = comma - uri >= 7 && strncasecmp(comma - 7, ";base64", 7) == 0;
  TRY(gltf_allocate(&data.owned, gltf, strlen(comma), 1));
  if (!(is_base64 ? base64_decode : percent_decode)(data.owned, &data.size, comma + 1)) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "a data: URI is not valid %s",
                       is_base64 ? "base64" : "percent-encoding");
    goto done;
  }
  data.bytes = data.owned;
  *out = data;

done:
  if (status) free(data.owned);
  return status;
}

static bool has_scheme(const char *uri)
{
  size_t length = strspn(uri, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+.-");
  return length > 0 && uri[length] == ':' && isalpha((unsigned char)uri[0]);
}

// Does a relative path step above where it starts?
static bool climbs_out(const char *path)
{
  int depth = 0;
  while (*path && depth >= 0) {
    size_t length = strcspn(path, "/");
    if (length == 2 && strncmp(path, "..", 2) == 0)
      depth--;
    else if (length > 0 && !(length == 1 && *path == '.'))
      depth++;
    path += length + (path[length] == '/');
  }
  return depth < 0;
}

// Both without links and `..`; the folder ends in '/'.
static bool is_within(const char *path, const char *folder)
{
  size_t length = strlen(folder);
  return strncmp(path, folder, length) == 0 || (strlen(path) + 1 == length && strncmp(path, folder, length - 1) == 0);
}

// The folder of gltf->path with all links followed, ending in '/'.
static Status folder_of(char out[PATH_MAX + 1], Gltf *gltf)
{
  char folder[PATH_MAX];
  const char *slash = strrchr(gltf->path, '/');
  size_t length = slash ? (size_t)(slash - gltf->path) + 1 : 2;
  if (length >= sizeof folder) return gltf_fail(gltf, STATUS_NOT_FOUND, "shorten it", "path too long");
  memcpy(folder, slash ? gltf->path : "./", length);
  folder[length] = 0;
  if (!realpath(folder, out))
    return gltf_fail(gltf, STATUS_NOT_FOUND, "check the name and its permissions", "%s", strerror(errno));
  if (out[1]) strcat(out, "/");
  return STATUS_OK;
}

Status gltf_path_resolve(char **out, Gltf *gltf, const char *path)
{
  Status status = STATUS_OK;
  bool outside_allowed = gltf->options->allow_outside;
  char folder[PATH_MAX + 1];
  char *joined = NULL, *real = NULL;
  TRY(folder_of(folder, gltf));
  if (!outside_allowed && (path[0] == '/' || climbs_out(path))) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, HINT_OUTSIDE, "refers to '%.200s' outside its folder", path);
    goto done;
  }
  TRY(gltf_allocate(&joined, gltf, strlen(folder) + strlen(path) + 1, 1));
  if (path[0] != '/') strcpy(joined, folder);
  strcat(joined, path);
  real = realpath(joined, NULL);
  if (!real) {
    status = gltf_fail(gltf, STATUS_NOT_FOUND, "put the file there", "refers to '%.200s': %s", path, strerror(errno));
    goto done;
  }
  if (!outside_allowed && !is_within(real, folder)) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, HINT_OUTSIDE, "'%.200s' is a link that leaves its folder", path);
    goto done;
  }
  *out = real;
  real = NULL;

done:
  free(joined);
  free(real);
  return status;
}

Status gltf_uri_resolve(char **out, Gltf *gltf, const char *uri)
{
  Status status = STATUS_OK;
  uint64_t size = 0;
  char *path = NULL;
  TRY(gltf_allocate(&path, gltf, strlen(uri) + 1, 1));
  if (has_scheme(uri)) {
    status = gltf_fail(gltf, STATUS_UNSUPPORTED, "store the file beside it and name it by a relative path",
                       "refers to '%.200s'", uri);
    goto done;
  }
  if (!percent_decode((uint8_t *)path, &size, uri) || size == 0 || memchr(path, 0, size)) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "'%.200s' is not a valid URI", uri);
    goto done;
  }
  TRY(gltf_path_resolve(out, gltf, path));

done:
  free(path);
  return status;
}

// Reads what is there of the first `size` bytes.
static uint64_t read_up_to(uint8_t *bytes, uint64_t size, int fd)
{
  uint64_t done = 0;
  while (done < size) {
    size_t step = size - done < (1u << 30) ? size - done : 1u << 30;
    ssize_t got = read(fd, bytes + done, step);
    if (got == 0 || (got < 0 && errno != EINTR)) break;
    if (got > 0) done += (uint64_t)got;
  }
  return done;
}

Status gltf_file_read(GltfBytes *out, Gltf *gltf, const char *what, uint64_t size)
{
  Status status = STATUS_OK;
  GltfBytes data = {0};
  struct stat file;
  int fd = open(what, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0 || fstat(fd, &file) != 0) {
    status = log_fail(gltf->log, STATUS_NOT_FOUND, "%s: %s: check the name and its permissions", what, strerror(errno));
    goto done;
  }
  if (!S_ISREG(file.st_mode)) {
    status = log_fail(gltf->log, STATUS_NOT_FOUND, "%s: is %s: name a file", what,
                      S_ISDIR(file.st_mode) ? "a folder" : "not a regular file");
    goto done;
  }
  data.size = size ? size : (uint64_t)file.st_size;
  if (data.size <= (uint64_t)file.st_size) {
    TRY(gltf_allocate(&data.owned, gltf, data.size, 1));
    data.bytes = data.owned;
  }
  if (data.size > (uint64_t)file.st_size || read_up_to(data.owned, data.size, fd) < data.size) {
    status = log_fail(gltf->log, STATUS_BAD_SCENE, "%s: is %llu bytes long where %llu are needed: " GLTF_HINT_REPAIR,
                      what, (unsigned long long)file.st_size, (unsigned long long)data.size);
    goto done;
  }
  *out = data;

done:
  if (fd >= 0) close(fd);
  if (status) free(data.owned);
  return status;
}
