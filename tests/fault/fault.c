/* Makes one call of the system fail, for tests: LD_PRELOAD=libfault.so SURVEYMC_FAULT=CALL:N:FAULT program ...
 *   CALL   open, read, write, fsync, rename, place (renameat2), ftruncate, close, mkdir, mmap, malloc, unlink, link, lock (flock),
 *          mode (fchmod), seek, stat, list (of a folder), fork or pipe
 *   N      which of these calls, from 1, counted from the beginning of main(); 0: none
 *   FAULT  a name of kErrors: the call fails with it;
 *          "short": a write or read takes half of its bytes;
 *          "flip": a write changes a bit of the byte in its middle;  a "+" behind it: all later calls fail, too;
 *          "wait": nothing fails, but the call takes half a minute, and stderr gets the line "waiting" before;
 *          "gone" behind open or stat: if the file is a journal, another host has just removed it
 * SURVEYMC_FAULT_COUNTS=FILE: at the end, how many calls of each there were, one "CALL N" a line.
 * SURVEYMC_FAULT_NO_EXCHANGE=1: as on a file system that cannot exchange two names.
 * SURVEYMC_SERVER: see server.c.
 * Only open, read, write, seek and close of regular files are counted: pipes and terminals belong to the test. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "server.h"

enum { kOpen, kRead, kWrite, kFsync, kRename, kFtruncate, kClose, kMkdir, kMmap, kMalloc,
       kUnlink, kLink, kLock, kMode, kSeek, kStat, kList, kFork, kPipe, kPlace, kCalls };
static const char *const kNames[kCalls] = {"open",  "read",  "write", "fsync",  "rename", "ftruncate",
                                           "close", "mkdir", "mmap",  "malloc", "unlink",
                                           "link",  "lock",  "mode",  "seek",   "stat",   "list",   "fork",   "pipe",
                                           "place"};
static atomic_ulong counts[kCalls];
static atomic_int active;
static int chosen_call = -1, chosen_errno, is_short, is_flip, is_lasting, is_slow, is_gone;
static unsigned long chosen_number;

static const struct {
  const char *name;
  int number;
} kErrors[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO},       {"EINTR", EINTR},   {"ENOMEM", ENOMEM},
               {"EMFILE", EMFILE}, {"EAGAIN", EAGAIN}, {"EACCES", EACCES}, {"EDQUOT", EDQUOT}, {"ENOLCK", ENOLCK}, {"EPERM", EPERM},
               {"ESTALE", ESTALE}, {"EINVAL", EINVAL}};

static void read_settings(void) {
  const char *text = getenv("SURVEYMC_FAULT");
  char call[16] = "", fault[16] = "";
  if (!text || sscanf(text, "%15[a-z]:%lu:%15s", call, &chosen_number, fault) != 3) return;
  for (int i = 0; i < kCalls; ++i)
    if (strcmp(call, kNames[i]) == 0) chosen_call = i;
  char *plus = strchr(fault, '+');
  if (plus) is_lasting = 1, *plus = 0;
  is_short = strcmp(fault, "short") == 0;
  is_flip = strcmp(fault, "flip") == 0;
  is_slow = strcmp(fault, "wait") == 0;
  is_gone = strcmp(fault, "gone") == 0;
  for (size_t i = 0; i < sizeof kErrors / sizeof *kErrors; ++i)
    if (strcmp(fault, kErrors[i].name) == 0) chosen_errno = kErrors[i].number;
}

/* True if this call is the one that fails. */
static int hit(int call) {
  if (!atomic_load(&active)) return 0;
  const unsigned long n = atomic_fetch_add(&counts[call], 1) + 1;
  if (call != chosen_call || chosen_number == 0) return 0;
  if (is_lasting ? n < chosen_number : n != chosen_number) return 0;
  if (is_slow) {
    static const struct timespec kShort = {0, 100000000};
    dprintf(STDERR_FILENO, "waiting\n");
    for (int i = 0; i < 300; ++i) nanosleep(&kShort, NULL);
    return 0;
  }
  if (!is_short && !is_flip) errno = chosen_errno;
  return 1;
}

static int is_regular(int file) {
  struct stat s;
  return syscall(SYS_newfstatat, file, "", &s, AT_EMPTY_PATH) == 0 && S_ISREG(s.st_mode);
}

static void write_counts(void) {
  atomic_store(&active, 0);
  const char *path = getenv("SURVEYMC_FAULT_COUNTS");
  if (!path) return;
  const int file = (int)syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
  for (int i = 0; i < kCalls; ++i) {
    char line[64];
    const int n = snprintf(line, sizeof line, "%s %lu\n", kNames[i], atomic_load(&counts[i]));
    if (syscall(SYS_write, file, line, n) != n) break;
  }
  syscall(SYS_close, file);
}

