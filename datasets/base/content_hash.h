// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace trilat {

// SHA-256 of a stream of bytes, the same as the `sha256sum` command prints.
class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;
  void add(const void* data, std::size_t size);
  // 64 hexadecimal digits; the hash cannot be added to afterwards.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string hash_of_text(std::string_view text);
// Streams the file in blocks; InputError when it cannot be read, Interrupted when asked to stop.
std::string hash_of_file(const std::filesystem::path& path, const std::function<bool()>& stop_requested = {});

}  // namespace trilat
