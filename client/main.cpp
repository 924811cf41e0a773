#include "client/command.h"
#include "core/base/log.h"

int main(int argc, char** argv) {
  lodestar::InitLog("lodestar");
  return lodestar::RunCli(argc, argv);
}
