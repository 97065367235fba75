#include "simd/instruction_set.h"

#include <cstdlib>
#include <cstring>

namespace surveymc::simd {

#if defined(SURVEYMC_PORTABLE)

const char* name(InstructionSet) { return "portable"; }

#else

namespace {

InstructionSet detect() {
  const char* wanted = std::getenv("SURVEYMC_INSTRUCTION_SET");
  if (wanted && std::strcmp(wanted, "x86-64-v3") == 0) return InstructionSet::v3;
  const bool v4 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                  __builtin_cpu_supports("avx512vl");
  return v4 ? InstructionSet::v4 : InstructionSet::v3;
}

}  // namespace

InstructionSet instruction_set() {
  static const InstructionSet set = detect();
  return set;
}

const char* name(InstructionSet set) { return set == InstructionSet::v4 ? "x86-64-v4" : "x86-64-v3"; }

#endif

}  // namespace surveymc::simd
