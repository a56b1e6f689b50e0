// SPDX-License-Identifier: MIT
// Motive exports as text, and how they are read or refused.
#pragma once

#include <string>

#include "datasets/base/error.h"
#include "datasets/mocap/read_mocap.h"
#include "tests/datasets/temporary_file.h"
#include "tests/support/whole_take.h"

namespace trilat::motive {

inline std::string keys(const std::string& version, const std::string& unit = "Meters") {
  return "Format Version," + version +
         ",Take Name,walk,Take Notes,,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,Capture "
         "Start Time,2024-05-01 10.00.00.000 DU.,Total Frames in Take,9,Total Exported Frames,9,Rotation "
         "Type,Quaternion,Length Units," +
         unit + ",Coordinate Space,Global\n";
}

inline std::string repeat(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

// A rigid body with an error column, and a marker of the same name.
inline const std::string kHeadings = ",Type" + repeat(",Rigid Body", 8) + repeat(",Marker", 3) + "\n,Name" +
                                     repeat(",Wand", 11) + "\n,ID" + repeat(",\"1F\"", 8) +
                                     repeat(",\"2A:77\"", 3) + "\n,,Rotation,Rotation,Rotation,Rotation," +
                                     "Position,Position,Position,Mean Marker Error" + repeat(",Position", 3) +
                                     "\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n";
inline const std::string kRows =
    "0,0.000000,0,0,0,1,1.5,2.5,-3.5,0.0001,4,5,6\n"
    "1,0.010000,0,0,0,1,1.6,2.5,-3.5,0.0001,,,\n"
    "2,0.020000,,,,,,,,,4,5,7\n";

inline const std::string kMarkerHeadings =
    ",Type,Marker,Marker,Marker\n,Name,a,a,a\n,ID,\"1\",\"1\",\"1\"\n,,Position,Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z\n";

inline WholeTake read(const std::string& text) { return whole_take(TemporaryFile(text).path()); }

struct Refusal {
  std::string place;
  std::string problem;
};

inline Refusal csv_refusal(const std::string& text) {
  const TemporaryFile file(text);
  try {
    whole_take(file.path());
  } catch (const InputError& error) {
    const std::string& place = error.place();
    const std::size_t size = file.path().string().size();
    if (place.starts_with(file.path().string()))
      return {std::string("F").append(place, size), error.problem()};
    return {place, error.problem()};
  }
  return {"", "was read"};
}

}  // namespace trilat::motive
