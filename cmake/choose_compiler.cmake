# Before project(): Clang where it is installed and nobody names a compiler. It gives the same bits as GCC, and a fresh
# build takes it less processor time. A build folder keeps the compiler that it has.
if(NOT CMAKE_C_COMPILER AND NOT CMAKE_CXX_COMPILER AND NOT CMAKE_TOOLCHAIN_FILE AND NOT DEFINED ENV{CXX} AND NOT DEFINED ENV{CC})
  find_program(clang NAMES clang-19 clang NO_CACHE)
  find_program(clangxx NAMES clang++-19 clang++ NO_CACHE)
  if(clang AND clangxx)
    set(CMAKE_C_COMPILER ${clang} CACHE FILEPATH "C compiler")
    set(CMAKE_CXX_COMPILER ${clangxx} CACHE FILEPATH "C++ compiler")
  endif()
endif()
