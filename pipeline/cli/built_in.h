// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/base/json.h"

namespace trilat {

// The scales that `trilat reproduce` knows, the smallest first; the documents that are built in say under
// "scales", as a JSON merge patch, what each changes of them. The last changes nothing.
inline const std::vector<std::string> kScales{"demo", "quick", "paper", "full"};

// A document of pipeline/studies at a scale, without its "scales". InternalError for a name that is none.
Json built_in_study(const std::string& name, const std::string& scale = "full");
Json built_in_campaign(const std::string& name, const std::string& scale = "full");

std::vector<std::string> built_in_studies();

}  // namespace trilat
