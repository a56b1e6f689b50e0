// SPDX-License-Identifier: MIT
#include "pipeline/errors/take_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/rig/skeleton.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/take_angles.h"
#include "pipeline/errors/track_samples.h"

namespace trilat {
namespace {

constexpr std::size_t kOfSample = 4;  // measures of each sample: distance, x, y, z

// Sums the errors of one track; its quantities are the joints.
class TrackErrors {
 public:
  TrackErrors(const StoredTake& take, std::size_t track, const ErrorSettings& settings, TakeErrors& errors)
      : head_(take.head()),
        track_(track),
        settings_(settings),
        joints_(head_.joints.size()),
        methods_(head_.methods.size()),
        alignments_(settings.alignments.size()),
        windows_(take, track, block_instants(head_.instants, settings.rate_hz), 2),
        marks_(windows_, head_),
        own_(own_columns(marks_)),
        columns_(windows_, head_, marks_, settings, own_),
        angles_(head_),
        errors_(errors) {
    TRILAT_CHECK(head_.status_names.size() <= kMaxStatuses, "every status has its column");
  }

  void add_up() {
    for (AlignmentRow row : columns_.rows()) {
      row.quantity = quantity_of(row.quantity);
      errors_.laid_over.push_back(row);
    }
    samples_.resize(joints_ * methods_ * alignments_);
    bins_.resize(samples_.size());
    ended_.resize(joints_ * methods_);
    bodies_.resize(methods_);
    jerks_.resize(methods_ + 1);
    views_.resize(joints_ * methods_);
    for (const Bone& bone : kBones) {
      const auto from = std::ranges::find(head_.joints, name_of(bone.parent));
      const auto to = std::ranges::find(head_.joints, name_of(bone.child));
      if (from != head_.joints.end() && to != head_.joints.end())
        bones_.emplace_back(from - head_.joints.begin(), to - head_.joints.begin());
    }
    bone_lengths_.resize(methods_ * bones_.size());
    windows_.each([&](const Window& w) { add(w); }, [&](std::uint32_t block) { end_block(block); });
    end_take();
  }

 private:
  static std::vector<SampleColumn> own_columns(const SampleFlags& marks) {
    std::vector<SampleColumn> columns;
    for (std::size_t m = 0; m < marks.answered().size(); ++m) columns.push_back({m, marks.answered()[m]});
    return columns;
  }
  std::uint32_t quantity_of(std::size_t joint) const {
    return static_cast<std::uint32_t>(track_ * joints_ + joint);
  }
  std::uint32_t body() const { return static_cast<std::uint32_t>(head_.tracks.size() * joints_); }

  void add(const Window& w) {
    body_.assign((w.end - w.first) * methods_, {});
    for (std::size_t j = 0; j < joints_; ++j)
      for (std::size_t m = 0; m < methods_; ++m) {
        add_ended(w, j, m);
        for (std::size_t a = 0; a < alignments_; ++a) add_samples(w, j, m, a);
        add_jerks(w, j, m);
        if (!head_.track_position_m.empty()) add_views(w, j, m);
      }
    for (std::size_t j = 0; j < joints_; ++j) add_jerks_of_truth(w, j);
    for (std::size_t m = 0; m < methods_; ++m) add_bones(w, m);
    add_bodies(w);
    if (track_ == 0 && head_.track_position_m.empty()) angles_.add(w);
  }

  std::size_t cell(std::size_t j, std::size_t m, std::size_t a) const {
    return (j * methods_ + m) * alignments_ + a;
  }

  void add_ended(const Window& w, std::size_t j, std::size_t m) {
    const std::uint64_t test_from = settings_.training_end(head_.instants);
    for (std::uint64_t i = w.first; i < w.end; ++i) {
      if (!marks_.is_asked(i, j)) continue;
      const std::size_t slot = w.slot(i, j, m);
      EndedRow& row = ended_[j * methods_ + m][marks_.subset_of(i, j)][i < test_from ? 0 : 1];
      ++row.statuses[static_cast<std::size_t>(w.status(slot))];
      row.iterations += w.block.iterations[slot];
    }
  }

