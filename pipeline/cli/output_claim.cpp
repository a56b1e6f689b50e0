// SPDX-License-Identifier: MIT
#include "pipeline/cli/output_claim.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

bool has_no_bytes(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::file_size(path, error) == 0 && !error;
}

}  // namespace

OutputClaim::OutputClaim(const std::filesystem::path& output) : partial_(partial_name(output)) {
  check_output_file(output);
  const int file = ::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file >= 0) {
    ::close(file);
    return;
  }
  if (errno != EEXIST)
    throw OutputError(partial_.string(), std::string("cannot be created: ") + std::strerror(errno));
  throw InputError(
      partial_.string(),
      has_no_bytes(partial_)
          ? "exists and is empty: another recorder waits with this name, or was killed while it "
            "waited; then remove it"
          : "exists; another recorder writes it, or was killed: then `trilat recover` it, or take "
            "another name");
}

OutputClaim::~OutputClaim() {
  std::error_code ignored;
  if (has_no_bytes(partial_)) std::filesystem::remove(partial_, ignored);
}

}  // namespace trilat
