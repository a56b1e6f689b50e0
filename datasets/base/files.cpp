// SPDX-License-Identifier: MIT
#include "datasets/base/files.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

[[noreturn]] void refuse(const std::filesystem::path& path, const char* doing) {
  throw InputError(path.string(), std::string("cannot be ") + doing + ": " + std::strerror(errno));
}

[[noreturn]] void refuse_output(const std::filesystem::path& path, const char* doing) {
  throw OutputError(path.string(), std::string("cannot be ") + doing + ": " + std::strerror(errno));
}

namespace fs = std::filesystem;

bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

void sync_file(const std::filesystem::path& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0 || ::fsync(file.fd) != 0) refuse_output(path, "synced to disk");
}

std::string_view foreign_kind(std::string_view first_bytes) {
  constexpr std::pair<std::string_view, std::string_view> kKinds[] = {
      {"version https://git-lfs", "is a pointer of Git LFS; `git lfs pull` fetches the file itself"},
      {"<!DOCTYPE", "is a web page, saved in place of the file; download the file itself"},
      {"<!doctype", "is a web page, saved in place of the file; download the file itself"},
      {"<html", "is a web page, saved in place of the file; download the file itself"},
      {"\xFF\xFE", "is text in UTF-16; save the file as UTF-8"},
      {"\xFE\xFF", "is text in UTF-16; save the file as UTF-8"},
      {"PK\x03\x04", "is a spreadsheet or an archive; unpack it, or save the table as CSV"},
      {"\xD0\xCF\x11\xE0", "is a spreadsheet; save the table as CSV"},
      {"\x1F\x8B", "is compressed; unpack it first"},
      {"7z\xBC\xAF", "is compressed; unpack it first"},
      {"PAR1", "is Parquet; write positions as CSV or TRC"},
      {"\x80\x04", "is a pickle of Python; write positions as CSV or TRC"},
      {"\x80\x05", "is a pickle of Python; write positions as CSV or TRC"},
      {"\x89HDF", "is HDF5, as sessions and the takes of results are"},
      {"\x93NUMPY", "is an array of numpy; write it with write_joints() of the Python package"},
      {"MATLAB 5", "is a MAT-file of MATLAB; write positions as CSV or TRC"},
      {"EVENTS1", "is a recording of Kinect Studio, which is not read"},
      {"\x1A\x45\xDF\xA3",
       "is a video (Matroska), as the Azure Kinect's recorder writes; `python3 -m trilat.convert "
       "azure-kinect` takes the JSON that Microsoft's offline_processor makes of it"},
      {"#ROSBAG", "is a bag of ROS; write positions as CSV or TRC"},
      {"\x89PNG", "is a picture"},
      {"\xFF\xD8\xFF", "is a picture"},
      {std::string_view("\0\0\0\0", 4), "begins with zeros; was it copied whole?"},
      {"%PDF", "is a PDF"}};
  for (const auto& [begin, kind] : kKinds)
    if (first_bytes.starts_with(begin)) return kind;
  return {};
}

std::filesystem::path partial_name(const std::filesystem::path& path) { return path.string() + ".partial"; }

void publish_file(const std::filesystem::path& partial, const std::filesystem::path& path) {
  sync_file(partial);
  if (std::rename(partial.c_str(), path.c_str()) != 0) refuse_output(path, "put in place");
  // the name, too, survives the power; some file systems cannot sync a folder
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const Descriptor entry{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (entry.fd >= 0) (void)::fsync(entry.fd);
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  fs::path partial;  // another one for each writer
  {
    Descriptor file;
    for (int number = 0; file.fd < 0; ++number) {
      partial = partial_name(path.string() + fmt::format(".{}.{}", ::getpid(), number));
      file.fd = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (file.fd < 0 && errno != EEXIST) refuse_output(path, "written");
    }
    while (!text.empty()) {
      const ssize_t count = ::write(file.fd, text.data(), text.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        const int reason = errno;
        ::unlink(partial.c_str());
        errno = reason;
        refuse_output(path, "written");
      }
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  try {
    publish_file(partial, path);
  } catch (const InputError&) {
    ::unlink(partial.c_str());
    throw;
  }
}

std::string read_file(const std::filesystem::path& path, std::size_t limit_bytes) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) refuse(path, "opened");
  std::string text;
  char block[1 << 16];
  while (const std::size_t count = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, count);
    if (text.size() > limit_bytes)
      throw InputError(path.string(),
                       "is larger than the " + std::to_string(limit_bytes) + " bytes allowed here");
  }
  if (std::ferror(file.get())) refuse(path, "read");
  return text;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw InputError(folder.string(), "cannot be made a folder: " + error.message());
}

void check_output_file(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    throw InputError(path.string(), "is a folder; give the name of a file");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error))
    throw InputError(path.string(), "cannot be written: the folder " + folder.string() + " does not exist");
}

bool is_plain_name(std::string_view text) {
  return !text.empty() && text.size() <= 100 && text[0] != '.' && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  });
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool lies_in(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

bool is_special_file(const fs::path& path) { return is_special(path); }

FolderLock::FolderLock(const std::filesystem::path& folder) : name_(folder.string() + ".lock") {
  for (;;) {
    file_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0)
      throw OutputError(name_.string(), std::string("cannot be created: ") + std::strerror(errno));
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      ::close(file_);
      if (reason != EWOULDBLOCK)
        throw OutputError(name_.string(), std::string("cannot be locked: ") + std::strerror(reason));
      throw InputError(folder.string(),
                       "is being written by another process; wait for it or take another name");
    }
    // the previous holder may have removed the file meanwhile: then the lock is on a file without a name
    struct stat mine, there;
    if (::fstat(file_, &mine) == 0 && ::stat(name_.c_str(), &there) == 0 && mine.st_ino == there.st_ino)
      return;
    ::close(file_);
  }
}

FolderLock::~FolderLock() {
  ::unlink(name_.c_str());
  ::close(file_);
}

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
