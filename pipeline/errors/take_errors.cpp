// SPDX-License-Identifier: MIT
#include "pipeline/errors/take_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/skeleton/skeleton.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/aligned_columns.h"
#include "pipeline/errors/track_samples.h"

namespace trilat {
namespace {

void add(ErrorRow& sum, const ErrorRow& more) {
  sum.answered += more.answered;
  sum.iterations += more.iterations;
  for (std::size_t s = 0; s < kMostStatuses; ++s) sum.statuses[s] += more.statuses[s];
  sum.length_m += more.length_m;
  sum.length_m2 += more.length_m2;
  sum.largest_m = std::max(sum.largest_m, more.largest_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sum.error_m[axis] += more.error_m[axis];
    sum.error_m2[axis] += more.error_m2[axis];
    sum.absolute_m[axis] += more.absolute_m[axis];
    sum.largest_axis_m[axis] = std::max(sum.largest_axis_m[axis], more.largest_axis_m[axis]);
  }
}

struct LengthSum {
  std::uint32_t n = 0;
  double length_m = 0.0;
};

// Sums the errors of one track; its quantities are the joints.
class TrackErrors {
 public:
  TrackErrors(const StoredTake& take, std::size_t track, const ErrorSettings& settings)
      : head_(take.head()),
        settings_(settings),
        joints_(head_.joints.size()),
        methods_(head_.methods.size()),
        alignments_(settings.alignments.size()),
        windows_(take, track, block_instants(head_.instants, settings.rate_hz), 2),
        marks_(windows_, head_, settings.rate_hz),
        columns_(windows_, head_, marks_, settings) {
    TRILAT_CHECK(head_.status_names.size() <= kMostStatuses, "every status has its column");
  }

  ErrorTable table() {
    table_.settings_sha256 = settings_.sha256();
    for (const AlignmentKind kind : settings_.alignments) table_.alignments.emplace_back(name_of(kind));
    table_.body_alignment = settings_.body_alignment();
    table_.truth = marks_.truth();
    table_.laid_over = columns_.rows();
    add_up();
    return std::move(table_);
  }

 private:
  // The sums of every block of time.
  void add_up() {
    const std::size_t cells = joints_ * methods_ * alignments_;
    parts_.resize(cells);
    bins_.resize(cells);
    lengths_.resize(columns_.columns().size() * joints_ * alignments_);
    bodies_.resize(methods_);
    body_pairs_.resize(settings_.pairs.size());
    for (const Bone& bone : kBones) {
      const auto from = std::ranges::find(head_.joints, name_of(bone.parent));
      const auto to = std::ranges::find(head_.joints, name_of(bone.child));
      if (from != head_.joints.end() && to != head_.joints.end())
        bones_.emplace_back(from - head_.joints.begin(), to - head_.joints.begin());
    }
    bone_lengths_.resize(methods_ * bones_.size());
    table_.shapes.resize(methods_);
    windows_.each([&](const Window& w) { add(w); }, [&](std::uint32_t block) { end_block(block); });
    end_take();
  }

  void add(const Window& w) {
    body_.assign((w.end - w.first) * methods_, {});
    for (std::size_t j = 0; j < joints_; ++j)
      for (std::size_t m = 0; m < methods_; ++m) {
        for (std::size_t a = 0; a < alignments_; ++a) add_errors(w, j, m, a);
        for (const std::size_t c : columns_.more_of(m))
          for (std::size_t a = 0; a < alignments_; ++a) add_lengths(w, j, c, a);
        add_jerks(w, j, m);
      }
    for (std::size_t m = 0; m < methods_; ++m) add_bones(w, m);
    add_bodies(w);
  }

  std::size_t cell(std::size_t j, std::size_t m, std::size_t a) const {
    return (j * methods_ + m) * alignments_ + a;
  }

