// SPDX-License-Identifier: MIT
#include "datasets/base/content_hash.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include <openssl/evp.h>

#include "datasets/base/error.h"

namespace trilat {

struct ContentHash::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {
  TRILAT_CHECK(state_->context && EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1,
               "SHA-256 is available");
}

ContentHash::~ContentHash() = default;

void ContentHash::add(const void* data, std::size_t size) {
  TRILAT_CHECK(EVP_DigestUpdate(state_->context, data, size) == 1, "the hash takes more bytes");
}

std::string ContentHash::finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  TRILAT_CHECK(EVP_DigestFinal_ex(state_->context, digest.data(), &length) == 1, "the hash is finished once");
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

std::string hash_of_text(std::string_view text) {
  ContentHash hash;
  hash.add(text.data(), text.size());
  return hash.finish();
}

std::string hash_of_file(const std::filesystem::path& path, const std::function<bool()>& stop_requested) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw InputError(path.string(), std::strerror(errno));
  ContentHash hash;
  std::vector<char> block(1 << 18);
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), file.get())) {
    if (stop_requested && stop_requested()) throw Interrupted();
    hash.add(block.data(), count);
  }
  if (std::ferror(file.get())) throw InputError(path.string(), "cannot be read to its end");
  return hash.finish();
}

}  // namespace trilat
