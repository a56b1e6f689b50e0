// SPDX-License-Identifier: MIT
#include <vector>

#include "datasets/base/error.h"
#include "datasets/import/import_types.h"
#include "datasets/import/xef_reader.h"
#include "tests/fuzz/memory_file.h"

namespace trilat {
namespace {

void read_everything(const std::filesystem::path& path) {
  XefReader reader(path);
  std::vector<std::byte> depth(xef::kDepthBytes), bodies(xef::kBodyFrameBytes);
  for (XefEvent event; reader.next(event);) {
    try {
      reader.read_payload(event, event.kind == xef::StreamKind::depth ? depth : bodies);
      if (event.kind == xef::StreamKind::bodies) xef::body_payload(bodies);
    } catch (const TornRow&) {
    }
  }
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const trilat::MemoryFile file({data, size});
  try {
    trilat::read_everything(file.path());
  } catch (const trilat::InputError&) {
  }
  return 0;
}
