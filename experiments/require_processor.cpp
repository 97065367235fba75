/// Says so where the processor cannot run this program, which is built for x86-64-v3: without this, it ends with SIGILL
/// at some instruction. Compiled for any x86-64, and called before all that is not.
#include <unistd.h>

namespace {

constexpr int kNotThisMachine = 71;  // EX_OSERR, as where threads are missing (lib/cli/exit_codes.h)

void require_processor(int, char**, char**) {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
  constexpr char kText[] =
      "error: surveymc needs a processor with AVX2 and FMA (x86-64-v3: Intel since 2013, AMD since 2015): run it on "
      "another machine, or build it for any processor with -DSURVEYMC_PORTABLE=ON\n";
  [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, kText, sizeof kText - 1);
  _exit(kNotThisMachine);
}

}  // namespace

/// The loader calls these before any constructor of the program or of a library.
[[gnu::section(".preinit_array"), gnu::used]] void (*g_require_processor)(int, char**, char**) = require_processor;
