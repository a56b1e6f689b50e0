// SPDX-License-Identifier: MIT
#include "recorders/network/link/tls_keys.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>

#include <fcntl.h>
#include <openssl/crypto.h>
#include <openssl/err.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "recorders/network/link/wire.h"

namespace trilat {
namespace {

constexpr std::size_t kKeyBytes = 32, kHexBytes = 2 * kKeyBytes + 1;
constexpr const char* kRecorder = "recorder.keys";

void write_secret(const std::filesystem::path& path, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0) throw OutputError(path.string(), std::string("cannot be made: ") + std::strerror(errno));
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const bool closed = ::fsync(fd) == 0 && ::close(fd) == 0;
  if (written && closed) return;
  ::unlink(path.c_str());
  throw OutputError(path.string(), "cannot be written to its end");
}

std::string text_of(const TlsKeys& keys) {
  std::string text;
  for (const auto& [name, key] : keys) {
    char hex[kHexBytes];
    TRILAT_CHECK(OPENSSL_buf2hexstr_ex(hex, sizeof hex, nullptr, key.data(), key.size(), '\0') == 1,
                 "a key has 64 digits");
    text += name + " " + hex + "\n";
  }
  return text;
}

bool is_agent_name(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameBytes && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

}  // namespace

TlsKeys read_tls_keys(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0)
    throw InputError(path.string(), "holds secrets that others may read; chmod 600 is right");
  std::istringstream lines(read_file(path, 64u << 10));
  TlsKeys keys;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::string name = line.substr(0, line.find(' '));
    std::vector<unsigned char> key(kKeyBytes);
    std::size_t size = 0;
    const char* hex = line.c_str() + std::min(line.size(), name.size() + 1);
    const bool sound = is_agent_name(name) && line.size() == name.size() + kHexBytes &&
                       OPENSSL_hexstr2buf_ex(key.data(), key.size(), &size, hex, '\0') == 1 &&
                       size == kKeyBytes;
    ERR_clear_error();
    if (!sound || !keys.emplace(std::move(name), std::move(key)).second)
      throw InputError(
          path.string() + ":" + std::to_string(number),
          "must be a name, not given before, and 64 hexadecimal digits, as `trilat-agent keys` makes");
  }
  if (keys.empty()) throw InputError(path.string(), "holds no key; `trilat-agent keys` makes some");
  return keys;
}

std::vector<std::filesystem::path> make_tls_keys(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& agents) {
  const std::filesystem::path recorder = folder / kRecorder;
  TlsKeys all = std::filesystem::exists(recorder) ? read_tls_keys(recorder) : TlsKeys();
  std::map<std::filesystem::path, TlsKeys> made;
  for (const std::string& name : agents) {
    if (!is_agent_name(name))
      throw InputError('"' + name + '"', "is not a name for an agent: 1 to 64 letters, digits, - and _");
    const std::filesystem::path path = folder / (name + ".key");
    std::vector<unsigned char> key(kKeyBytes);
    TRILAT_CHECK(RAND_bytes(key.data(), static_cast<int>(key.size())) == 1, "OpenSSL has random bytes");
    if (std::filesystem::exists(path) || !all.emplace(name, key).second)
      throw InputError('"' + name + '"', "has a key already, which is not overwritten");
    made[path] = {{name, key}};
  }
  make_folder(folder);
  std::vector<std::filesystem::path> paths;
  for (const auto& [path, key] : made) {
    write_secret(path, text_of(key));
    paths.push_back(path);
  }
  if (paths.empty()) return paths;
  const std::filesystem::path partial = partial_name(recorder);
  std::filesystem::remove(partial);
  write_secret(partial, text_of(all));
  publish_file(partial, recorder);
  return paths;
}

}  // namespace trilat