  void add_samples(const Window& w, std::size_t j, std::size_t m, std::size_t a) {
    const JointAlignment& aligned = columns_.of(a, m, j);
    auto& parts = samples_[cell(j, m, a)];
    auto& bins = bins_[cell(j, m, a)];
    const bool is_of_bodies = a == settings_.body_alignment();
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      if (!marks_.answered()[m].has(marks_.place(i, j))) continue;
      const Eigen::Vector3d error_m =
          aligned.aligned_m(w.estimate_m(w.slot(i, j, m)), w.block.heading_rad[i - w.begins()]) -
          w.truth_m(i, j);
      const double length_m = error_m.norm();
      if (!std::isfinite(length_m)) continue;  // no alignment was found
      const std::size_t part = marks_.subset_of(i, j);
      parts[part][0].add(length_m);
      for (int axis = 0; axis < 3; ++axis) parts[part][1 + static_cast<std::size_t>(axis)].add(error_m[axis]);
      const std::size_t bin = bin_of(length_m);
      if (bin >= bins[part].size()) bins[part].resize(bin + 1);
      ++bins[part][bin];
      if (!is_of_bodies) continue;
      WholeBody& body = body_[(i - w.first) * methods_ + m];
      ++body.answered;
      body.length_m += length_m;
    }
  }

  // Whether whole bodies are asked for at an instant.
  bool is_body_asked(std::uint64_t i) const {
    return i >= columns_.of(settings_.body_alignment(), 0, 0).first_instant;
  }

  // Adds the jerk of four answers in a row, at the second.
  void add_jerks(const Window& w, std::size_t j, std::size_t m) {
    Eigen::Vector3d a_m, b_m, c_m, d_m;
    int answers = 0;
    const std::uint64_t from = w.first - std::min<std::uint64_t>(w.first, 1);
    for (std::uint64_t i = from; i < std::min(w.end + 2, w.ends()); ++i) {
      const std::size_t slot = w.slot(i, j, m);
      if (!is_usable(w.status(slot))) {
        answers = 0;
        continue;
      }
      a_m = b_m;
      b_m = c_m;
      c_m = d_m;
      d_m = w.estimate_m(slot);
      if (++answers < 4 || !marks_.is_asked(i - 2, j) || !is_body_asked(i - 2)) continue;
      jerks_[m].add(jerk_m_s3(a_m, b_m, c_m, d_m, settings_.rate_hz));
    }
  }

  void add_jerks_of_truth(const Window& w, std::size_t j) {
    for (std::uint64_t i = std::max(w.first, w.begins() + 1); i < w.end && i + 2 < w.ends(); ++i) {
      const double jerk = jerk_m_s3(w.truth_m(i - 1, j), w.truth_m(i, j), w.truth_m(i + 1, j),
                                    w.truth_m(i + 2, j), settings_.rate_hz);
      if (std::isfinite(jerk)) jerks_[methods_].add(jerk);
    }
  }

