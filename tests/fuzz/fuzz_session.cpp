// SPDX-License-Identifier: MIT
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "tests/fuzz/memory_file.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

void read_everything(const std::filesystem::path& path) {
  const SessionReader session(path);
  verify_session(session, {});
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    session.body_frames(s, 0, std::min<std::uint64_t>(session.counts(s).body_frames, 4096));
    session.clock_exchanges(s);
    session.drop_counts(s);
    session.notices(s);
  }
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const trilat::MemoryFile file({data, size});
  trilat::tolerate_bad_input([&] { trilat::read_everything(file.path()); });
  return 0;
}
