# Writes OUTPUT (version.h) with VERSION, COMPILER and the git revision of SOURCE_DIR, "unknown" outside a checkout.
cmake_policy(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12
                OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR revision STREQUAL "")
  set(revision "unknown")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"#pragma once
inline constexpr char kVersion[] = \"@VERSION@\";
inline constexpr char kGitRevision[] = \"@revision@\";
inline constexpr char kCompiler[] = \"@COMPILER@\";
")
