// SPDX-License-Identifier: MIT
// pipe_to_port HOST:PORT: carries standard input and output to a port of this machine, as ssh would to a
// recorder. For trying an agent's --via on Windows.
#include <cstdio>
#include <cstdlib>
#include <thread>
#ifdef _WIN32
#include <fcntl.h>
#include <io.h>
#else
#include <unistd.h>
#endif

#include "recorders/link/byte_stream.h"

int main(int argc, char** argv) {
#ifdef _WIN32
  _setmode(0, _O_BINARY);
  _setmode(1, _O_BINARY);
#endif
  if (argc != 2) return 2;
  try {
    const auto port = trilat::connect_loopback(trilat::parse_address(argv[1]));
    std::thread([&port] {
      std::byte block[4096];
      for (int count; (count = static_cast<int>(::read(0, block, sizeof block))) > 0;)
        port->write_all(std::span<const std::byte>(block).first(static_cast<std::size_t>(count)));
      std::_Exit(0);
    }).detach();
    std::byte block[4096];
    while (true) {
      const std::size_t count = port->read_some(block, std::chrono::milliseconds(50));
      std::fwrite(block, 1, count, stdout);
      std::fflush(stdout);
    }
  } catch (const std::exception&) {
    return 1;
  }
}
