// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

namespace trilat {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();  // a number that is not known
inline constexpr double kMetresPerMillimetre = 1e-3;
inline constexpr double kMetresPerCentimetre = 1e-2;
inline constexpr double kCentimetresPerMetre = 100.0;
inline constexpr double kSquareMetresPerSquareCentimetre = 1e-4;
inline constexpr double kRadPerDegree = std::numbers::pi / 180.0;
inline constexpr double kDegreesPerRad = 180.0 / std::numbers::pi;
inline constexpr std::int64_t kNsPerSecond = 1'000'000'000;
inline constexpr double kNsPerMicrosecond = 1e3;

// The length units an OptiTrack export may name.
enum class LengthUnit { metre, centimetre, millimetre, inch, foot };

// "Meters", "millimeters", "mm", … in any case; nothing for an unknown word.
std::optional<LengthUnit> length_unit_from_text(std::string_view text);
std::string_view name_of(LengthUnit unit);  // "metre", …
double metres_per(LengthUnit unit);

// "; as centimetres it would be 1.5" of a length that is none in metres, where it is one in another unit;
// else empty.
std::string in_metres_text(double length, double min_m, double max_m);

}  // namespace trilat
