// SPDX-License-Identifier: MIT
// The errors of a take whose numbers are chosen: what each row sums can be added up by hand.
#include "pipeline/errors/take_errors.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>

#include "evaluators/solvers/point_estimate.h"
#include "pipeline/errors/condition_errors.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::DoubleNear;
using testing::ElementsAre;

constexpr double kMadeRate_hz = 30.0;
const Vector3d kError_m(0.03, 0.0, -0.04);  // 5 cm long

// Two joints that are the ends of a bone, and as many methods as wanted. Without more, each answers with the
// truth.
struct MadeTake {
  TakeHead head;
  SampleBlock block;

  explicit MadeTake(std::uint64_t instants, std::size_t methods = 1) {
    head = {"t", "walking", instants, {"shoulder_left", "elbow_left"}, {}, {"mocap"}, {}};
    for (std::size_t m = 0; m < methods; ++m) head.methods.push_back("method " + std::to_string(m));
    for (int s = 0; s < kSolveStatusCount; ++s)
      head.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
    block.reset(0, instants, head.joints.size(), methods);
    for (std::uint64_t i = 0; i < instants; ++i) {
      block.time_ns[i] = static_cast<std::int64_t>(1e9 * static_cast<double>(i) / kMadeRate_hz);
      block.heading_rad[i] = 0.0F;
      for (std::size_t j = 0; j < 2; ++j) {
        set_truth(i, j, Vector3d(0.01 * static_cast<double>(i), 1.5 - 0.3 * static_cast<double>(j), 2.0));
        for (std::size_t m = 0; m < methods; ++m) answer(i, j, m, truth_m(i, j));
      }
    }
  }
  std::size_t place(std::uint64_t i, std::size_t j) const { return i * 2 + j; }
  std::size_t slot(std::uint64_t i, std::size_t j, std::size_t m) const {
    return place(i, j) * head.methods.size() + m;
  }
  Vector3d truth_m(std::uint64_t i, std::size_t j) const {
    return Eigen::Map<const Vector3d>(&block.truth_m[3 * place(i, j)]);
  }
  void set_truth(std::uint64_t i, std::size_t j, const Vector3d& at_m) {
    Eigen::Map<Vector3d>(&block.truth_m[3 * place(i, j)]) = at_m;
  }
  void answer(std::uint64_t i, std::size_t j, std::size_t m, const Vector3d& at_m,
              SolveStatus status = SolveStatus::converged) {
    Eigen::Map<Eigen::Vector3f>(&block.estimate_m[3 * slot(i, j, m)]) = at_m.cast<float>();
    block.status[slot(i, j, m)] = static_cast<std::uint8_t>(status);
  }
  void miss(std::uint64_t i, std::size_t j, std::size_t m) {
    answer(i, j, m, Vector3d::Constant(std::nan("")), SolveStatus::diverged);
  }
  void each(const std::function<void(std::uint64_t i, std::size_t j)>& visit) {
    for (std::uint64_t i = 0; i < head.instants; ++i)
      for (std::size_t j = 0; j < 2; ++j) visit(i, j);
  }
  StoredTake stored(const ScratchFolder& folder) const {
    StoredTake take = StoredTake::create(folder / StoredTake::kName, head);
    take.write(0, block);
    take.finish();
    return StoredTake::open(folder / StoredTake::kName);
  }
  TakeErrors errors(const ErrorSettings& settings) const {
    const ScratchFolder folder;
    return errors_of(stored(folder), settings);
  }
};

ErrorSettings under(std::vector<AlignmentKind> alignments, double training_share = 0.0) {
  ErrorSettings settings;
  settings.alignments = std::move(alignments);
  settings.training_share = training_share;
  settings.rate_hz = kMadeRate_hz;
  return settings;
}

constexpr std::uint32_t kBody = 2;  // behind the joints

// The sums of a measure in all blocks of time.
ErrorSums sums_of(const TakeErrors& errors, Measure measure, std::uint32_t quantity, std::uint32_t method = 0,
                  std::uint32_t alignment = 0, Subset subset = Subset::all) {
  ErrorSums sums;
  for (const ErrorSums& row : errors.sums)
    if (row.is(measure) && row.quantity == quantity && row.method == method && row.alignment == alignment &&
        row.subset == static_cast<std::uint32_t>(subset))
      sums.add(row);
  return sums;
}
double length_m(const TakeErrors& errors, std::uint32_t joint, std::uint32_t alignment = 0,
                Subset subset = Subset::all) {
  return sums_of(errors, Measure::distance, joint, 0, alignment, subset).sum;
}

