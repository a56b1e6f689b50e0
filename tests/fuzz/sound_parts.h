// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace trilat {

// A file of a part folder, as our own writer made it.
struct SoundPartFile {
  std::string folder, name;
};

inline const std::vector<SoundPartFile> kSoundPartFiles{{"accuracy", "part.json"},
                                                        {"accuracy", "items/takes/p01-walking/item.json"},
                                                        {"accuracy", "hashes.json"},
                                                        {"sweep", "part.json"},
                                                        {"sweep", "items/trials/r1-c1-1/item.json"},
                                                        {"recording", "part.json"},
                                                        {"recording", "items/clocks/network-0/item.json"},
                                                        {"calibration", "part.json"},
                                                        {"calibration", "items/wand/unit-0/item.json"},
                                                        {"calibration", "items/rigs/run-0/item.json"}};

}  // namespace trilat