  void add_errors(const Window& w, std::size_t j, std::size_t m, std::size_t a) {
    const JointAlignment& aligned = columns_.alignment(a, m, j);
    std::array<ErrorRow, kParts>& parts = parts_[cell(j, m, a)];
    std::array<std::vector<std::uint32_t>, kParts>& bins = bins_[cell(j, m, a)];
    const bool is_of_bodies = a == settings_.body_alignment();
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      if (!marks_.is_asked(i, j)) continue;
      const std::size_t part = marks_.part_of(i, j), slot = w.slot(i, j, m);
      ErrorRow& row = parts[part];
      row.iterations += w.block.iterations[slot];
      const SolveStatus status = w.status(slot);
      if (!is_usable(status)) {
        ++row.statuses[static_cast<std::size_t>(status)];
        continue;
      }
      const Eigen::Vector3d error_m =
          aligned.aligned_m(w.estimate_m(slot), w.block.heading_rad[i - w.begins()]) - w.truth_m(i, j);
      const double length_m2 = error_m.squaredNorm(), length_m = std::sqrt(length_m2);
      if (!std::isfinite(length_m)) {  // the alignment failed
        ++row.statuses[static_cast<std::size_t>(SolveStatus::not_solved)];
        continue;
      }
      ++row.statuses[static_cast<std::size_t>(status)];
      ++row.answered;
      row.length_m += length_m;
      row.length_m2 += length_m2;
      row.largest_m = std::max(row.largest_m, length_m);
      for (int axis = 0; axis < 3; ++axis) {
        const auto x = static_cast<std::size_t>(axis);
        row.error_m[x] += error_m[axis];
        row.error_m2[x] += error_m[axis] * error_m[axis];
        row.absolute_m[x] += std::abs(error_m[axis]);
        row.largest_axis_m[x] = std::max(row.largest_axis_m[x], std::abs(error_m[axis]));
      }
      const std::size_t bin = bin_of(length_m);
      std::vector<std::uint32_t>& of_part = bins[part];
      if (bin >= of_part.size()) of_part.resize(bin + 1);
      ++of_part[bin];
      if (!is_of_bodies) continue;
      WholeBody& body = body_[(i - w.first) * methods_ + m];
      ++body.answered;
      body.length_m += length_m;
    }
  }

  void add_lengths(const Window& w, std::size_t j, std::size_t c, std::size_t a) {
    const AlignedColumns::Column& column = columns_.columns()[c];
    const JointAlignment& aligned = columns_.alignment(a, c, j);
    std::array<LengthSum, kParts>& parts = lengths_[(c * joints_ + j) * alignments_ + a];
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      if (!column.samples.has(marks_.place(i, j))) continue;
      const double length_m =
          (aligned.aligned_m(w.estimate_m(w.slot(i, j, column.method)), w.block.heading_rad[i - w.begins()]) -
           w.truth_m(i, j))
              .norm();
      if (!std::isfinite(length_m)) continue;
      LengthSum& sum = parts[marks_.part_of(i, j)];
      ++sum.n;
      sum.length_m += length_m;
    }
  }

  // Whether whole bodies are asked for at an instant.
  bool is_body_asked(std::uint64_t i) const {
    return i >= columns_.alignment(settings_.body_alignment(), 0, 0).first_instant;
  }

  // Adds the jerk of four answers in a row, at the second.
  void add_jerks(const Window& w, std::size_t j, std::size_t m) {
    ShapeRow& row = table_.shapes[m];
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
      ++row.jerks;
      row.jerk_m_s3 += jerk_m_s3(a_m, b_m, c_m, d_m, settings_.rate_hz);
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

  // One method's answer for a body at one instant, under the body alignment.
  struct WholeBody {
    std::uint32_t answered = 0;
    double length_m = 0.0, pa_m = kNaN;
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
      WholeBody* bodies = &body_[(i - w.first) * methods_];
      if (joints.empty() || !is_body_asked(i)) continue;
      const ProcrustesTruth truth(truth_m);
      for (std::size_t m = 0; m < methods_; ++m) {
        if (bodies[m].answered < joints.size()) continue;
        estimate_m.clear();
        for (const std::size_t j : joints) estimate_m.emplace_back(w.estimate_m(w.slot(i, j, m)));
        bodies[m].length_m /= static_cast<double>(joints.size());
        bodies[m].pa_m = truth.pa_mpjpe_m(estimate_m);
      }
      const auto is_whole = [&](std::size_t m) { return bodies[m].answered == joints.size(); };
      for (std::size_t m = 0; m < methods_; ++m)
        if (is_whole(m)) add(bodies_[m], bodies[m]);
      for (std::size_t p = 0; p < settings_.pairs.size(); ++p) {
        const auto [first, second] = settings_.pairs[p];
        if (!is_whole(first) || !is_whole(second)) continue;
        add(body_pairs_[p][0], bodies[first]);
        add(body_pairs_[p][1], bodies[second]);
      }
    }
  }
  static void add(BodyRow& row, const WholeBody& body) {
    ++row.n;
    row.mpjpe_m += body.length_m;
    if (!std::isfinite(body.pa_m)) return;
    ++row.pa_n;
    row.pa_mpjpe_m += body.pa_m;
  }

