// SPDX-License-Identifier: MIT
#include "evaluators/alignment/alignment.h"

#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "evaluators/alignment/interpolation.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

struct Pair {
  Vector3d estimate_m;
  Vector3d truth_m;
};

std::vector<Pair> moved_pairs(const RigidTransform& truth_from_estimate, int count, double noise_m) {
  const RandomStream random{21, Purpose::test, 0};
  std::vector<Pair> result;
  std::uint32_t draw = 0;
  for (int i = 0; i < count; ++i) {
    const Vector3d p(random.normal(draw), random.normal(draw + 1), random.normal(draw + 2));
    const Vector3d e(random.normal(draw + 3), random.normal(draw + 4), random.normal(draw + 5));
    result.push_back({p, truth_from_estimate * p + noise_m * e});
    draw += 6;
  }
  return result;
}

AlignmentSums sums_of(const std::vector<Pair>& pairs) {
  AlignmentSums sums;
  for (const Pair& pair : pairs) sums.add(pair.estimate_m, pair.truth_m);
  return sums;
}

const RigidTransform kMove{Eigen::Quaterniond(Eigen::AngleAxisd(2.8, Vector3d(1, -1, 0.3).normalized())),
                           {1000, -2000, 30}};

TEST(Alignment, RigidFindsTheMotionExactly) {
  const Alignment found = solve_alignment(sums_of(moved_pairs(kMove, 50, 0.0)), AlignmentKind::rigid);
  EXPECT_EQ(found.status, AlignmentStatus::aligned);
  EXPECT_EQ(found.pairs, 50);
  EXPECT_LT(found.truth_from_estimate.rotation.angularDistance(kMove.rotation), 1e-7);
  const Vector3d p(0.3, -0.2, 1.0);
  EXPECT_LT((found.truth_from_estimate * p - kMove * p).norm(), 1e-10);
}

// Three points are in a plane: the reflection through it fits as well as the rotation, and must not be taken.
TEST(Alignment, RigidNeverReflects) {
  const std::vector<Pair> triangle = moved_pairs(kMove, 3, 0.0);
  const Alignment flat = solve_alignment(sums_of(triangle), AlignmentKind::rigid);
  EXPECT_EQ(flat.status, AlignmentStatus::aligned);
  EXPECT_LT((flat.truth_from_estimate * triangle[2].estimate_m - triangle[2].truth_m).norm(), 1e-9);
  std::vector<Pair> mirrored = moved_pairs({}, 30, 0.0);
  for (Pair& pair : mirrored) pair.truth_m.x() *= -0.3;
  const Alignment best = solve_alignment(sums_of(mirrored), AlignmentKind::rigid);
  EXPECT_NEAR(best.truth_from_estimate.rotation.toRotationMatrix().determinant(), 1.0, 1e-12);
}

// The corners of a tetrahedron with edges of one length are mirrored by exchanging two of them.
TEST(Alignment, PointsSayHowWellTheirMirrorImageFits) {
  const std::vector<Vector3d> a{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  std::vector<Vector3d> moved, mirrored;
  for (const Vector3d& p : a) {
    moved.push_back(kMove * (2.0 * p));
    mirrored.push_back(kMove * Vector3d(-p.x(), p.y(), p.z()));
  }
  const PointFit sound = fit_points(a, moved), other = fit_points(a, mirrored);
  EXPECT_NEAR(sound.scale, 2.0, 1e-9);
  EXPECT_NEAR(sound.rms_m, std::sqrt(3.0), 1e-6);  // of twice the size: each corner is off by its length
  // by Umeyama: spreads 3 and 12, singular values 2 each, so that 15 - 2 (2 + 2 - 2) is left of the mirror
  // image
  EXPECT_NEAR(sound.mirrored_rms_m, std::sqrt(11.0), 1e-6);
  EXPECT_NEAR(other.mirrored_rms_m, 0.0, 1e-5);
  EXPECT_NEAR(other.rms_m, 2.0, 1e-6);  // 6 - 2 (1 + 1 - 1)
}

// The least squares are at a minimum: turning or shifting a little only makes it worse.
TEST(Alignment, RigidIsTheLeastSquaresMotion) {
  const std::vector<Pair> pairs = moved_pairs(kMove, 40, 0.3);
  const RigidTransform best = solve_alignment(sums_of(pairs), AlignmentKind::rigid).truth_from_estimate;
  const auto cost = [&](const RigidTransform& t) {
    double sum = 0.0;
    for (const Pair& pair : pairs) sum += (t * pair.estimate_m - pair.truth_m).squaredNorm();
    return sum;
  };
  const Vector3d centre = best * sums_of(pairs).mean_estimate_m();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double by : {-1e-3, 1e-3}) {
      RigidTransform turned = best;
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(by, Vector3d::Unit(axis)));
      turned.rotation = turn * best.rotation;
      turned.translation_m = centre + turn * (best.translation_m - centre);
      EXPECT_GT(cost(turned), cost(best));
      RigidTransform shifted = best;
      shifted.translation_m[axis] += by;
      EXPECT_GT(cost(shifted), cost(best));
    }
  }
}