// How the samples of a joint ended, in the part that trained alignments do not learn from.
EndedRow ended_of(const TakeErrors& errors, std::uint32_t joint, Subset subset = Subset::all) {
  for (const EndedRow& row : errors.ended)
    if (row.quantity == joint && row.subset == static_cast<std::uint32_t>(subset) && row.test == 1)
      return row;
  return {};
}

TEST(TakeErrors, AreSumsOverWhatIsAskedAndAnswered) {
  MadeTake made(40);
  for (std::uint64_t i = 0; i < 40; ++i)
    made.answer(i, 0, 0, made.truth_m(i, 0) + (i == 7 ? 3.0 : 1.0) * kError_m);
  for (const std::uint64_t i : {3, 4, 5}) made.miss(i, 0, 0);
  for (const std::uint64_t i : {20, 21}) made.set_truth(i, 0, Vector3d::Constant(std::nan("")));
  const TakeErrors errors = made.errors(under({AlignmentKind::none}));
  const EndedRow ended = ended_of(errors, 0);
  EXPECT_EQ(ended.asked(), 38u);
  EXPECT_EQ(ended.statuses[static_cast<std::size_t>(SolveStatus::converged)], 35u);
  EXPECT_EQ(ended.statuses[static_cast<std::size_t>(SolveStatus::diverged)], 3u);
  const ErrorSums distance = sums_of(errors, Measure::distance, 0);
  EXPECT_EQ(distance.n, 35u);
  EXPECT_NEAR(distance.sum, 34 * 0.05 + 0.15, 1e-5);
  EXPECT_NEAR(distance.sum_squares, 34 * 0.0025 + 0.0225, 1e-5);
  EXPECT_NEAR(distance.largest, 0.15, 1e-6);
  const double signs[] = {1.0, 0.0, -1.0}, error_m[] = {0.03, 0.0, 0.04};
  for (const std::size_t axis : {0U, 1U, 2U}) {
    const ErrorSums sums =
        sums_of(errors, static_cast<Measure>(static_cast<std::size_t>(Measure::x) + axis), 0);
    EXPECT_NEAR(sums.sum, signs[axis] * 37 * error_m[axis], 1e-5);
    EXPECT_NEAR(sums.sum_abs, 37 * error_m[axis], 1e-5);
    EXPECT_NEAR(sums.sum_squares, 43 * error_m[axis] * error_m[axis], 1e-5);
    EXPECT_NEAR(sums.largest, 3 * error_m[axis], 1e-6);
  }
}

TEST(TakeErrors, LieInBlocksOfFiveSeconds) {
  const TakeErrors table = MadeTake(310).errors(under({AlignmentKind::none}));
  std::vector<std::uint32_t> answered;
  for (const ErrorSums& row : table.sums)
    if (row.quantity == 1 && row.is(Measure::distance)) answered.push_back(row.n);
  EXPECT_THAT(answered, ElementsAre(150u, 150u, 10u));
}

TEST(TakeErrors, OfEachAlignmentAreWhatItLeaves) {
  MadeTake made(60);
  const Eigen::AngleAxisd turn(0.3, Vector3d(0.2, 1.0, 0.1).normalized());
  made.each([&](std::uint64_t i, std::size_t j) {
    const double t = 0.1 * static_cast<double>(i);
    made.set_truth(
        i, j, Vector3d(std::sin(t), 1.0 + 0.2 * static_cast<double>(j) + 0.1 * std::cos(2 * t), 2.0 + t));
    made.answer(i, j, 0, turn * made.truth_m(i, j) + kError_m);
  });
  const TakeErrors table = made.errors(
      under({AlignmentKind::none, AlignmentKind::first, AlignmentKind::mean, AlignmentKind::rigid}));
  for (const std::uint32_t j : {0U, 1U}) {
    Vector3d mean_m = Vector3d::Zero();
    std::vector<Vector3d> error_m;
    for (std::uint64_t i = 0; i < 60; ++i) {
      error_m.push_back(turn * made.truth_m(i, j) + kError_m - made.truth_m(i, j));
      mean_m += error_m.back() / 60.0;
    }
    std::array<double, 3> expected_m{};
    for (const Vector3d& e : error_m) {
      expected_m[0] += e.norm();
      expected_m[1] += (e - error_m[0]).norm();
      expected_m[2] += (e - mean_m).norm();
    }
    for (const std::uint32_t a : {0U, 1U, 2U})
      EXPECT_NEAR(length_m(table, j, a), expected_m.at(a), 1e-5) << a;
    EXPECT_LT(length_m(table, j, 3), 1e-4);  // estimates are stored in single precision
  }
}

