/* Runs a program many times from one start, for tests that call it thousands of times: to load and link it takes longer than
 * most of what they ask of it. LD_PRELOAD=libfault.so SURVEYMC_SERVER=IN,OUT program, with descriptors of two pipes.
 *   request  size, seconds (4 bytes each), then texts, each with a 0 behind it: folder, fault, file for counts, arguments
 *   answer   status of waitpid, sizes of stdout and stderr (4 bytes each), stdout, stderr; a status of -1: it did not end in time
 * Each request is a new process, forked before main(), whose standard input is empty. */
#define _GNU_SOURCE
#include "server.h"

#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { kMostWords = 60, kFolder = 0, kFault = 1, kCounts = 2, kArguments = 3 };

static int take(int file, void *data, size_t size) {
  for (char *at = data; size > 0;) {
    const ssize_t n = read(file, at, size);
    if (n <= 0) return 0;
    at += n, size -= (size_t)n;
  }
  return 1;
}

static void give(int file, const void *data, size_t size) {
  for (const char *at = data; size > 0;) {
    const ssize_t n = write(file, at, size);
    if (n <= 0) _exit(1);
    at += n, size -= (size_t)n;
  }
}

static void become(const struct Server *server, char **words, int out, int err) {
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  for (int file = STDERR_FILENO + 1; file < 64; ++file) close(file);
  if (chdir(words[kFolder]) != 0) _exit(126);
  setenv("SURVEYMC_FAULT", words[kFault], 1);
  if (*words[kCounts]) setenv("SURVEYMC_FAULT_COUNTS", words[kCounts], 1);
  int count = 0;
  while (words[kArguments + count]) ++count;
  exit(server->run(count, words + kArguments));
}

struct Text {
  char *data;
  uint32_t size, room;
};

/* Appends what the pipe has; false at its end. */
static int append(struct Text *text, int file) {
  if (text->size == text->room) text->data = realloc(text->data, text->room += 1 << 16);
  const ssize_t n = read(file, text->data + text->size, text->room - text->size);
  if (n > 0) text->size += (uint32_t)n;
  return n > 0;
}

/* Reads both pipes to their ends; false if that takes longer. */
static int listen_to(struct pollfd *pipes, struct Text *texts, uint32_t seconds) {
  const time_t end = time(NULL) + seconds;
  while (pipes[0].fd >= 0 || pipes[1].fd >= 0) {
    const time_t left = end - time(NULL);
    if (left <= 0) return 0;
    poll(pipes, 2, (int)left * 1000);
    for (int i = 0; i < 2; ++i)
      if (pipes[i].fd >= 0 && pipes[i].revents && !append(&texts[i], pipes[i].fd)) close(pipes[i].fd), pipes[i].fd = -1;
  }
  return 1;
}

void serve(const struct Server *server) {
  int in, out;
  const char *where = getenv("SURVEYMC_SERVER");
  if (!where || sscanf(where, "%d,%d", &in, &out) != 2) return;
  unsetenv("SURVEYMC_SERVER");
  uint32_t head[2];
  while (take(in, head, sizeof head)) {
    char *texts = malloc(head[0] + 1), *words[kMostWords + 1] = {0};
    if (!texts || !take(in, texts, head[0])) _exit(1);
    int count = 0;
    for (char *at = texts; at < texts + head[0] && count < kMostWords; at += strlen(at) + 1) words[count++] = at;
    int standard[2], error[2];
    if (count <= kArguments || pipe(standard) != 0 || pipe(error) != 0) _exit(1);
    const pid_t child = fork();
    if (child < 0) _exit(1);
    if (child == 0) become(server, words, standard[1], error[1]);
    close(standard[1]);
    close(error[1]);
    struct pollfd pipes[2] = {{standard[0], POLLIN, 0}, {error[0], POLLIN, 0}};
    struct Text said[2] = {{0}};
    int32_t status = 0;
    const int is_in_time = listen_to(pipes, said, head[1]);
    if (!is_in_time) kill(child, SIGKILL);
    waitpid(child, &status, 0);
    for (int i = 0; i < 2; ++i)
      if (pipes[i].fd >= 0) close(pipes[i].fd);
    const uint32_t answer[3] = {is_in_time ? (uint32_t)status : UINT32_MAX, said[0].size, said[1].size};
    give(out, answer, sizeof answer);
    give(out, said[0].data, said[0].size);
    give(out, said[1].data, said[1].size);
    free(said[0].data);
    free(said[1].data);
    free(texts);
  }
  _exit(0);
}
