#pragma once
namespace surveymc::simd {

/// Levels of x86-64 that kernels are built for (lanes.h). Both give the same bits.
enum class InstructionSet { v3, v4 };

/// The best that this processor has. The environment variable SURVEYMC_INSTRUCTION_SET = "x86-64-v3" asks for less.
InstructionSet instruction_set();

/// "x86-64-v3" or "x86-64-v4".
const char* name(InstructionSet set);

}  // namespace surveymc::simd