  void add_bones(const Window& w, std::size_t m) {
    const SampleSet& answered = marks_.answered()[m];
    for (std::size_t b = 0; b < bones_.size(); ++b) {
      const auto [from, to] = bones_[b];
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!answered.has(marks_.place(i, from)) || !answered.has(marks_.place(i, to)) || !is_body_asked(i))
          continue;
        bone_lengths_[m * bones_.size() + b].add(
            (w.estimate_m(w.slot(i, from, m)) - w.estimate_m(w.slot(i, to, m))).norm());
      }
    }
  }

  // How far a prediction is from what the sensor sees that is left out: along its ray, and from it.
  void add_views(const Window& w, std::size_t j, std::size_t m) {
    const Eigen::Map<const Eigen::Vector3d> sensor_m(head_.track_position_m[track_].data());
    auto& [range, bearing] = views_[j * methods_ + m];
    for (std::uint64_t i = w.first; i < w.end; ++i) {
      if (!marks_.answered()[m].has(marks_.place(i, j))) continue;
      const Eigen::Vector3d predicted_m = w.estimate_m(w.slot(i, j, m)) - sensor_m,
                            seen_m = w.truth_m(i, j) - sensor_m;
      range.add(predicted_m.norm() - seen_m.norm());
      bearing.add(predicted_m.cross(seen_m.normalized()).norm());
    }
  }

  // One method's answer for a body at one instant, under the body alignment.
  struct WholeBody {
    std::uint32_t answered = 0;
    double length_m = 0.0;
  };

  void add_bodies(const Window& w) {
    std::vector<Eigen::Vector3d> truth_m, estimate_m;
    std::vector<std::size_t> joints;
    for (std::uint64_t i = w.first; i < w.end; ++i) {
      joints.clear();
      truth_m.clear();
      for (std::size_t j = 0; j < joints_; ++j)
        if (marks_.is_asked(i, j)) {
          joints.push_back(j);
          truth_m.emplace_back(w.truth_m(i, j));
        }
      if (joints.empty() || !is_body_asked(i)) continue;
      const ProcrustesTruth truth(truth_m);
      for (std::size_t m = 0; m < methods_; ++m) {
        const WholeBody& body = body_[(i - w.first) * methods_ + m];
        if (body.answered < joints.size()) continue;
        estimate_m.clear();
        for (const std::size_t j : joints) estimate_m.emplace_back(w.estimate_m(w.slot(i, j, m)));
        auto& [mpjpe, pa_mpjpe] = bodies_[m];
        mpjpe.add(body.length_m / static_cast<double>(joints.size()));
        if (const double pa_m = truth.pa_mpjpe_m(estimate_m); std::isfinite(pa_m)) pa_mpjpe.add(pa_m);
      }
    }
  }

  std::vector<Subset> subsets() const {
    if (settings_.occluded_apart) return {Subset::all, Subset::occluded};
    return {Subset::all};
  }

  // Puts sums into the take's and begins them anew.
  void put(ErrorSums& sums, std::uint32_t block, std::uint32_t quantity, std::size_t m, std::size_t a,
           Subset subset, Measure measure) {
    sums.block = block;
    sums.quantity = quantity;
    sums.method = static_cast<std::uint32_t>(m);
    sums.alignment = static_cast<std::uint32_t>(a);
    sums.subset = static_cast<std::uint32_t>(subset);
    sums.measure = static_cast<std::uint32_t>(measure);
    if (sums.n > 0) errors_.sums.push_back(sums);
    sums = {};
  }

  void end_block(std::uint32_t block) {
    const std::size_t before_any = alignments_;
    for (std::size_t j = 0; j < joints_; ++j)
      for (std::size_t m = 0; m < methods_; ++m) {
        for (std::size_t a = 0; a < alignments_; ++a) end_block_of(block, j, m, a);
        auto& [range, bearing] = views_[j * methods_ + m];
        put(range, block, quantity_of(j), m, before_any, Subset::all, Measure::range);
        put(bearing, block, quantity_of(j), m, before_any, Subset::all, Measure::bearing);
      }
    for (std::size_t m = 0; m <= methods_; ++m)
      put(jerks_[m], block, body(), m, before_any, Subset::all, Measure::jerk);
    for (std::size_t m = 0; m < methods_; ++m) {
      auto& [mpjpe, pa_mpjpe] = bodies_[m];
      put(mpjpe, block, body(), m, settings_.body_alignment(), Subset::all, Measure::mpjpe);
      put(pa_mpjpe, block, body(), m, before_any, Subset::all, Measure::pa_mpjpe);
    }
    angles_.end_block([&](ErrorSums& sums, std::size_t angle, std::size_t m, Measure measure) {
      put(sums, block, static_cast<std::uint32_t>(body() + 1 + angle), m, before_any, Subset::all, measure);
    });
  }

  void end_block_of(std::uint32_t block, std::size_t j, std::size_t m, std::size_t a) {
    auto& parts = samples_[cell(j, m, a)];
    for (const Subset subset : subsets())
      for (std::size_t measure = 0; measure < kOfSample; ++measure) {
        ErrorSums sums;
        for (std::size_t part = 0; part < kSubsetCombinations; ++part)
          if (is_part_of(part, subset)) sums.add(parts[part][measure]);
        put(sums, block, quantity_of(j), m, a, subset, static_cast<Measure>(measure));
      }
    parts = {};
  }

  void end_take() {
    for (std::size_t j = 0; j < joints_; ++j)
      for (std::size_t m = 0; m < methods_; ++m)
        for (const Subset subset : subsets()) {
          add_ended(j, m, subset);
          for (std::size_t a = 0; a < alignments_; ++a) add_histogram(j, m, a, subset);
        }
    for (std::size_t m = 0; m < methods_; ++m) {
      ErrorSums sds;
      for (std::size_t b = 0; b < bones_.size(); ++b)
        if (const LengthSpread& length = bone_lengths_[m * bones_.size() + b]; length.count() >= 2)
          sds.add(length.standard_deviation_m());
      put(sds, 0, body(), m, alignments_, Subset::all, Measure::bone);
    }
    angles_.end_take([&](ErrorSums& sums, std::size_t angle, std::size_t m, Measure measure) {
      put(sums, 0, static_cast<std::uint32_t>(body() + 1 + angle), m, alignments_, Subset::all, measure);
    });
  }

  void add_ended(std::size_t j, std::size_t m, Subset subset) {
    for (std::uint32_t test = 0; test < 2; ++test) {
      EndedRow row{quantity_of(j), static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(subset), test};
      for (std::size_t part = 0; part < kSubsetCombinations; ++part) {
        if (!is_part_of(part, subset)) continue;
        const EndedRow& more = ended_[j * methods_ + m][part][test];
        row.iterations += more.iterations;
        for (std::size_t s = 0; s < kMaxStatuses; ++s) row.statuses[s] += more.statuses[s];
      }
      if (row.asked() > 0) errors_.ended.push_back(row);
    }
  }

  void add_histogram(std::size_t j, std::size_t m, std::size_t a, Subset subset) {
    const auto& parts = bins_[cell(j, m, a)];
    std::size_t size = 0;
    for (const auto& bins : parts) size = std::max(size, bins.size());
    HistogramRow row{quantity_of(j), static_cast<std::uint32_t>(m), static_cast<std::uint32_t>(a),
                     static_cast<std::uint32_t>(subset)};
    for (std::uint32_t bin = 0; bin < size; ++bin) {
      std::uint32_t n = 0;
      for (std::size_t part = 0; part < kSubsetCombinations; ++part)
        if (is_part_of(part, subset) && bin < parts[part].size()) n += parts[part][bin];
      if (n == 0) continue;
      errors_.bins.push_back({bin, n});
      ++row.bins;
    }
    if (row.bins > 0) errors_.histograms.push_back(row);
  }

  const TakeHead& head_;
  const std::size_t track_;
  const ErrorSettings& settings_;
  const std::size_t joints_, methods_, alignments_;
  const Windows windows_;
  const SampleFlags marks_;
  const std::vector<SampleColumn> own_;
  const ColumnAlignments columns_;
  // Sums of the current block. A cell is a joint, method and alignment; jerks_ ends with the truth's; views_
  // has range and bearing by joint and method.
  std::vector<std::array<std::array<ErrorSums, kOfSample>, kSubsetCombinations>> samples_;
  std::vector<std::array<ErrorSums, 2>> bodies_;  // MPJPE, PA-MPJPE by method
  std::vector<ErrorSums> jerks_;
  std::vector<std::array<ErrorSums, 2>> views_;
  std::vector<WholeBody> body_;  // by instant of a window and method
  // Counts of the whole take: bins_ by cell, ended_ by joint and method, bone_lengths_ by method and bone.
  std::vector<std::array<std::vector<std::uint32_t>, kSubsetCombinations>> bins_;
  std::vector<std::array<std::array<EndedRow, 2>, kSubsetCombinations>> ended_;
  std::vector<std::pair<std::size_t, std::size_t>> bones_;  // joints
  std::vector<LengthSpread> bone_lengths_;
  TakeAngles angles_;
  TakeErrors& errors_;
};

}  // namespace

