// A message with a file descriptor beside it, sent and received whole over a SOCK_SEQPACKET socket.
#pragma once

#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

// Sends `size` bytes as one message, with `fd` beside them unless it is -1. False: the other end is gone.
static inline bool message_send(int socket, const void *message, size_t size, int fd)
{
  union {
    char bytes[CMSG_SPACE(sizeof(int))];
    struct cmsghdr alignment;
  } control = {{0}};
  struct iovec part = {(void *)message, size};
  struct msghdr header = {.msg_iov = &part, .msg_iovlen = 1};
  if (fd >= 0) {
    header.msg_control = control.bytes;
    header.msg_controllen = sizeof control.bytes;
    struct cmsghdr *rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof fd);
    memcpy(CMSG_DATA(rights), &fd, sizeof fd);
  }
  ssize_t sent;
  do sent = sendmsg(socket, &header, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent == (ssize_t)size;
}

// Receives one message of up to `size` bytes and the descriptor beside it (*fd, -1 without one; the caller closes it).
// Returns its length, 0 at the end of the connection or -1 on failure; a message longer than `size` is a failure.
static inline ssize_t message_receive(int socket, void *message, size_t size, int *fd)
{
  union {
    char bytes[CMSG_SPACE(sizeof(int))];
    struct cmsghdr alignment;
  } control = {{0}};
  struct iovec part = {message, size};
  struct msghdr header = {
      .msg_iov = &part, .msg_iovlen = 1, .msg_control = control.bytes, .msg_controllen = sizeof control.bytes};
  ssize_t received;
  do received = recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  while (received < 0 && errno == EINTR);
  *fd = -1;
  struct cmsghdr *rights = received > 0 ? CMSG_FIRSTHDR(&header) : NULL;
  if (rights && rights->cmsg_level == SOL_SOCKET && rights->cmsg_type == SCM_RIGHTS &&
      rights->cmsg_len == CMSG_LEN(sizeof *fd))
    memcpy(fd, CMSG_DATA(rights), sizeof *fd);
  return header.msg_flags & (MSG_TRUNC | MSG_CTRUNC) ? -1 : received;
}
