#include <csignal>

#include "client/command.h"
#include "core/base/log.h"

int main(int argc, char** argv) {
  // A reader that has gone ends no work: what is said to it goes nowhere, and files are written all the same.
  std::signal(SIGPIPE, SIG_IGN);
  lodestar::InitLog("lodestar");
  return lodestar::RunCli(argc, argv);
}
