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
#include "pipeline/errors/sample_windows.h"

namespace trilat {
namespace {

// How the samples of one joint and column are laid over the truth.
struct JointAlignment {
  AlignmentKind kind = AlignmentKind::none;
  Alignment alignment;              // of every kind but joint_offset
  JointOffset offset;               // of joint_offset
  std::uint64_t first_instant = 0;  // those before were learnt from and do not count
  bool turns = true;                // false: the alignment only moves
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();

  Eigen::Vector3d aligned_m(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    if (!turns) return estimate_m + shift_m;
    if (kind == AlignmentKind::joint_offset) return offset.corrected(estimate_m, heading_rad);
    if (alignment.status != AlignmentStatus::aligned) return Eigen::Vector3d::Constant(kNaN);
    return alignment.truth_from_estimate * estimate_m;
  }
};

struct AlignedSums {
  AlignmentSums whole;
  JointOffset trained;
};

// Marks of a joint at an instant, which all three passes over the samples use.
struct Mark {
  static constexpr std::uint8_t asked = 1, occluded = 2, abrupt = 4;
};
constexpr std::size_t kParts = 4;  // of the samples that are asked: occluded or not, abrupt or not
std::size_t part_of(std::uint8_t marks) { return marks >> 1U; }
bool is_part_of(std::size_t part, Subset subset) {
  if (subset == Subset::occluded) return (part & 1U) != 0;
  return subset == Subset::all || (part & 2U) != 0;
}

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
        beside_(instants_beside(settings.rate_hz)),
        windows_(take, track, block_instants(head_.instants, settings.rate_hz),
                 std::max<std::uint64_t>(2, beside_)),
        marks_(joints_ * head_.instants) {
    TRILAT_CHECK(head_.status_names.size() <= kMostStatuses, "every status has its column");
    turns_ = std::ranges::find(settings.alignments, AlignmentKind::rigid) != settings.alignments.end();
    if (std::ranges::any_of(settings.alignments, is_trained))
      training_end_ = static_cast<std::uint64_t>(
          std::llround(settings.training_share * static_cast<double>(head_.instants)));
  }

  ErrorTable table() {
    table_.settings_sha256 = settings_.sha256();
    for (const AlignmentKind kind : settings_.alignments) table_.alignments.emplace_back(name_of(kind));
    table_.body_alignment = settings_.body_alignment();
    look_at_truth();
    find_columns();
    align();
    add_up();
    return std::move(table_);
  }

 private:
  std::size_t mark(std::uint64_t i, std::size_t j) const { return j * head_.instants + i; }

  // First pass: which samples there are, how the truth moves, and who answers.
  void look_at_truth() {
    std::vector<std::uint8_t> acceleration(marks_.size(), kUnknown);
    std::vector<Accelerations> accelerations(joints_);
    answered_.assign(methods_, SampleSet(marks_.size()));
    table_.truth.resize(joints_);
    windows_.each([&](const Window& w) {
      for (std::size_t j = 0; j < joints_; ++j) {
        table_.truth[j].quantity = static_cast<std::uint32_t>(j);
        for (std::uint64_t i = w.first; i < w.end; ++i) {
          if (!has_truth(w, i, j, 0, 0)) continue;
          const std::size_t k = mark(i, j);
          marks_[k] = Mark::asked;
          if (w.block.occluded[w.place(i, j)] > 0) marks_[k] |= Mark::occluded;
          for (std::size_t m = 0; m < methods_; ++m)
            if (is_usable(w.status(w.slot(i, j, m)))) answered_[m].add(k);
          add_movement(w, i, j);
          if (!has_truth(w, i, j, beside_, beside_)) continue;
          acceleration[k] = bin_of_acceleration(w, i, j);
          ++accelerations[j][acceleration[k]];
        }
      }
    });
    for (std::size_t j = 0; j < joints_; ++j) {
      const std::uint8_t half = half_of(accelerations[j]);
      for (std::uint64_t i = 0; i < head_.instants; ++i)
        if (const std::size_t k = mark(i, j); acceleration[k] != kUnknown && acceleration[k] >= half)
          marks_[k] |= Mark::abrupt;
    }
  }