std::uint32_t ErrorSettings::body_alignment() const {
  const auto none = std::ranges::find(alignments, AlignmentKind::none);
  return none == alignments.end() ? 0 : static_cast<std::uint32_t>(none - alignments.begin());
}

std::uint64_t ErrorSettings::training_end(std::uint64_t instants) const {
  if (std::ranges::none_of(alignments, is_trained)) return 0;
  return static_cast<std::uint64_t>(std::llround(training_share * static_cast<double>(instants)));
}

std::string ErrorSettings::sha256() const {
  Json names = Json::array();
  for (const AlignmentKind kind : alignments) names.push_back(std::string(name_of(kind)));
  return hash_of_text(json_text(Json{{"alignments", names},
                                     {"training_share", training_share},
                                     {"occluded_apart", occluded_apart},
                                     {"rate_hz", rate_hz}},
                                -1));
}

std::uint64_t block_instants(std::uint64_t instants, double rate_hz) {
  constexpr double kBlock_s = 5.0;
  constexpr std::uint64_t kMaxBlocks = 12;
  const auto wanted = static_cast<std::uint64_t>(std::max(1LL, std::llround(kBlock_s * rate_hz)));
  return std::max(wanted, (instants + kMaxBlocks - 1) / kMaxBlocks);
}

TakeErrors errors_of(const StoredTake& take, const ErrorSettings& settings) {
  TakeErrors errors;
  errors.settings_sha256 = settings.sha256();
  for (const AlignmentKind kind : settings.alignments) errors.alignments.emplace_back(name_of(kind));
  const TakeHead& head = take.head();
  for (std::size_t track = 0; track < head.tracks.size(); ++track)
    errors.quantities.insert(errors.quantities.end(), head.joints.begin(), head.joints.end());
  errors.quantities.emplace_back("body");
  const TakeAngles angles(head);
  errors.quantities.insert(errors.quantities.end(), angles.names().begin(), angles.names().end());
  for (std::size_t track = 0; track < head.tracks.size(); ++track)
    TrackErrors(take, track, settings, errors).add_up();
  std::ranges::stable_sort(errors.sums, [](const ErrorSums& a, const ErrorSums& b) {
    const auto order = [](const ErrorSums& r) {
      return std::tuple(r.quantity, r.method, r.alignment, r.subset, r.measure, r.block);
    };
    return order(a) < order(b);
  });
  return errors;
}

}  // namespace trilat
