// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace trilat {

// Gives the path of a new seed of a fuzzer.
using SeedPath = std::function<std::filesystem::path(const std::string& fuzzer, const std::string& name)>;

// Seeds of the fuzzers whose first byte chooses a reader, which stands there as the reader's number.
void write_settings_seeds(const SeedPath& seed);
// Leaves sound results in the folder `sound`.
void write_results_seeds(const SeedPath& seed, const std::filesystem::path& sound);
void write_tls_seeds(const SeedPath& seed);

}  // namespace trilat
