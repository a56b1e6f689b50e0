// SPDX-License-Identifier: MIT
#include "datasets/base/paths_inside.h"

#include <algorithm>

#include "datasets/base/error.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

bool lies_in(const fs::path& folder, const fs::path& path) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

std::string way_out_of(const fs::path& folder, const fs::path& path) {
  if (path.is_absolute()) return "is absolute";
  if (const fs::path plain = path.lexically_normal(); !plain.empty() && *plain.begin() == "..")
    return "leads out of the folder by ..";
  std::error_code error;
  const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
  if (error) return {};  // no folder, nothing in it
  const fs::path whole = fs::weakly_canonical(root / path, error);
  if (error) return "cannot be followed: " + error.message();
  if (!lies_in(root, whole)) return "leads out of the folder by a symbolic link, to " + whole.string();
  if (is_special(whole)) return "is a device, a pipe or a socket";
  return {};
}

fs::path path_within(JsonObject& object, const std::string& key, const fs::path& folder,
                     OutsidePaths outside) {
  const std::string path = object.text(key);
  if (path.empty()) object.refuse(key, "must name a file");
  const std::string way = outside == OutsidePaths::allowed ? "" : way_out_of(folder, path);
  if (!way.empty())
    object.refuse(key, "\"" + path + "\" " + way + "; files must lie in the folder of " +
                           fs::path(object.file()).filename().string() +
                           ", beside or below it. --allow-outside allows others, for data that you trust");
  return folder / path;
}

}  // namespace trilat
