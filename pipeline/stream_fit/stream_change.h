// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/stream_fit/point_stream.h"

namespace trilat {

// Numbers that are `factor` times too large: of all points or one, along all axes or one, in the whole file,
// from a time on or until then.
struct SizeChange {
  double factor = 1.0;
  bool is_unit = false;                // the factor is that of two units of length
  std::optional<std::size_t> point{};  // of the subject
  std::optional<int> axis{};           // 0 to 2
  std::optional<double> at_s{};        // when it begins, on the subject's clock
  bool until = false;                  // it ends then instead

  bool holds(double subject_s) const { return !at_s || (subject_s < *at_s) == until; }
};

// How the frame of the subject differs. Positions in the reference are R (or R mirrored) times those of the
// subject, plus a shift.
enum class FrameChange : std::uint8_t {
  none,
  shifted,
  axes,          // R exchanges and turns round axes
  axes_shifted,  // the same, shifted
  turned,        // any R, shifted
};

// Two points of the reference whose middle is the origin of the subject at every instant; one point twice
// where it is that point.
struct BodyRoot {
  std::size_t one = 0, other = 0;
  bool keeps_height = false;  // heights (y) are as they were
  bool turns = false;         // the axes turn about y with the line from one point to the other
};

// Axes exchanged and turned round: the 24 matrices of determinant 1, or those of determinant -1.
const std::vector<Eigen::Matrix3d>& signed_axes(bool mirrored);

// A change turns one stream, the subject, into another one, the reference. The default changes nothing.
struct StreamChange {
  std::vector<SizeChange> sizes{};
  // The subject's pose at its first instant + t is the reference's at that time + start_s + stretch t.
  double stretch = 1.0, start_s = 0.0;
  bool has_start = false, has_stretch = false;
  std::vector<std::size_t> order{};  // the subject's point order[j] is the reference's point j; empty: j
  FrameChange frame = FrameChange::none;
  bool mirrored = false;
  std::optional<BodyRoot> root{};
  // Fitted to all that both have.
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // mirrored, where that is set
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
};

// Divides the subject's points at one time by the factors that hold then.
void undo_sizes(const std::vector<SizeChange>& sizes, double subject_s, std::span<Eigen::Vector3d> points_m);

// Kinds of causes, as bits.
enum StreamCause : unsigned {
  kSizeCause = 1,         // unit or scale of everything
  kPointSizeCause = 2,    // unit of one point
  kLaterSizeCause = 4,    // unit from a time on
  kStartCause = 8,        // start of the clock
  kRateCause = 16,        // rate of the clock
  kSidesCause = 32,       // exchanged points
  kShiftCause = 64,       // origin of the frame
  kTurnCause = 128,       // axes of the frame
  kMirrorCause = 256,     // handedness of the frame
  kRootCause = 512,       // positions relative to a point of the body
  kAxisSizeCause = 1024,  // unit of one axis
  kAllStreamCauses = 2047
};
unsigned causes_of(const StreamChange& change);
// Number of fitted parameters; a choice among few counts as one.
int parameters_of(const StreamChange& change);

// Both streams, and when they are looked at.
struct StreamPair {
  const PointStream& reference;
  const PointStream& subject;
};

// Sum over what both have, from which every frame is fitted.
struct FrameSums {
  double pairs = 0.0, reference_m2 = 0.0, subject_m2 = 0.0;
  Eigen::Vector3d reference_m = Eigen::Vector3d::Zero(), of_subject_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products_m2 = Eigen::Matrix3d::Zero();  // subject x reference

  void add(const Eigen::Vector3d& reference, const Eigen::Vector3d& subject) {
    pairs += 1.0;
    reference_m += reference;
    of_subject_m += subject;
    reference_m2 += reference.squaredNorm();
    subject_m2 += subject.squaredNorm();
    products_m2.noalias() += subject * reference.transpose();
  }
  void add(const FrameSums& other) {
    pairs += other.pairs;
    reference_m += other.reference_m;
    of_subject_m += other.of_subject_m;
    reference_m2 += other.reference_m2;
    subject_m2 += other.subject_m2;
    products_m2 += other.products_m2;
  }
};

// Rotation (mirrored where that is asked for) and shift of least squares, and the squared distances that they
// leave.
struct FrameFit {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  double squares_m2 = 0.0;
};
FrameFit fit_frame(const FrameSums& sums, FrameChange kind, bool mirrored);

// Both streams at one instant after `change` but for its frame, visited point by point where both are known.
class ChangedPairs {
 public:
  ChangedPairs(const StreamPair& pair, const StreamChange& change);
  // Calls visit(point, reference, subject) for the instant of the reference.
  template <class Visit>
  void visit(std::size_t instant, const Visit& visit_pair) {
    look(instant);
    for (std::size_t j = 0; j < points_m_.size(); ++j) {
      const Eigen::Vector3d& subject = points_m_[order_[j]];
      const Eigen::Vector3d reference = body_from_world_ * (pair_.reference.at(instant, j) - root_m_);
      if (subject.allFinite() && reference.allFinite()) visit_pair(j, reference, subject);
    }
  }

 private:
  void look(std::size_t instant);

  const StreamPair& pair_;
  const StreamChange& change_;
  std::vector<std::size_t> order_;
  std::vector<Eigen::Vector3d> points_m_;
  Eigen::Vector3d root_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d body_from_world_ = Eigen::Matrix3d::Identity();
};

// Errors of a change by blocks of time, each judged with frame and offsets fitted to every second one of the
// others. `judged_m` leaves a constant offset to each point, up to what two definitions of a joint differ by;
// `plain_m` does not. NaN for blocks with too few pairs.
inline constexpr std::size_t kMinJudgedBlocks = 4;  // fewer decide nothing
struct ChangeErrors {
  std::vector<double> judged_m, plain_m, pairs;
  std::vector<double> of_point_m;  // plain, by point of the reference
};
struct TimeBlocks {
  double length_s = 2.5;
  std::size_t count = 0;
  std::size_t step = 1;  // instants of the reference between two that are looked at
};
TimeBlocks blocks_of(const StreamPair& pair);
// Mean of the values that are finite; NaN where there are none.
double mean_of_known(const std::vector<double>& values);
ChangeErrors errors_of_change(const StreamPair& pair, const TimeBlocks& blocks, const StreamChange& change);
// Change with its frame fitted to all pairs.
StreamChange fitted(const StreamPair& pair, const TimeBlocks& blocks, StreamChange change);

}  // namespace trilat