// Half of the take is learnt from. The first instant of the other half is an outlier: it may move nothing.
TEST(TakeErrors, OfTheHeldOutHalfDoNotDependOnWhatTheyAreHeldAgainst) {
  MadeTake made(60);
  made.each([&](std::uint64_t i, std::size_t j) {
    made.block.heading_rad[i] = 0.1F * static_cast<float>(i);
    const Eigen::AngleAxisd heading(static_cast<double>(made.block.heading_rad[i]), Vector3d::UnitY());
    made.answer(i, j, 0,
                made.truth_m(i, j) + heading * kError_m + (i == 30 ? Vector3d(1, 0, 0) : Vector3d(0, 0, 0)));
  });
  const TakeErrors table = made.errors(under({AlignmentKind::held_out, AlignmentKind::joint_offset}, 0.5));
  for (const std::uint32_t j : {0U, 1U}) {
    const ErrorSums held_out = sums_of(table, Measure::distance, j),
                    offset = sums_of(table, Measure::distance, j, 0, 1);
    EXPECT_EQ(ended_of(table, j).asked(), 30u);
    EXPECT_EQ(held_out.n, 30u);
    EXPECT_NEAR(held_out.sum - held_out.largest, 29 * 0.05, 1e-4);
    EXPECT_EQ(offset.n, 30u);
    EXPECT_NEAR(offset.sum, 1.0, 1e-4);  // the outlier alone
    EXPECT_NEAR(offset.largest, 1.0, 1e-5);
  }
}

TEST(TakeErrors, OfPairsAreOfTheSamplesThatBothAnswerEachAlignedOnThese) {
  MadeTake made(40, 2);
  made.each([&](std::uint64_t i, std::size_t j) {
    made.answer(i, j, 0, made.truth_m(i, j) + (i < 20 ? 1.0 : 9.0) * kError_m);
    if (i >= 20) made.miss(i, j, 1);
  });
  const ErrorSettings settings = under({AlignmentKind::mean, AlignmentKind::none});
  const ScratchFolder folder;
  const StoredTake take = made.stored(folder);
  const MethodPair pair{0, 1};
  const std::vector<PairRow> pairs = pair_errors(take, settings, {&pair, 1}).at(pair);
  ASSERT_EQ(pairs.size(), 4u);  // joints and alignments
  for (const PairRow& row : pairs) {
    EXPECT_EQ(row.n, 20u);
    EXPECT_NEAR(row.first_m, row.alignment == 0 ? 0.0 : 20 * 0.05, 1e-5);
    EXPECT_NEAR(row.second_m, 0.0, 1e-5);
  }
  // of its own samples: 4 times 5 cm from their mean
  EXPECT_NEAR(length_m(errors_of(take, settings), 0), 40 * 0.2, 1e-4);
}

TEST(TakeErrors, OfOccludedSamplesAreARowOfTheirOwn) {
  MadeTake made(30);
  for (std::uint64_t i = 0; i < 10; ++i) {
    made.block.occluded[made.place(i, 1)] = 2;
    made.answer(i, 1, 0, made.truth_m(i, 1) + kError_m);
  }
  ErrorSettings settings = under({AlignmentKind::none});
  settings.occluded_apart = true;
  const TakeErrors table = made.errors(settings);
  EXPECT_EQ(ended_of(table, 1, Subset::occluded).asked(), 10u);
  EXPECT_NEAR(length_m(table, 1, 0, Subset::occluded), 0.5, 1e-5);
  EXPECT_EQ(ended_of(table, 1).asked(), 30u);
  EXPECT_NEAR(length_m(table, 1), 0.5, 1e-5);
  EXPECT_EQ(ended_of(table, 0, Subset::occluded).asked(), 0u);
}

