// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace trilat {

// The path of a body under one uninterrupted tracking id of one sensor.
struct Tracklet {
  std::size_t sensor = 0;
  std::vector<std::int64_t> time_ns;               // host clock, rising
  std::vector<Eigen::Vector3d> centre_in_world_m;  // mean of the trunk's joints, one a time
};

struct PersonOptions {
  double same_m = 0.40;             // two sensors' median distance of one person is below this
  double least_overlap_s = 0.21;    // of two tracklets that are compared
  double longest_hole_s = 0.25;     // in a tracklet, across which its path is interpolated
  double longest_absence_s = 3.01;  // between two tracklets that are linked because one follows the other
  double fastest_m_s = 1.5;         // walking speed while no sensor sees the person; added to same_m
};

struct PersonMatch {
  std::size_t persons = 0;
  // One a tracklet. Person 0 is the one with the most frames, over all sensors; then the one seen first.
  std::vector<std::size_t> person_of_tracklet;
};

// Which tracklets are one person's. Two of one sensor that overlap in time never are. Those of different
// sensors speak for or against each other by their median distance and for how long they overlap; the
// clusters that have most in common are joined first, until nothing speaks for joining any more. Then what
// follows each other closely in space and time is linked, the nearest first, where nothing speaks against it.
// A ghost that fits nobody is a person of its own, with one of the last numbers. The order of tracklets does
// not matter but for exact ties. InternalError unless every tracklet has a place for each time, and one at
// least, and times rise.
[[nodiscard]] PersonMatch match_persons(std::span<const Tracklet> tracklets, const PersonOptions& options);

}  // namespace trilat