  void add_movement(const Window& w, std::uint64_t i, std::size_t j) {
    TruthRow& row = table_.truth[j];
    if (!has_truth(w, i, j, 1, 1)) return;
    ++row.speeds;
    row.speed_m_s += (w.truth_m(i + 1, j) - w.truth_m(i - 1, j)).norm() * settings_.rate_hz / 2.0;
    if (!has_truth(w, i, j, 1, 2)) return;
    ++row.jerks;
    row.jerk_m_s3 += jerk_m_s3(w.truth_m(i - 1, j), w.truth_m(i, j), w.truth_m(i + 1, j), w.truth_m(i + 2, j),
                               settings_.rate_hz);
  }

  // Histogram of the truth's acceleration, in bins of 0.1 m/s2; the last holds all that is larger.
  static constexpr double kAccelerationBin_m_s2 = 0.1;
  static constexpr std::uint8_t kBins = 255, kUnknown = 255;
  using Accelerations = std::array<std::uint32_t, kBins>;
  // From positions a fifteenth of a second apart, so that a marker's noise of some tenths of a millimetre
  // does not decide.
  std::uint8_t bin_of_acceleration(const Window& w, std::uint64_t i, std::size_t j) const {
    const double step_s = static_cast<double>(beside_) / settings_.rate_hz;
    const double m_s2 =
        (w.truth_m(i + beside_, j) - 2.0 * w.truth_m(i, j) + w.truth_m(i - beside_, j)).norm() /
        (step_s * step_s);
    return static_cast<std::uint8_t>(std::min(kBins - 1.0, m_s2 / kAccelerationBin_m_s2));
  }
  static std::uint64_t instants_beside(double rate_hz) {
    constexpr double kBeside_s = 1.0 / 15.0;
    return static_cast<std::uint64_t>(std::max(1LL, std::llround(kBeside_s * rate_hz)));
  }

  // The bin from which on samples are of the half with the larger acceleration.
  static std::uint8_t half_of(const Accelerations& bins) {
    std::uint64_t all = 0, smaller = 0;
    for (const std::uint32_t n : bins) all += n;
    std::uint8_t bin = 0;
    while (bin < bins.size() && 2 * smaller < all) smaller += bins[bin++];
    return bin;
  }

  // Whether the truth is known at the instants from i - before to i + behind.
  bool has_truth(const Window& w, std::uint64_t i, std::size_t j, std::uint64_t before,
                 std::uint64_t behind) const {
    if (i < w.begins() + before || i + behind >= w.ends()) return false;
    for (std::uint64_t k = i - before; k <= i + behind; ++k)
      if (!w.truth_m(k, j).allFinite()) return false;
    return true;
  }

  // A column is a method on some of the samples that it answers: the first ones each on all of its own, the
  // others on those that another method answers, too.
  void find_columns() {
    for (std::size_t m = 0; m < methods_; ++m) columns_.push_back({m, answered_[m]});
    for (const auto& [first, second] : settings_.pairs) {
      const SampleSet both = answered_[first] & answered_[second];
      pairs_.push_back({column_of(first, both), column_of(second, both)});
    }
    columns_of_.resize(methods_);
    for (std::size_t c = methods_; c < columns_.size(); ++c) columns_of_[columns_[c].method].push_back(c);
  }
  std::size_t column_of(std::size_t method, const SampleSet& samples) {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (columns_[c].method == method && columns_[c].samples == samples) return c;
    columns_.push_back({method, samples});
    return columns_.size() - 1;
  }

