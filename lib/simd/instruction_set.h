#pragma once
#include <utility>

/// Declares a kernel of both instruction sets, in namespaces isa_v3 and isa_v4 (lanes.h).
#define SURVEYMC_KERNEL(...) \
  namespace isa_v3 {         \
  __VA_ARGS__;               \
  }                          \
  namespace isa_v4 {         \
  __VA_ARGS__;               \
  }

namespace surveymc::simd {

/// Levels of x86-64 that kernels are built for (lanes.h). Both give the same bits.
enum class InstructionSet { v3, v4 };

#if defined(SURVEYMC_PORTABLE)
/// There is one variant of the kernels, in the place of v3; the compiler leaves out what would call the other.
consteval InstructionSet instruction_set() { return InstructionSet::v3; }
#else
/// The best set that this processor has. The environment variable SURVEYMC_INSTRUCTION_SET = "x86-64-v3" asks for the
/// smaller one.
InstructionSet instruction_set();
#endif

/// Calls the variant of a kernel that is for instruction_set(): run_kernel<isa_v3::f, isa_v4::f>(arguments).
template <auto* kV3, auto* kV4, class... Arguments>
void run_kernel(Arguments&&... arguments) {
  if (instruction_set() == InstructionSet::v4)
    kV4(std::forward<Arguments>(arguments)...);
  else
    kV3(std::forward<Arguments>(arguments)...);
}

/// "x86-64-v3" or "x86-64-v4"; "portable" in a portable build.
const char* name(InstructionSet set);

}  // namespace surveymc::simd