  std::vector<Subset> subsets() const {
    if (settings_.occluded_apart) return {Subset::all, Subset::occluded};
    return {Subset::all};
  }

  void end_block(std::uint32_t block) {
    for (std::uint32_t j = 0; j < joints_; ++j)
      for (std::uint32_t m = 0; m < methods_; ++m)
        for (std::uint32_t a = 0; a < alignments_; ++a)
          for (const Subset subset : subsets()) {
            ErrorRow row{block, j, m, a, static_cast<std::uint32_t>(subset)};
            for (std::size_t part = 0; part < kParts; ++part)
              if (is_part_of(part, subset)) trilat::add(row, parts_[cell(j, m, a)][part]);
            if (row.asked() > 0) table_.errors.push_back(row);
          }
    for (std::size_t p = 0; p < settings_.pairs.size(); ++p) end_block_of_pair(block, p);
    for (std::uint32_t m = 0; m < methods_; ++m) end_block_of_body(block, m, m, bodies_[m]);
    for (std::size_t p = 0; p < settings_.pairs.size(); ++p) {
      const auto [first, second] = settings_.pairs[p];
      end_block_of_body(block, first, second, body_pairs_[p][0]);
      end_block_of_body(block, second, first, body_pairs_[p][1]);
    }
    for (auto& parts : parts_) parts = {};
    for (auto& parts : lengths_) parts = {};
  }

  void end_block_of_pair(std::uint32_t block, std::size_t p) {
    const auto [first, second] = settings_.pairs[p];
    const auto [first_column, second_column] = columns_.of_pair(p);
    for (std::uint32_t j = 0; j < joints_; ++j)
      for (std::uint32_t a = 0; a < alignments_; ++a)
        for (const Subset subset : subsets()) {
          const LengthSum of_first = length_of(first_column, j, a, subset);
          const LengthSum of_second = length_of(second_column, j, a, subset);
          if (of_first.n == 0 || of_second.n != of_first.n) continue;
          table_.pairs.push_back({block, j, first, second, a, static_cast<std::uint32_t>(subset), of_first.n,
                                  of_first.length_m, of_second.length_m});
        }
  }
  LengthSum length_of(std::size_t column, std::size_t j, std::size_t a, Subset subset) const {
    LengthSum sum;
    for (std::size_t part = 0; part < kParts; ++part) {
      if (!is_part_of(part, subset)) continue;
      if (column < methods_) {
        const ErrorRow& own = parts_[cell(j, column, a)][part];
        sum.n += own.answered;
        sum.length_m += own.length_m;
      } else {
        const LengthSum& here = lengths_[(column * joints_ + j) * alignments_ + a][part];
        sum.n += here.n;
        sum.length_m += here.length_m;
      }
    }
    return sum;
  }
  void end_block_of_body(std::uint32_t block, std::uint32_t method, std::uint32_t with, BodyRow& sums) {
    sums.block = block;
    sums.method = method;
    sums.with = with;
    if (sums.n > 0) table_.bodies.push_back(sums);
    sums = {};
  }

  void end_take() {
    for (std::uint32_t j = 0; j < joints_; ++j)
      for (std::uint32_t m = 0; m < methods_; ++m)
        for (std::uint32_t a = 0; a < alignments_; ++a)
          for (const Subset subset : subsets()) add_histogram(j, m, a, subset);
    for (std::uint32_t m = 0; m < methods_; ++m) {
      ShapeRow& row = table_.shapes[m];
      row.method = m;
      for (std::size_t b = 0; b < bones_.size(); ++b) {
        const LengthSpread& length = bone_lengths_[m * bones_.size() + b];
        if (length.count() < 2) continue;
        ++row.bones;
        row.bone_sd_m += length.standard_deviation_m();
      }
    }
    const auto in_order = [](auto& rows, const auto& key) {
      std::ranges::sort(rows, [&](const auto& a, const auto& b) { return key(a) < key(b); });
    };
    in_order(table_.errors, [](const ErrorRow& r) {
      return std::tuple(r.quantity, r.method, r.alignment, r.subset, r.block);
    });
    in_order(table_.pairs, [](const PairRow& r) {
      return std::tuple(r.quantity, r.first, r.second, r.alignment, r.subset, r.block);
    });
    in_order(table_.bodies, [](const BodyRow& r) { return std::tuple(r.method, r.with, r.block); });
  }