  // Second pass, where an alignment learns anything.
  void align() {
    std::vector<AlignedSums> sums(columns_.size() * joints_);
    const auto learns = [](AlignmentKind kind) {
      return kind != AlignmentKind::none && kind != AlignmentKind::held_out;
    };
    if (std::ranges::any_of(settings_.alignments, learns))
      windows_.each([&](const Window& w) {
        for (std::size_t j = 0; j < joints_; ++j)
          for (std::size_t c = 0; c < columns_.size(); ++c) learn(w, j, columns_[c], sums[c * joints_ + j]);
      });
    for (const AlignmentKind kind : settings_.alignments)
      for (std::size_t c = 0; c < columns_.size(); ++c)
        solve(kind, std::span(sums).subspan(c * joints_, joints_));
    for (std::uint32_t a = 0; a < alignments_; ++a)
      for (std::uint32_t m = 0; m < methods_; ++m)
        for (std::uint32_t j = 0; j < joints_; ++j)
          table_.laid_over.push_back(row_of(a, m, j, alignment(a, m, j)));
  }

  struct Column {
    std::size_t method;
    SampleSet samples;
  };

  void learn(const Window& w, std::size_t j, const Column& column, AlignedSums& sums) const {
    for (std::uint64_t i = w.first; i < w.end; ++i) {
      if (!column.samples.has(mark(i, j))) continue;
      const auto estimate_m = w.estimate_m(w.slot(i, j, column.method));
      sums.whole.add(estimate_m, w.truth_m(i, j), turns_);
      if (i >= training_end_) continue;
      if (const double heading_rad = w.block.heading_rad[i - w.begins()]; std::isfinite(heading_rad))
        sums.trained.add(estimate_m, w.truth_m(i, j), heading_rad);
    }
  }

  void solve(AlignmentKind kind, std::span<const AlignedSums> of_joints) {
    AlignmentSums whole;
    if (kind == AlignmentKind::rigid)
      for (const AlignedSums& sums : of_joints) whole.merge(sums.whole);
    for (const AlignedSums& sums : of_joints) {
      JointAlignment& solved = alignment_.emplace_back();
      solved.kind = kind;
      if (is_trained(kind)) solved.first_instant = training_end_;
      if (kind == AlignmentKind::joint_offset) {
        solved.offset = sums.trained;
        continue;
      }
      solved.alignment = solve_alignment(kind == AlignmentKind::rigid ? whole : sums.whole, kind);
      const RigidTransform& transform = solved.alignment.truth_from_estimate;
      solved.turns = transform.rotation.coeffs() != Eigen::Quaterniond::Identity().coeffs();
      solved.shift_m = transform.translation_m;
    }
  }
  const JointAlignment& alignment(std::size_t a, std::size_t column, std::size_t j) const {
    return alignment_[(a * columns_.size() + column) * joints_ + j];
  }

  static AlignmentRow row_of(std::uint32_t a, std::uint32_t m, std::uint32_t j,
                             const JointAlignment& solved) {
    AlignmentRow row{j, m, a, static_cast<std::uint32_t>(solved.first_instant)};
    if (solved.kind == AlignmentKind::joint_offset) {
      Eigen::Map<Eigen::Vector3d>(row.offset_m.data()) = solved.offset.in_body_m();
      return row;
    }
    const Eigen::Quaterniond& q = solved.alignment.truth_from_estimate.rotation;
    row.rotation = {q.w(), q.x(), q.y(), q.z()};
    Eigen::Map<Eigen::Vector3d>(row.shift_m.data()) = solved.shift_m;
    return row;
  }