static int (*real_main)(int, char **, char **);
static int run_counted(int argc, char **argv) {
  read_settings();
  atexit(write_counts);
  atomic_store(&active, 1);
  return real_main(argc, argv, environ);
}
static int counted_main(int argc, char **argv, char **envp) {
  static const struct Server kServer = {run_counted};
  (void)envp;
  unsetenv("LD_PRELOAD"); /* programs that this one starts have no faults, and no counts */
  serve(&kServer);
  return run_counted(argc, argv);
}
int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void *stack_end) {
  typeof(&__libc_start_main) next = (typeof(&__libc_start_main))dlsym(RTLD_NEXT, "__libc_start_main");
  real_main = main;
  return next(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

#define NEXT(name)                    \
  static typeof(&name) next_##name;   \
  if (!next_##name) next_##name = (typeof(&name))dlsym(RTLD_NEXT, #name)

/* Of a call that is hit: whether it goes on, with the file removed where it is to be. */
static int goes_on(int folder, const char *path) {
  if (is_gone && strstr(path, ".journal.")) syscall(SYS_unlinkat, folder, path, 0);
  return is_gone;
}

static int opened(int folder, const char *path, int flags, mode_t mode) {
  struct stat s;
  const int exists = syscall(SYS_newfstatat, folder, path, &s, 0) == 0;
  const int counts_here = (flags & O_CREAT) || (exists && S_ISREG(s.st_mode));
  if (counts_here && hit(kOpen) && !goes_on(folder, path)) return -1;
  return (int)syscall(SYS_openat, folder, path, flags, mode);
}
#define OPEN_MODE                                      \
  mode_t mode = 0;                                     \
  if (flags & (O_CREAT | (O_TMPFILE & ~O_DIRECTORY))) { \
    va_list args;                                      \
    va_start(args, flags);                             \
    mode = va_arg(args, mode_t);                       \
    va_end(args);                                      \
  }
int open(const char *path, int flags, ...) { OPEN_MODE return opened(AT_FDCWD, path, flags, mode); }
int open64(const char *path, int flags, ...) { OPEN_MODE return opened(AT_FDCWD, path, flags, mode); }
int openat(int folder, const char *path, int flags, ...) { OPEN_MODE return opened(folder, path, flags, mode); }
int openat64(int folder, const char *path, int flags, ...) { OPEN_MODE return opened(folder, path, flags, mode); }
FILE *fopen(const char *path, const char *how) {
  NEXT(fopen);
  struct stat s;
  if (syscall(SYS_newfstatat, AT_FDCWD, path, &s, 0) == 0 && S_ISREG(s.st_mode) && hit(kOpen) && !goes_on(AT_FDCWD, path))
    return NULL;
  return next_fopen(path, how);
}
FILE *fopen64(const char *path, const char *how) { return fopen(path, how); }

/* A copy with a bit of the byte in the middle changed; never freed. */
static const void *flipped(const void *data, size_t size) {
  char *copy = aligned_alloc(4096, (size + 4095) / 4096 * 4096);
  if (!copy) return data;
  memcpy(copy, data, size);
  copy[size / 2] ^= 1;
  return copy;
}

#define TRANSFER(call, number, ...)                                    \
  if (is_regular(file) && hit(call)) {                                 \
    if (is_flip) return syscall(number, file, flipped(data, size), size, ##__VA_ARGS__); \
    if (!is_short) return -1;                                          \
    if (size > 1) size /= 2;                                           \
  }                                                                    \
  return syscall(number, file, data, size, ##__VA_ARGS__)
ssize_t write(int file, const void *data, size_t size) { TRANSFER(kWrite, SYS_write); }
ssize_t pwrite(int file, const void *data, size_t size, off_t at) { TRANSFER(kWrite, SYS_pwrite64, at); }
ssize_t pwrite64(int file, const void *data, size_t size, off64_t at) { TRANSFER(kWrite, SYS_pwrite64, at); }
ssize_t read(int file, void *data, size_t size) { TRANSFER(kRead, SYS_read); }
ssize_t pread(int file, void *data, size_t size, off_t at) { TRANSFER(kRead, SYS_pread64, at); }
ssize_t pread64(int file, void *data, size_t size, off64_t at) { TRANSFER(kRead, SYS_pread64, at); }

/* As the C library does it: with the mark of an error, of which ferror() tells. It reads on by itself after a short read. */
size_t fread(void *data, size_t size, size_t count, FILE *stream) {
  NEXT(fread);
  if (is_regular(fileno(stream)) && !(is_short && chosen_call == kRead) && hit(kRead)) {
    stream->_flags |= 0x20; /* _IO_ERR_SEEN */
    return 0;
  }
  return next_fread(data, size, count, stream);
}
off_t lseek(int file, off_t at, int from) { return is_regular(file) && hit(kSeek) ? -1 : syscall(SYS_lseek, file, at, from); }
off64_t lseek64(int file, off64_t at, int from) { return lseek(file, at, from); }
int unlink(const char *path) { return hit(kUnlink) ? -1 : (int)syscall(SYS_unlinkat, AT_FDCWD, path, 0); }
int link(const char *from, const char *to) { return hit(kLink) ? -1 : (int)syscall(SYS_linkat, AT_FDCWD, from, AT_FDCWD, to, 0); }
int flock(int file, int how) { return hit(kLock) ? -1 : (int)syscall(SYS_flock, file, how); }
int fchmod(int file, mode_t mode) { return hit(kMode) ? -1 : (int)syscall(SYS_fchmod, file, mode); }
pid_t fork(void) {
  NEXT(fork);
  return hit(kFork) ? -1 : next_fork();
}
int pipe(int ends[2]) { return hit(kPipe) ? -1 : (int)syscall(SYS_pipe2, ends, 0); }

/* Of files, folders, and what is not there. */
static int status_of(int folder, const char *path, struct stat *out, int flags) {
  const int result = (int)syscall(SYS_newfstatat, folder, path, out, flags), reason = errno;
  if (result == 0 && !S_ISREG(out->st_mode) && !S_ISDIR(out->st_mode)) return result;
  if (hit(kStat)) return goes_on(folder, path) ? (int)syscall(SYS_newfstatat, folder, path, out, flags) : -1;
  errno = reason;
  return result;
}
int stat(const char *path, struct stat *out) { return status_of(AT_FDCWD, path, out, 0); }
int lstat(const char *path, struct stat *out) { return status_of(AT_FDCWD, path, out, AT_SYMLINK_NOFOLLOW); }
int fstat(int file, struct stat *out) { return status_of(file, "", out, AT_EMPTY_PATH); }
int fstatat(int folder, const char *path, struct stat *out, int flags) { return status_of(folder, path, out, flags); }
int stat64(const char *path, struct stat64 *out) { return stat(path, (struct stat *)out); }
int lstat64(const char *path, struct stat64 *out) { return lstat(path, (struct stat *)out); }
int fstat64(int file, struct stat64 *out) { return fstat(file, (struct stat *)out); }
int fstatat64(int folder, const char *path, struct stat64 *out, int flags) { return fstatat(folder, path, (struct stat *)out, flags); }
DIR *opendir(const char *path) {
  NEXT(opendir);
  return hit(kList) ? NULL : next_opendir(path);
}
DIR *fdopendir(int file) {
  NEXT(fdopendir);
  return hit(kList) ? NULL : next_fdopendir(file);
}
struct dirent *readdir(DIR *folder) {
  NEXT(readdir);
  return hit(kList) ? NULL : next_readdir(folder);
}
struct dirent64 *readdir64(DIR *folder) { return (struct dirent64 *)readdir(folder); }

int fsync(int file) { return hit(kFsync) ? -1 : (int)syscall(SYS_fsync, file); }
int fdatasync(int file) { return hit(kFsync) ? -1 : (int)syscall(SYS_fdatasync, file); }
int rename(const char *from, const char *to) { return hit(kRename) ? -1 : (int)syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to); }
int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags) {
  if (hit(kPlace)) return -1;
  if ((flags & RENAME_EXCHANGE) && getenv("SURVEYMC_FAULT_NO_EXCHANGE")) return errno = EINVAL, -1;
  return (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, flags);
}
int ftruncate(int file, off_t size) { return hit(kFtruncate) ? -1 : (int)syscall(SYS_ftruncate, file, size); }
int ftruncate64(int file, off64_t size) { return hit(kFtruncate) ? -1 : (int)syscall(SYS_ftruncate, file, size); }
int mkdir(const char *path, mode_t mode) { return hit(kMkdir) ? -1 : (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode); }
/* As Linux does: the descriptor is gone, whatever is returned. */
int close(int file) {
  const int fails = is_regular(file) && hit(kClose);
  const int result = (int)syscall(SYS_close, file);
  if (fails) errno = chosen_errno;
  return fails ? -1 : result;
}
void *mmap(void *address, size_t size, int protection, int flags, int file, off_t at) {
  if (hit(kMmap)) return MAP_FAILED;
  return (void *)syscall(SYS_mmap, address, size, protection, flags, file, at);
}
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
void *malloc(size_t size) { return hit(kMalloc) ? NULL : __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return hit(kMalloc) ? NULL : __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { return hit(kMalloc) ? NULL : __libc_realloc(old, size); }