TEST(TakeErrors, AreCountedByMillimetreAndBeyondTwoMetresByHalfAPerCent) {
  MadeTake made(3);
  for (std::uint64_t i = 0; i < 3; ++i)
    made.answer(i, 0, 0, made.truth_m(i, 0) + Vector3d(0, i == 2 ? 2.5 : 0.0505, 0));
  const TakeErrors table = made.errors(under({AlignmentKind::none}));
  ASSERT_EQ(table.histograms.at(0).bins, 2u);
  EXPECT_EQ(table.bins.at(0).bin, 50u);
  EXPECT_EQ(table.bins.at(0).n, 2u);
  EXPECT_LE(bin_starts_at_m(table.bins.at(1).bin), 2.5);
  EXPECT_GT(bin_starts_at_m(table.bins.at(1).bin + 1), 2.5);
  for (std::uint32_t bin = 0; bin < kLastBin; ++bin) {
    const double from_m = bin_starts_at_m(bin), to_m = bin_starts_at_m(bin + 1);
    EXPECT_NEAR(to_m - from_m, std::max(0.001, 0.005 * from_m * (bin < 2000 ? 0.0 : 1.0)), 1e-9 * to_m);
    EXPECT_EQ(bin_of(0.5 * (from_m + to_m)), bin);
  }
  EXPECT_EQ(bin_of(1e9), kLastBin);
  EXPECT_EQ(table.bins.at(1).n, 1u);
}

// Third differences of t^3 are 6 / rate^3 everywhere: the jerk of four answers in a row is 6 m/s^3.
TEST(TakeErrors, JerksAreOfFourAnswersInARow) {
  MadeTake made(20);
  made.each([&](std::uint64_t i, std::size_t j) {
    const double t = static_cast<double>(i) / kMadeRate_hz;
    made.set_truth(i, j, Vector3d(0, 1, t * t * t));
    made.answer(i, j, 0, made.truth_m(i, j));
  });
  made.miss(10, 0, 0);                                     // instants 0 to 9 and 11 to 19 are left
  made.set_truth(5, 1, Vector3d::Constant(std::nan("")));  // 0 to 4 and 6 to 19
  const TakeErrors table = made.errors(under({AlignmentKind::none}));
  // The jerk at an instant takes the one before and two behind; of the estimates it counts where the truth is
  // known.
  const ErrorSums truth = sums_of(table, Measure::jerk, kBody, 1, 1),
                  estimate = sums_of(table, Measure::jerk, kBody, 0, 1);
  EXPECT_EQ(truth.n, 17u + 2u + 11u);
  EXPECT_NEAR(truth.sum, 30 * 6.0, 0.1);
  EXPECT_EQ(estimate.n, 7u + 6u + 16u);
  EXPECT_NEAR(estimate.sum / 29.0, 6.0, 0.3);  // in single precision
}

TEST(TakeErrors, ABoneThatSwingsHasItsSpread) {
  MadeTake made(40);
  for (std::uint64_t i = 0; i < 40; ++i)
    made.answer(i, 1, 0, made.truth_m(i, 1) + Vector3d(0, i % 2 == 0 ? 0.01 : -0.01, 0));
  made.miss(0, 0, 0);
  made.miss(1, 1, 0);
  const TakeErrors table = made.errors(under({AlignmentKind::none}));
  const ErrorSums bones = sums_of(table, Measure::bone, kBody, 0, 1);
  EXPECT_EQ(bones.n, 1u);
  EXPECT_NEAR(bones.sum, 0.01 * std::sqrt(38.0 / 37.0), 1e-6);
}

TEST(TakeErrors, BodiesAreWholeAtInstantsAtWhichAllJointsAreAnswered) {
  MadeTake made(30, 2);
  made.each([&](std::uint64_t i, std::size_t j) {
    made.answer(i, j, 0, made.truth_m(i, j) + (j == 0 ? 1.0 : 2.0) * kError_m);
  });
  for (const std::uint64_t i : {4, 5}) made.miss(i, 1, 0);
  for (const std::uint64_t i : {5, 6, 7}) made.miss(i, 0, 1);
  made.set_truth(9, 1, Vector3d::Constant(std::nan("")));  // then a body is what is left of it
  const TakeErrors table = made.errors(under({AlignmentKind::none}));
  const ErrorSums first = sums_of(table, Measure::mpjpe, kBody),
                  second = sums_of(table, Measure::mpjpe, kBody, 1);
  EXPECT_EQ(first.n, 28u);
  EXPECT_NEAR(first.sum, 27 * 0.075 + 0.05, 1e-5);
  EXPECT_EQ(second.n, 27u);
  EXPECT_NEAR(second.sum, 0.0, 1e-5);
  // two joints have no rotation of their own
  EXPECT_TRUE(
      std::ranges::none_of(table.sums, [](const ErrorSums& row) { return row.is(Measure::pa_mpjpe); }));
}