  // Third pass: the sums of every block of time.
  void add_up() {
    const std::size_t cells = joints_ * methods_ * alignments_;
    parts_.resize(cells);
    bins_.resize(cells);
    lengths_.resize(columns_.size() * joints_ * alignments_);
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
        for (const std::size_t c : columns_of_[m])
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
    const JointAlignment& aligned = alignment(a, m, j);
    std::array<ErrorRow, kParts>& parts = parts_[cell(j, m, a)];
    std::array<std::vector<std::uint32_t>, kParts>& bins = bins_[cell(j, m, a)];
    const bool is_of_bodies = a == settings_.body_alignment();
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      const std::uint8_t marks = marks_[mark(i, j)];
      if (!(marks & Mark::asked)) continue;
      const std::size_t slot = w.slot(i, j, m);
      ErrorRow& row = parts[part_of(marks)];
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
      const auto bin = static_cast<std::size_t>(std::min<double>(kLastBin, length_m / kBin_m));
      std::vector<std::uint32_t>& of_part = bins[part_of(marks)];
      if (bin >= of_part.size()) of_part.resize(bin + 1);
      ++of_part[bin];
      if (!is_of_bodies) continue;
      WholeBody& body = body_[(i - w.first) * methods_ + m];
      ++body.answered;
      body.length_m += length_m;
    }
  }

  void add_lengths(const Window& w, std::size_t j, std::size_t c, std::size_t a) {
    const JointAlignment& aligned = alignment(a, c, j);
    std::array<LengthSum, kParts>& parts = lengths_[(c * joints_ + j) * alignments_ + a];
    for (std::uint64_t i = std::max(w.first, aligned.first_instant); i < w.end; ++i) {
      if (!columns_[c].samples.has(mark(i, j))) continue;
      const double length_m = (aligned.aligned_m(w.estimate_m(w.slot(i, j, columns_[c].method)),
                                                 w.block.heading_rad[i - w.begins()]) -
                               w.truth_m(i, j))
                                  .norm();
      if (!std::isfinite(length_m)) continue;
      LengthSum& sum = parts[part_of(marks_[mark(i, j)])];
      ++sum.n;
      sum.length_m += length_m;
    }
  }

  // Whether whole bodies are asked for at an instant.
  bool is_body_asked(std::uint64_t i) const {
    return i >= alignment(settings_.body_alignment(), 0, 0).first_instant;
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
      if (++answers < 4 || !(marks_[mark(i - 2, j)] & Mark::asked) || !is_body_asked(i - 2)) continue;
      ++row.jerks;
      row.jerk_m_s3 += jerk_m_s3(a_m, b_m, c_m, d_m, settings_.rate_hz);
    }
  }

  void add_bones(const Window& w, std::size_t m) {
    for (std::size_t b = 0; b < bones_.size(); ++b) {
      const auto [from, to] = bones_[b];
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!answered_[m].has(mark(i, from)) || !answered_[m].has(mark(i, to)) || !is_body_asked(i)) continue;
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
        if (marks_[mark(i, j)] & Mark::asked) {
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
    if (settings_.occluded_apart) return {Subset::all, Subset::occluded, Subset::abrupt};
    return {Subset::all, Subset::abrupt};
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
    for (std::size_t p = 0; p < pairs_.size(); ++p) end_block_of_pair(block, p);
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
    for (std::uint32_t j = 0; j < joints_; ++j)
      for (std::uint32_t a = 0; a < alignments_; ++a)
        for (const Subset subset : subsets()) {
          if (subset == Subset::abrupt) continue;
          const LengthSum of_first = length_of(pairs_[p].first, j, a, subset);
          const LengthSum of_second = length_of(pairs_[p].second, j, a, subset);
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
          for (const Subset subset : subsets())
            if (subset != Subset::abrupt) add_histogram(j, m, a, subset);
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
  const std::uint64_t beside_;  // instants: how far to either side an acceleration looks
  const Windows windows_;
  std::uint64_t training_end_ = 0;
  bool turns_ = false;               // an alignment has a rotation
  std::vector<std::uint8_t> marks_;  // by joint and instant
  std::vector<SampleSet> answered_;  // by method
  std::vector<Column> columns_;
  std::vector<std::vector<std::size_t>> columns_of_;        // by method, its own of all samples left out
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // columns, by pair of the settings
  std::vector<JointAlignment> alignment_;                   // by alignment, column and joint
  std::vector<std::array<ErrorRow, kParts>> parts_;         // by cell, of the current block of time
  std::vector<std::array<LengthSum, kParts>> lengths_;      // by column, joint and alignment, of the same
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
