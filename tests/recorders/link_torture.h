// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>

namespace trilat {

// Kills the recorder, the agent or both at random instants of a recording and starts them again; how many of
// so many trials did not end with all that the source made either in the session, once, or counted as lost.
int torture_with_kills(int trials, std::uint64_t seed, const std::filesystem::path& folder);

// The same with outages of the link of up to `longest_s`: nothing gets through, resets, half the bandwidth,
// odd splits.
int torture_with_outages(int trials, double longest_s, std::uint64_t seed,
                         const std::filesystem::path& folder);

// Cuts or flips a log at random places; how many logs gave a record that had not been written.
int torture_logs(int trials, std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace trilat
