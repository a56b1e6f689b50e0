// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace trilat {

// Secrets that the recording machine shares with agents, by their names. The recording machine has those of
// all its agents, an agent has its own.
using TlsKeys = std::map<std::string, std::vector<unsigned char>>;

// A file of keys as make_tls_keys() writes it: a line of a name and its 64 hexadecimal digits each.
// InputError with the place where it cannot be read, others may read it, or a line is something else.
TlsKeys read_tls_keys(const std::filesystem::path& path);

// Makes a key for each agent in `folder`: NAME.key, and all of them in recorder.keys, to which later ones are
// added. Only their owner may read the files. Returns the agents' files; nothing is ever overwritten:
// InputError for a bad name or an agent that has its file already.
std::vector<std::filesystem::path> make_tls_keys(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& agents);

}  // namespace trilat
