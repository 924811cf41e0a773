// A farm behind a port.
#pragma once

#include <memory>
#include <string>

#include "coordinator/farm.h"

namespace lodestar {

class Server {
 public:
  struct Options {
    std::string listen = "127.0.0.1:0";  // port 0: one that is free
    bool insecure = false;               // also listen where others than this machine can reach it
  };
  // Throws Error(kInvalidInput) for what is no HOST:PORT, and for an address that is not loopback without `insecure`:
  // what is wrong with an address whoever holds it.
  static void CheckAddress(const Options& options);
  // Throws as CheckAddress does, and Error(kIo) for a port that is taken.
  Server(Farm& farm, const Options& options);
  ~Server();  // ends the calls under way
  int port() const;
  const std::string& address() const;  // host:port

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lodestar
