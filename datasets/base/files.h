// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace trilat {

// Writes text beside `path`, syncs it and renames it into place: the final name never shows half a file,
// and of several writers at once the last one's file stays.
// InputError with the path when the disk or the folder does not let us.
void write_file(const std::filesystem::path& path, std::string_view text);

// The whole file as text; InputError with the path when it cannot be read or is larger than `limit_bytes`.
std::string read_file(const std::filesystem::path& path, std::size_t limit_bytes = 64u << 20);

// Names the format of a file by its first bytes, and what its user can do, for formats that are not text,
// such as "is compressed; unpack it first". Empty for a file of any other format.
std::string_view foreign_kind(std::string_view first_bytes);

// `path` with ".partial" behind: the name of an output that is not finished.
std::filesystem::path partial_name(const std::filesystem::path& path);

// InputError when a file of this name could not be written: its folder does not exist, or it is a folder.
void check_output_file(const std::filesystem::path& path);

// Waits until the file is on the disk; OutputError when it cannot be.
void sync_file(const std::filesystem::path& path);

// Syncs `partial` and renames it to `path`.
void publish_file(const std::filesystem::path& partial, const std::filesystem::path& path);

// Makes the folder and its parents; InputError naming it when that cannot be done.
void make_folder(const std::filesystem::path& folder);

// Whether a text can be the name of a file or folder anywhere: 1 to 100 letters, digits, '-', '_' or '.', not
// starting with '.'.
bool is_plain_name(std::string_view text);

// ".csv" of walk.CSV.
std::string lower_extension(const std::filesystem::path& path);

// Whether `path` is `folder` or below it, by their names alone.
bool lies_in(const std::filesystem::path& folder, const std::filesystem::path& path);

// Whether the path names a device, a pipe or a socket.
bool is_special_file(const std::filesystem::path& path);

// Advisory lock (flock) of the process that fills a folder, on `folder`.lock beside it; the kernel releases
// it when the process ends.
class FolderLock {
 public:
  // InputError when another process has it; OutputError when there can be none.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path name_;
  int file_ = -1;
};

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