TEST(TakeErrors, OfALeftOutSensorFollowThoseOfTheFirst) {
  MadeTake made(10);
  made.head.tracks = {"k1", "k2"};
  const ScratchFolder folder;
  StoredTake take = StoredTake::create(folder / StoredTake::kName, made.head);
  take.write(0, made.block);
  made.each([&](std::uint64_t i, std::size_t j) { made.answer(i, j, 0, made.truth_m(i, j) + kError_m); });
  take.write(1, made.block);
  take.finish();
  const TakeErrors table =
      errors_of(StoredTake::open(folder / StoredTake::kName), under({AlignmentKind::none}));
  EXPECT_NEAR(length_m(table, 0), 0.0, 1e-5);
  EXPECT_NEAR(length_m(table, 2), 0.5, 1e-5);
  EXPECT_EQ(ended_of(table, 3).asked(), 10u);
}

TEST(TakeErrors, OfALeftOutSensorAreSplitAlongItsRayAndAcross) {
  MadeTake made(1, 2);
  made.head.tracks = {"k1"};
  made.head.track_position_m = {{1.0, 0.0, 0.0}};
  made.set_truth(0, 0, {1.0, 0.0, 3.0});  // 3 m straight ahead
  made.answer(0, 0, 0, {1.0, 0.0, 3.5});  // behind it
  made.answer(0, 0, 1, {1.9, 0.0, 1.2});  // 1.5 m away, 0.9 m beside the ray
  const TakeErrors errors = made.errors(under({AlignmentKind::none}));
  const auto sum = [&](Measure measure, std::uint32_t method) {
    return sums_of(errors, measure, 0, method, 1);
  };
  EXPECT_NEAR(sum(Measure::range, 0).sum, 0.5, 1e-6);
  EXPECT_NEAR(sum(Measure::bearing, 0).sum, 0.0, 1e-6);
  EXPECT_NEAR(sum(Measure::range, 1).sum, -1.5, 1e-6);
  EXPECT_NEAR(sum(Measure::range, 1).sum_abs, 1.5, 1e-6);
  EXPECT_NEAR(sum(Measure::bearing, 1).sum, 0.9, 1e-6);
}

// An elbow whose truth bends by a degree an instant from 30 degrees on, and whose estimate bends by two; on
// the other side it is bent by 90 degrees and known at one instant alone.
TEST(TakeErrors, AnglesOfBothSidesAreTakenTogether) {
  MadeTake made(10);
  made.head.joints = {"shoulder_left",  "elbow_left",  "wrist_left",
                      "shoulder_right", "elbow_right", "wrist_right"};
  made.block.reset(0, 10, 6, 1);
  const auto bent = [](double degrees) {
    const double angle = degrees * M_PI / 180.0;
    return Vector3d(std::sin(angle), 1.0 - std::cos(angle), 0.0);
  };
  for (std::uint64_t i = 0; i < 10; ++i)
    for (const std::uint64_t side : {0U, 3U})
      for (const std::uint64_t joint : {0U, 1U, 2U}) {
        const auto at_m = [&](double degrees) {
          return joint == 0 ? Vector3d(0, 2, 0) : joint == 1 ? Vector3d(0, 1, 0) : bent(degrees);
        };
        const double t = static_cast<double>(i);
        const std::size_t place = i * 6 + side + joint;
        const bool is_known = side == 0 || i == 4;
        Eigen::Map<Vector3d>(&made.block.truth_m[3 * place]) =
            is_known ? at_m(side == 0 ? 30.0 + t : 90.0) : Vector3d::Constant(std::nan(""));
        Eigen::Map<Eigen::Vector3f>(&made.block.estimate_m[3 * place]) =
            at_m(side == 0 ? 30.0 + 2.0 * t : 80.0).cast<float>();
        made.block.status[place] = static_cast<std::uint8_t>(SolveStatus::converged);
      }
  const TakeErrors errors = made.errors(under({AlignmentKind::none}));
  ASSERT_EQ(errors.quantities.back(), "elbow flexion");
  const auto sum = [&](Measure measure) { return sums_of(errors, measure, 7, 0, 1); };
  const double degrees = M_PI / 180.0;
  EXPECT_EQ(sum(Measure::angle).n, 11u);
  EXPECT_NEAR(sum(Measure::angle).sum, (45.0 - 10.0) * degrees, 1e-5);
  EXPECT_NEAR(sum(Measure::true_angle).sum, (300.0 + 45.0 + 90.0) * degrees, 1e-5);
  EXPECT_NEAR(sum(Measure::motion_range).sum, 50.0 * degrees, 1e-5);
  EXPECT_NEAR(sum(Measure::true_motion_range).sum, 60.0 * degrees, 1e-5);
}

}  // namespace
}  // namespace trilat
