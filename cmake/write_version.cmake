# Writes OUTPUT (version.h) with VERSION, COMPILER and the git revision of SOURCE_DIR, "unknown" outside a checkout.
cmake_policy(VERSION 3.25)
execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12
                OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR revision STREQUAL "")
  set(revision "unknown")
endif()
# Two trees with changes of their own, or two copies without a repository, are two programs: the sources tell them apart.
if(revision MATCHES "unknown|-dirty$")
  file(GLOB_RECURSE sources ${SOURCE_DIR}/lib/* ${SOURCE_DIR}/experiments/* ${SOURCE_DIR}/cmake/* ${SOURCE_DIR}/third_party/*)
  list(APPEND sources ${SOURCE_DIR}/CMakeLists.txt)  # the options of the compiler
  list(SORT sources)
  set(hashes "")
  foreach(source ${sources})
    file(SHA256 ${source} hash)
    string(APPEND hashes ${hash})
  endforeach()
  string(SHA256 hash "${hashes}")
  string(SUBSTRING ${hash} 0 12 hash)
  string(APPEND revision ".${hash}")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"#pragma once
inline constexpr char kVersion[] = \"@VERSION@\";
inline constexpr char kGitRevision[] = \"@revision@\";
inline constexpr char kCompiler[] = \"@COMPILER@\";
inline constexpr char kLibraries[] = \"@LIBRARIES@\";
")