TEST(Alignment, PointsOnALineDoNotFixARotation) {
  AlignmentSums sums;
  for (int i = 0; i < 10; ++i) {
    const Vector3d p = Vector3d(1, 2, 3) + i * Vector3d(0.1, -0.2, 0.3);
    sums.add(p, kMove * p);
  }
  const Alignment line = solve_alignment(sums, AlignmentKind::rigid);
  EXPECT_EQ(line.status, AlignmentStatus::degenerate);
  EXPECT_TRUE(line.truth_from_estimate.translation_m.array().isNaN().all());
  EXPECT_EQ(solve_alignment(sums, AlignmentKind::mean).status, AlignmentStatus::aligned);
  AlignmentSums one;
  one.add({1, 2, 3}, {4, 5, 6});
  EXPECT_EQ(solve_alignment(one, AlignmentKind::rigid).status, AlignmentStatus::degenerate);
}

TEST(Alignment, FirstAndMeanAreTranslations) {
  AlignmentSums sums;
  sums.add({1, 0, 0}, {3, 1, 0});
  sums.add({2, 0, 0}, {6, 3, 0});
  const RigidTransform first = solve_alignment(sums, AlignmentKind::first).truth_from_estimate;
  EXPECT_EQ(first.translation_m, Vector3d(2, 1, 0));
  const RigidTransform mean = solve_alignment(sums, AlignmentKind::mean).truth_from_estimate;
  EXPECT_EQ(mean.translation_m, Vector3d(3, 2, 0));
  EXPECT_EQ(mean.rotation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
  const Alignment none = solve_alignment({}, AlignmentKind::none);
  EXPECT_EQ(none.status, AlignmentStatus::aligned);
  EXPECT_EQ(none.truth_from_estimate * Vector3d(1, 2, 3), Vector3d(1, 2, 3));
}

TEST(Alignment, SaysWhenThereWasNothingOrNotANumber) {
  for (const auto kind : {AlignmentKind::first, AlignmentKind::mean, AlignmentKind::rigid}) {
    EXPECT_EQ(solve_alignment({}, kind).status, AlignmentStatus::no_pairs);
    AlignmentSums sums = sums_of(moved_pairs(kMove, 5, 0.0));
    AlignmentSums bad;
    bad.add({kNaN, 0, 0}, {0, 0, 0});
    bad.merge(sums);
    const Alignment result = solve_alignment(bad, kind);
    EXPECT_EQ(result.status, AlignmentStatus::not_finite) << name_of(kind);
    EXPECT_TRUE(result.truth_from_estimate.translation_m.array().isNaN().all());
  }
}

TEST(Alignment, MergedSumsAreTheSumsOfTheWhole) {
  const std::vector<Pair> pairs = moved_pairs(kMove, 60, 0.1);
  const AlignmentSums whole = sums_of(pairs);
  AlignmentSums merged;
  for (const auto& [from, to] : {std::pair{0, 7}, {7, 7}, {7, 40}, {40, 60}})
    merged.merge(sums_of({pairs.begin() + from, pairs.begin() + to}));
  EXPECT_EQ(merged.count(), 60);
  EXPECT_EQ(merged.first_truth_m(), whole.first_truth_m());
  EXPECT_LT((merged.mean_truth_m() - whole.mean_truth_m()).norm(), 1e-11);
  EXPECT_LT((merged.cross_m2() - whole.cross_m2()).norm(), 1e-9);
}

TEST(Interpolation, IsLinearBetweenNeighboursAndNothingAcrossAGap) {
  const MocapTime a{1'000}, b{2'000};
  const Vector3d pa(0, 0, 0), pb(4, 8, -4);
  EXPECT_EQ(*interpolate(MocapTime{1'250}, a, pa, b, pb, Duration{1'000}), Vector3d(1, 2, -1));
  EXPECT_FALSE(interpolate(MocapTime{1'250}, a, pa, b, pb, Duration{999}));
  EXPECT_EQ(*interpolate(a, a, pa, b, pb, Duration{1}), pa);
  EXPECT_EQ(*interpolate(b, a, pa, b, pb, Duration{1}), pb);
  EXPECT_FALSE(interpolate(MocapTime{999}, a, pa, b, pb, Duration{1'000}));
  EXPECT_FALSE(interpolate(MocapTime{2'001}, a, pa, b, pb, Duration{1'000}));
}

}  // namespace
}  // namespace trilat
