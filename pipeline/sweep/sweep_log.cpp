// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_log.h"

#include <fstream>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr std::size_t kMostPendingBytes = std::size_t{1} << 22;

}  // namespace

SweepLog::SweepLog(const std::filesystem::path& folder)
    : finished_(folder / kFinished), open_(folder / kOpen) {}

void SweepLog::restore(const std::function<bool(SweepRecord&&)>& accept) {
  std::uintmax_t good_bytes = 0;
  {
    std::ifstream file(finished_);
    for (std::string line; std::getline(file, line) && !file.eof();) {  // the end of a file ends no line
      std::optional<SweepRecord> record = read_sweep_record(line, finished_.string());
      if (!record || !accept(std::move(*record))) break;
      good_bytes += line.size() + 1;
    }
  }
  if (std::filesystem::exists(finished_)) std::filesystem::resize_file(finished_, good_bytes);
}

std::optional<SweepRecord> SweepLog::open_cell() const {
  std::ifstream file(open_);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  return read_sweep_record(line, open_.string());
}

void SweepLog::add(const SweepRecord& finished) {
  pending_ += line_of(finished) + '\n';
  if (pending_.size() > kMostPendingBytes) append_pending();
}

void SweepLog::append_pending() {
  std::ofstream file(finished_, std::ios::binary | std::ios::app);
  file.write(pending_.data(), static_cast<std::streamsize>(pending_.size()));
  file.flush();
  if (!file) throw OutputError(finished_.string(), "cannot be written");
  pending_.clear();
}

// In this order: an open cell on the disk means that all before it are there.
void SweepLog::save(const SweepRecord* open) {
  append_pending();
  sync_file(finished_);
  if (open != nullptr) write_file(open_, line_of(*open) + '\n');
}

}  // namespace trilat