  void add_histogram(std::uint32_t j, std::uint32_t m, std::uint32_t a, Subset subset) {
    const auto& parts = bins_[cell(j, m, a)];
    std::size_t size = 0;
    for (const auto& bins : parts) size = std::max(size, bins.size());
    HistogramRow row{j, m, a, static_cast<std::uint32_t>(subset)};
    for (std::uint32_t bin = 0; bin < size; ++bin) {
      std::uint32_t n = 0;
      for (std::size_t part = 0; part < kParts; ++part)
        if (is_part_of(part, subset) && bin < parts[part].size()) n += parts[part][bin];
      if (n == 0) continue;
      table_.bins.push_back({bin, n});
      ++row.bins;
    }
    if (row.bins > 0) table_.histograms.push_back(row);
  }

  const TakeHead& head_;
  const ErrorSettings& settings_;
  const std::size_t joints_, methods_, alignments_;
  const Windows windows_;
  const SampleMarks marks_;
  const AlignedColumns columns_;
  std::vector<std::array<ErrorRow, kParts>> parts_;     // by cell, of the current block of time
  std::vector<std::array<LengthSum, kParts>> lengths_;  // by column, joint and alignment, of the same
  std::vector<std::array<std::vector<std::uint32_t>, kParts>> bins_;  // by cell, of the take
  std::vector<BodyRow> bodies_;                                       // by method, of the current block
  std::vector<std::array<BodyRow, 2>> body_pairs_;                    // by pair, of the same
  std::vector<WholeBody> body_;                                       // by instant of a window and method
  std::vector<std::pair<std::size_t, std::size_t>> bones_;            // joints
  std::vector<LengthSpread> bone_lengths_;                            // by method and bone
  ErrorTable table_;
};

}  // namespace

std::uint32_t ErrorSettings::body_alignment() const {
  const auto none = std::ranges::find(alignments, AlignmentKind::none);
  return none == alignments.end() ? 0 : static_cast<std::uint32_t>(none - alignments.begin());
}

std::string ErrorSettings::sha256() const {
  Json names = Json::array();
  for (const AlignmentKind kind : alignments) names.push_back(std::string(name_of(kind)));
  return hash_of_text(json_text(Json{{"alignments", names},
                                     {"training_share", training_share},
                                     {"occluded_apart", occluded_apart},
                                     {"rate_hz", rate_hz},
                                     {"pairs", pairs}},
                                -1));
}

std::uint64_t block_instants(std::uint64_t instants, double rate_hz) {
  constexpr double kBlock_s = 5.0;
  constexpr std::uint64_t kMostBlocks = 12;
  const auto wanted = static_cast<std::uint64_t>(std::max(1LL, std::llround(kBlock_s * rate_hz)));
  return std::max(wanted, (instants + kMostBlocks - 1) / kMostBlocks);
}

ErrorTable errors_of(const StoredTake& take, const ErrorSettings& settings) {
  ErrorTable all;
  for (std::size_t track = 0; track < take.head().tracks.size(); ++track) {
    ErrorTable table = TrackErrors(take, track, settings).table();
    const auto first = static_cast<std::uint32_t>(track * take.head().joints.size());
    const auto add = [&](auto ErrorTable::*rows) {
      for (auto& row : table.*rows) {
        if constexpr (requires { row.quantity; }) row.quantity += first;
        (all.*rows).push_back(row);
      }
    };
    all.settings_sha256 = table.settings_sha256;
    all.alignments = table.alignments;
    all.body_alignment = table.body_alignment;
    add(&ErrorTable::laid_over);
    add(&ErrorTable::errors);
    add(&ErrorTable::pairs);
    add(&ErrorTable::histograms);
    add(&ErrorTable::bins);
    add(&ErrorTable::bodies);
    add(&ErrorTable::shapes);
    add(&ErrorTable::truth);
  }
  return all;
}

}  // namespace trilat
