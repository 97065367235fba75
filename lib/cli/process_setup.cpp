#include "cli/process_setup.h"

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cfenv>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "cli/exit_codes.h"
#include "simd/numerics_probe.h"
#include "store/atomic_file.h"

namespace surveymc::cli {
namespace {

/// HDF5 calls exit(-1) where it gets no memory for some of its own records.
void report_end_by_library() {
#if defined(__GLIBC__)
  static const pid_t program = getpid();  // children that read a file end as they are
  const auto tell = [](int status, void*) {
    if (status != -1 || getpid() != program) return;
    store::AtomicFile::remove_all();
    std::fputs(kOutOfMemory, stderr);
    _exit(kInternal);
  };
  const int refused = on_exit(tell, nullptr);
  (void)refused;  // then such an end has no message
#endif
}

}  // namespace

void fill_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF) {
      // Only to be read: what is printed to a closed output still is an error there.
      const int opened = open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
      (void)opened;  // the lowest free number is this one
    }
}

std::string set_up_process() {
  report_end_by_library();
  fill_standard_descriptors();
  std::fesetenv(FE_DFL_ENV);  // a library may have changed it when it was loaded: bits must not depend on that
  simd::fix_block_sizes();
  std::signal(SIGXFSZ, SIG_IGN);  // a file-size limit then is an error of write(), with a message, and does not kill us
  return provide_stacks();
}

}  // namespace surveymc::cli
