// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "datasets/import/import_types.h"

namespace trilat {

using ImportFunction = ImportReport (*)(const std::vector<std::filesystem::path>& files,
                                        const std::filesystem::path& output, const ImportOptions& options);

struct ImportFormat {
  const char* name;
  const char* what;  // for people: which files, and what is known of them
  ImportFunction import;
};

// Every format there is, by name.
std::span<const ImportFormat> import_formats();

// Writes `output` from the files; InputError with the place for what cannot be meant, and for an unknown
// format with the list. Nothing is left behind then.
ImportReport import_recording(const std::string& format, const std::vector<std::filesystem::path>& files,
                              const std::filesystem::path& output, const ImportOptions& options);

}  // namespace trilat
