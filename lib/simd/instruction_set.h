#pragma once
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

/// "x86-64-v3" or "x86-64-v4"; "portable" in a portable build.
const char* name(InstructionSet set);

}  // namespace surveymc::simd
