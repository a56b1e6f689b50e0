// SPDX-License-Identifier: MIT
#include <csignal>

#include <gmock/gmock.h>
#include <sys/resource.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/hdf5_file.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

// As long as it lives, no file of this process grows beyond so many bytes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*signal_)(int);
};

// The library keeps rows in memory until their table is closed, where nobody asks whether that went well.
void write_and_lose(H5File& file, const H5Layout& layout) {
  H5Table table = file.create_group("takes").create_table("rows", H5Type::f64, {}, layout, 100);
  table.write(0, std::span<const double>(std::vector<double>(100, 1.0)));
  const FileSizeLimit full(16);
  const H5Table gone = std::move(table);
}

TEST(LostRows, AFileWhoseTableCouldNotBeClosedCannotBeClosedEither) {
  for (const H5Layout& layout : {H5Layout{}, H5Layout{.chunk_rows = 50, .checksum = true}}) {
    const ScratchFolder folder;
    H5File file = H5File::create(folder / "a.h5");
    write_and_lose(file, layout);
    EXPECT_THROW(file.close(), OutputError);
  }
}

TEST(LostRows, AFileIsNotClosedWhileAGroupOfItKeepsItOpen) {
  const ScratchFolder folder;
  H5File file = H5File::create(folder / "a.h5");
  const H5Node group = file.create_group("takes");
  EXPECT_THROW(file.close(), InternalError);
}

}  // namespace
}  // namespace trilat
