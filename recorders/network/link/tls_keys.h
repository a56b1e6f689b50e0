// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace trilat {

// Makes what is missing of a set of keys in `folder`: ca.pem (the authority; keep it where keys are made),
// server.pem for the recording machine and NAME.pem for each agent, with private key, certificate and the
// authority's certificate in one file that only its owner may read. Returns the files made. Nothing is ever
// overwritten: InputError for a bad name or an agent that has its file already.
std::vector<std::filesystem::path> make_tls_keys(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& agents);

}  // namespace trilat
