// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace trilat {

// The objects of a file that is one JSON array, each as text, in blocks: the array may be of any length.
class JsonElements {
 public:
  // InputError when the file cannot be opened or does not begin with '['.
  explicit JsonElements(const std::filesystem::path& path);

  // The next object's text; false behind the last. TornRow when the file ends within the array; InputError
  // for an object beyond 1 MiB or anything else than objects.
  bool next(std::string& text);
  // "file.json:line 3, byte 1234", where the object read last begins.
  std::string place() const;
  std::uint64_t bytes_read() const { return byte_; }

 private:
  int get();
  int get_past_blanks();

  std::string path_;
  std::ifstream stream_;
  std::uint64_t byte_ = 0, begin_ = 0;
  std::int64_t line_ = 1, begin_line_ = 1;
  bool ended_ = false, first_ = true;
};

}  // namespace trilat
