// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/json.h"
#include "datasets/base/time.h"
#include "datasets/results/results_file.h"
#include "evaluators/alignment/alignment.h"
#include "pipeline/accuracy/methods/method_spec.h"

namespace trilat {

enum class ClockSource : std::uint8_t { stated, check, motion };
template <>
inline constexpr std::array words<ClockSource>{"stated", "check", "motion"};

// The truth that estimates are held against: the mocap of each take; what each sensor in turn sees, left out
// of every method; the first of these that the campaign allows; or nothing at all, which no file asks for.
enum class TruthSource : std::uint8_t { automatic, mocap, left_out_sensor, nothing };
template <>
inline constexpr std::array words<TruthSource>{"auto", "mocap", "left_out_sensor"};

// Frames of a sensor that count at an instant: those around it before and behind it, which only an offline
// evaluation has, or the newest frame that the recorder had by then, held, as a live system has it.
enum class FrameChoice : std::uint8_t { interpolated, newest };
template <>
inline constexpr std::array words<FrameChoice>{"interpolated", "newest"};

// Source of the sensor poses: what the takes state; or by the campaign's wand, all its places refined
// together, or the paper's two (eq. 6 and 7), corrected or as printed.
enum class PoseSource : std::uint8_t { stated, wand, two_positions, printed };
template <>
inline constexpr std::array words<PoseSource>{"stated", "wand", "two_positions", "printed"};

// Source of a frame's time. `offline`: its ticks and all exchanges of clocks. `exact`: as the simulator
// knows. As a live system: by its arrival and the exchanges until then, corrected (`causal`), or by eq. 20 to
// 22 as printed, which give the time on the clock of the sensor's computer (erratum E11).
enum class SensorClocks : std::uint8_t { offline, exact, causal, printed };
template <>
inline constexpr std::array words<SensorClocks>{"offline", "exact", "causal", "printed"};

// Settings between what was recorded and what methods see.
struct Stage {
  std::string name = {};  // a condition of the results; empty: the study has one stage
  PoseSource poses = PoseSource::stated;
  SensorClocks sensor_clocks = SensorClocks::offline;
  FrameChoice frames = FrameChoice::interpolated;
  // With the newest frame: one that arrives longer after its exposure is dropped; the paper's real time.
  double frame_late_s = 0.033;
  bool repair_exchanges = true;  // left and right that a sensor has exchanged are put right
  // Calibration of poses that are not the stated ones, filled by with_wand_poses(). A plan for people to read
  // does without.
  std::filesystem::path calibration = {};

  // Its settings, as a study has them too; and those of one of several stages, with its name.
  static void visit_settings(Stage& self, Fields& f);
  static void fields(Stage& self, Fields& f);
};
// In a document each has what its own keys change of the one before.
struct Stages : std::vector<Stage> {
  Stage before = {};  // the first
  void read(const Json& json, const JsonPlace& place, const About& about);
  Json json() const;
  static Json schema(const About& about);
};

// study.json, format 1, kind "accuracy": takes x methods -> errors.
struct StudySpec {
  std::string name;
  PaperStudy paper = PaperStudy::none;
  std::filesystem::path campaign;    // relative to the study's file; may be given on the command line instead
  std::vector<std::string> sensors;  // empty: those of the take that has most, the first of equals
  std::vector<std::string> joints;   // empty: all that the mappings map
  std::vector<std::string> conditions;  // activities whose takes are evaluated; empty: all
  bool occluded_apart = false;          // samples that a sensor sees occluded make conditions of their own
  TruthSource truth = TruthSource::automatic;
  std::string reference;  // the method that others are compared with; empty: the first
  std::vector<AlignmentKind> alignments{AlignmentKind::mean};
  double rate_hz = 30.0;  // of the instants that are evaluated
  // A sensor, and the ground truth, are not interpolated across a longer gap. No limit here is a multiple of
  // 1/30, 1/100 or 1/120 s: drift or rounding would decide whether a gap of as many frames is within it.
  double sensor_gap_s = 0.11;
  double truth_gap_s = 0.055;
  Stage stage = {};    // of all takes, where there are no stages
  Stages stages = {};  // every take is evaluated at each, and each is a condition
  // `run --cross-check` fails beyond: where the rig is nearly flat, rounding of the cost alone moves a
  // minimum by 1e-7.
  double cross_check_limit_m = 1e-6;
  // Whether the start of the mocap is taken as stated, also checked by motion, or corrected by it.
  ClockSource clock = ClockSource::check;
  double clock_search_s = 3.0;   // to both sides of the stated start
  double training_share = 0.5;   // of a take, at its start: what joint_offset learns from
  double clock_error_s = 0.005;  // between truth and sensors, as the paper states it
  std::vector<MethodSpec> methods;

  static void fields(StudySpec& self, Fields& f);
  void check(const JsonPlace& place) const;
};

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder);

// The study's stages; its single stage where it names none.
std::vector<Stage> stages_of(const StudySpec& study);

// The study as one stage sees it, by itself.
StudySpec at_stage(StudySpec study, const Stage& stage);

}  // namespace trilat
