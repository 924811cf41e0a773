# One set of code-generation flags for every target: the bit-identity contract (docs/decisions/0002-exact-sums.md)
# needs the same instructions everywhere, so the ISA is a fixed baseline and fused multiply-adds only happen where the source says so.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

set(LODESTAR_SANITIZE "" CACHE STRING "Sanitizers, e.g. address,undefined or thread")
option(LODESTAR_DCHECKS "Check internal invariants on hot paths" OFF)

add_compile_options(-Wall -Wextra -Wno-unused-parameter -march=x86-64-v3 -ffp-contract=off -fno-math-errno -fno-trapping-math)
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
# GCC 12 reports -Wrestrict for ordinary std::string concatenations (GCC bug 105651, fixed in 13): nothing of ours to mend.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict)
endif()
if(LODESTAR_DCHECKS)
  add_compile_definitions(LODESTAR_DCHECKS=1)
endif()
if(LODESTAR_SANITIZE)
  # Line tables (-g1) are all a report needs.
  add_compile_options(-fsanitize=${LODESTAR_SANITIZE} -fno-omit-frame-pointer -O1 -g1)
  add_link_options(-fsanitize=${LODESTAR_SANITIZE})
endif()

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
