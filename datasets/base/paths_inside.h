// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "datasets/base/strict_json.h"

namespace trilat {

// Whether a document may name files outside the folder it lies in. What comes with other people's data may
// not.
enum class OutsidePaths { refused, allowed };

// Whether `path` is `folder` or below it, by their names alone.
bool lies_in(const std::filesystem::path& folder, const std::filesystem::path& path);

// Where the path `path`, relative to `folder`, leads out of it: by being absolute, by `..` or by a symbolic
// link. Also says so of what is neither a file nor a folder. Empty where nothing is wrong; what is not there
// is not.
std::string way_out_of(const std::filesystem::path& folder, const std::filesystem::path& path);

// The path under `key` of a document in `folder`; InputError with the pointer when it is empty, or leads out
// and may not.
std::filesystem::path path_within(JsonObject& object, const std::string& key,
                                  const std::filesystem::path& folder, OutsidePaths outside);

}  // namespace trilat
