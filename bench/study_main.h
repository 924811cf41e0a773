// How a study ends: with what its run returned, or with the message of what it was given wrong.
#pragma once

#include <cstdio>

#include "core/base/error.h"

namespace lodestar {

inline int StudyMain(int (*run)(int argc, char** argv), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}

}  // namespace lodestar
