// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"

namespace trilat {

// Exit codes of every verb. Bad input and bugs leave by exception: 2 and 70.
enum ExitCode { kDone = 0, kItemsFailed = 1, kBadInput = 2, kNotJudged = 3, kOurBug = 70 };

// True once the process has been asked to end (Ctrl-C, SIGTERM). Long work asks between items.
bool stop_requested();
// For verbs that leave something behind: from now on Ctrl-C asks; the others just end.
void end_in_order();

struct RecordArguments {
  std::vector<std::string> sources;
  std::string listen;  // HOST:PORT, or empty
  std::size_t agents = 1;
  double wait_s = 60.0;
  std::string keys;
  bool plain_text = false;
  std::filesystem::path output;
  double duration_s = 0.0;
  std::string compression = "blosc";
  int queue_mb = 512;
  int reserve_mb = 256;
  int workers = 2;
  bool preview = false;
  std::filesystem::path calibration;
  std::filesystem::path truth;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int record_session(const RecordArguments& arguments);

struct RecoverArguments {
  std::filesystem::path session;
  std::filesystem::path output;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int recover(const RecoverArguments& arguments);

struct InfoArguments {
  std::filesystem::path session;
  bool follow = false;
  bool json = false;
};
int info(const InfoArguments& arguments);

struct VerifyArguments {
  std::filesystem::path session;
  bool skip_depth = false;
  bool json = false;
};
int verify(const VerifyArguments& arguments);

struct MocapArguments {
  std::filesystem::path file;
  bool json = false;
};
int mocap(const MocapArguments& arguments);

struct SchemaArguments {
  std::string document;
  bool markdown = false;  // of all documents
};
int schema(const SchemaArguments& arguments);

struct SimulateArguments {
  std::filesystem::path spec;
  std::filesystem::path output;
  std::string shard;  // k/n, or empty: all of it
  OutsidePaths outside = OutsidePaths::refused;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int simulate(const SimulateArguments& arguments);

struct CalibrateArguments {
  std::vector<std::filesystem::path> sessions;
  std::filesystem::path output;
  std::string method = "wand";
  double ball_radius_m = 0.075;
  std::vector<std::string> intrinsics;  // SENSOR=FILE
  std::filesystem::path mocap;
  std::string asset;
  std::optional<std::int64_t> mocap_start_host_ns;
  std::optional<double> movement_m;
  double movement_sigma_m = 0.001;
  bool no_depth_correction = false;
  std::string trajectory_axis;  // x, y or z; empty: that of the method
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int calibrate(const CalibrateArguments& arguments);

struct MeasureTrackerArguments {
  std::vector<std::filesystem::path> campaigns;
  std::filesystem::path output;
  OutsidePaths outside = OutsidePaths::refused;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int measure_tracker(const MeasureTrackerArguments& arguments);

struct RunArguments {
  std::filesystem::path study;
  std::filesystem::path campaign;
  std::filesystem::path calibration;  // instead of the takes' own
  std::filesystem::path output;
  OutsidePaths outside = OutsidePaths::refused;
  int threads = 0;                         // 0: as many as there are processors
  std::optional<std::uint64_t> memory_mb;  // none: half of what there is
  bool cross_check = false;
  bool dry_run = false;
  std::string shard;                         // k/n, or empty: all of it
  std::vector<std::filesystem::path> reuse;  // earlier results
  bool fresh = false;                        // nothing is taken from the results that `output` holds
  bool force = false;                        // may replace what others wrote
  bool json = false;
  bool tables = false;  // all of them are printed
};
int run(const RunArguments& arguments);

struct MergeArguments {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path output;
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
  bool tables = false;  // all of them are printed
};
int merge(const MergeArguments& arguments);

struct ReportArguments {
  std::vector<std::filesystem::path> results;
  std::filesystem::path output;
  bool audit = false;             // of the paper alone; needs no results
  bool paper = false;             // with the paper's claims and their audit
  std::filesystem::path history;  // of nights, as the gate keeps it; empty: none
  std::string time;               // the page's time stamp; empty: now
  bool force = false;             // may replace what others wrote
  bool json = false;
};
int report(const ReportArguments& arguments);

struct ReproduceArguments {
  std::filesystem::path output = "out/reproduce";
  std::string scale = "paper";
  std::uint64_t seed = 1;
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int reproduce(const ReproduceArguments& arguments);
std::vector<std::string> reproduction_scales();

struct GateArguments {
  std::filesystem::path results, baseline;
  std::filesystem::path history, junit;  // or empty
  double smallest_percent = 1.0;
  std::uint64_t resamples = 2000;
  std::string method;  // whose cells are listed instead of the verdict
  bool accepts = false;
  std::string reason;
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};
int gate(const GateArguments& arguments);

}  // namespace trilat
