// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/take_summary.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include <gmock/gmock.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

using ::testing::HasSubstr;

// One take with two alignments, one of them trained, and samples that a sensor sees occluded.
struct OneTake {
  ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "campaign", walking_spec(1));
  StudySpec study = study_of(R"("occluded_apart": true, "block_s": 0.2,
      "alignments": ["rigid", "none", "joint_offset"], "methods": [{"method": "mean"}, {"method": "single"}])");
  Plan plan = make_plan(study, campaign);
  StatisticsLayout layout = statistics_layout(plan);
  std::uint64_t instants = plan.takes[0].instants;
  TakeSummary summary;

  OneTake() {
    execute_study(study, campaign, folder / "results", {});
    summary = summarise_take(SamplesFile::open(folder / "results/samples.h5"), 0, layout);
    write_take_summary(folder.path(), "key", summary);
  }
  std::string file() const { return read_file(folder / "summary.bin"); }
  void put(const std::string& text) const { write_file(folder / "summary.bin", text + hash_of_text(text)); }
  std::string said(const std::string& key = "key") const {
    return message_of([&] { read_take_summary(folder.path(), key, layout, instants); });
  }
  // A part of the one take, and the folder that the take has in it.
  std::filesystem::path part(const std::string& name) const {
    run_accuracy(study, campaign, folder / name, {.shard = {1, 1}});
    return item_folder(folder / name, "takes/" + campaign.takes[0].id);
  }
  void merge(const std::string& name) const {
    const std::vector<FoundPart> parts = read_parts(std::array{folder / name});
    merge_parts(accuracy_of_parts(parts[0].part.work, "part.json"), parts, folder / "merged", {});
  }
};

TEST(TakeSummary, ComesBackAsItWasToTheBit) {
  const OneTake take;
  const std::string first = take.file();
  const TakeSummary read = read_take_summary(take.folder.path(), "key", take.layout, take.instants).value();
  EXPECT_GT(read.statistics.sums[0].errors.answered(), 0);
  EXPECT_EQ(read.statistics.cells, take.summary.statistics.cells);
  EXPECT_EQ(read.alignments[2][0].offset.in_body_m(), take.summary.alignments[2][0].offset.in_body_m());
  EXPECT_EQ(read.alignments[2][0].first_instant, take.summary.alignments[2][0].first_instant);
  EXPECT_EQ(read.alignments[0][0].turns, take.summary.alignments[0][0].turns);
  EXPECT_FALSE(read.statistics.of_group[0].noise_sigma_m.empty());
  write_take_summary(take.folder.path(), "key", read);
  EXPECT_EQ(take.file(), first);
}

TEST(TakeSummary, OfAnotherStudyIsNone) {
  const OneTake take;
  EXPECT_FALSE(read_take_summary(take.folder.path(), "other", take.layout, take.instants));
  EXPECT_FALSE(read_take_summary(take.folder / "nowhere", "key", take.layout, take.instants));
}

TEST(TakeSummary, AnyByteThatChangedIsNoticed) {
  const OneTake take;
  const std::string good = take.file();
  for (std::size_t at = 0; at < good.size(); at += 1 + good.size() / 50) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    write_file(take.folder / "summary.bin", bad);
    EXPECT_THAT(take.said(), HasSubstr("summary.bin: is damaged")) << at;
  }
}

TEST(TakeSummary, OfAnotherLengthIsRefused) {
  OneTake take;
  const std::string file = take.file(), good = file.substr(0, file.size() - 64);
  take.put(good.substr(0, good.size() - 8));
  EXPECT_THAT(take.said(), HasSubstr("summary.bin: has another shape than its take"));
  take.put(good + "more");
  EXPECT_THAT(take.said(), HasSubstr("summary.bin: has another shape than its take"));
  take.put(good);
  EXPECT_EQ(take.said(), "no error");
  take.instants *= 2;
  EXPECT_THAT(take.said(), HasSubstr("summary.bin: has another shape than its take"));
}

TEST(TakeSummary, APartWithoutItCannotBeMergedAndSaysSo) {
  const OneTake take;
  std::filesystem::remove(take.part("part") / "summary.bin");
  EXPECT_THAT(message_of([&] { take.merge("part"); }), HasSubstr("summary.bin: is missing"));
  EXPECT_FALSE(std::filesystem::exists(take.folder / "merged"));
}

// What merging says when `change` was made to the samples of a finished part.
template <class Change>
std::string said_of_samples(const OneTake& take, const std::string& name, const Change& change) {
  const std::filesystem::path samples = take.part(name) / "samples.h5";
  const SamplesFile good = SamplesFile::open(samples);
  SampleBlock block = good.read(0, 0, take.instants);
  const auto answered = std::find_if(block.status.begin(), block.status.end(), [](std::uint8_t status) {
    return is_usable(static_cast<SolveStatus>(status));
  });
  change(block, static_cast<std::size_t>(answered - block.status.begin()));
  SamplesFile changed = SamplesFile::create(take.folder / "changed.h5", good.header());
  changed.write(0, block);
  changed.finish();
  std::filesystem::rename(take.folder / "changed.h5", samples);
  const std::string said = message_of([&] { take.merge(name); });
  EXPECT_EQ(std::filesystem::exists(take.folder / "merged"), said == "no error");
  std::filesystem::remove_all(take.folder / "merged");
  return said;
}

TEST(TakeSummary, SamplesThatChangedBehindItAreRefused) {
  const OneTake take;
  EXPECT_THAT(said_of_samples(take, "fewer",
                              [](SampleBlock& block, std::size_t slot) {
                                block.status[slot] = static_cast<std::uint8_t>(SolveStatus::not_solved);
                              }),
              HasSubstr("summary.bin: is not of the samples beside it"));
  EXPECT_THAT(
      said_of_samples(take, "moved",
                      [](SampleBlock& block, std::size_t slot) { block.estimate_m[3 * slot] += 1e-9; }),
      HasSubstr("summary.bin: is not of the samples beside it"));
  EXPECT_EQ(said_of_samples(take, "same", [](SampleBlock&, std::size_t) {}), "no error");
}

// Where the counts of the first cell begin, those asked and answered and of every status: behind two lines
// and the alignments.
std::size_t first_counts(const OneTake& take, const std::string& text) {
  constexpr std::size_t kAlignmentBytes = 1 + 1 + 4 * 8 + 3 * 8 + 8 + 8 + 3 * 8 + 8 + 1;
  const std::size_t alignments = 3 * take.layout.axes.joints * take.layout.axes.methods;
  return text.find('\n', text.find('\n') + 1) + 1 + alignments * kAlignmentBytes;
}

TEST(TakeSummary, OneSampleLessThanThereAreIsRefused) {
  const OneTake take;
  const std::filesystem::path file = take.part("part") / "summary.bin";
  std::string text = read_file(file);
  text.resize(text.size() - 64);
  std::array<std::int64_t, 2 + kSolveStatusCount> counts{};
  char* const at = &text[first_counts(take, text)];
  std::memcpy(counts.data(), at, sizeof counts);
  const auto used = std::find_if(counts.begin() + 2, counts.end(), [&](const std::int64_t& count) {
    return count > 0 && is_usable(static_cast<SolveStatus>(&count - counts.data() - 2));
  });
  ASSERT_NE(used, counts.end());
  for (std::int64_t* count : {&counts[0], &counts[1], &*used}) --*count;
  std::memcpy(at, counts.data(), sizeof counts);
  write_file(file, text + hash_of_text(text));
  EXPECT_THAT(message_of([&] { take.merge("part"); }),
              HasSubstr("summary.bin: is not of the samples beside it"));
}

TEST(TakeSummary, CountsOfBlocksThatCannotBeAreRefused) {
  const OneTake take;
  const auto said_with = [&](double wrong, bool of_bodies, std::size_t column) {
    TakeSummary summary = take.summary;
    TakeStatistics& s = summary.statistics;
    (of_bodies ? s.bodies : s.cells)(0, static_cast<Eigen::Index>(column)) = wrong;
    write_take_summary(take.folder.path(), "key", summary);
    return take.said();
  };
  for (const double wrong : {-1.0, 0.5, 4.8e52, std::numeric_limits<double>::quiet_NaN()})
    for (const auto& [of_bodies, column] : {std::pair{false, CellColumns::answered},
                                            {false, CellColumns::count + CellColumns::both},
                                            {true, BodySumColumns::whole},
                                            {true, BodySumColumns::pa_whole}})
      EXPECT_THAT(said_with(wrong, of_bodies, column),
                  HasSubstr("summary.bin: counts samples that cannot be"))
          << wrong << " in column " << column;
}

TEST(TakeSummary, CountsThatCannotBeAreRefused) {
  const OneTake take;
  const std::string file = take.file(), good = file.substr(0, file.size() - 64);
  const std::size_t asked = first_counts(take, good);
  for (const std::int64_t wrong : {std::int64_t{-5}, std::numeric_limits<std::int64_t>::max()}) {
    std::string bad = good;
    std::memcpy(&bad[asked], &wrong, sizeof wrong);
    take.put(bad);
    EXPECT_THAT(take.said(), HasSubstr("summary.bin: counts samples that cannot be")) << wrong;
  }
}

// Every sample that has a speed is in one half, the halves are about equal, and what is faster is in the
// faster.
TEST(TakeSummary, SamplesAreHalvedByTheSpeedOfTheirJoint) {
  OneTake take;
  const SamplesFile samples = SamplesFile::open(take.folder / "results/samples.h5");
  const SampleBlock block = samples.read(0, 0, take.instants);
  const SampleView view{block, take.layout.axes};
  const AlignmentTable& rigid = take.summary.alignments[0];
  for (std::size_t j = 0; j < take.layout.axes.joints; ++j)
    for (std::size_t m = 0; m < take.layout.axes.methods; ++m) {
      std::vector<std::pair<double, double>> all;  // speed, error
      for (std::uint64_t i = 1; i + 1 < take.instants; ++i) {
        const AlignedError e = error_of(view, i, j, m, view.slot(i, j, m), rigid);
        const Eigen::Vector3d way_m = view.truth(i + 1, j) - view.truth(i - 1, j);
        if (is_usable(e.status) && way_m.allFinite())
          all.emplace_back(way_m.norm() * take.layout.rate_hz / 2.0, e.error_m.norm());
      }
      std::ranges::sort(all);
      const JointSums& sums = take.summary.statistics.of_joint[j * take.layout.axes.methods + m];
      ASSERT_EQ(sums.slow_m.n + sums.fast_m.n, all.size());
      double slow_m = 0.0, fast_m = 0.0;
      for (std::size_t k = 0; k < all.size(); ++k) (k < sums.slow_m.n ? slow_m : fast_m) += all[k].second;
      EXPECT_NEAR(sums.slow_m.sum, slow_m, 1e-9);
      EXPECT_NEAR(sums.fast_m.sum, fast_m, 1e-9);
      EXPECT_GE(2 * sums.slow_m.n, all.size());
      EXPECT_LE(sums.slow_m.n, all.size() * 3 / 4);  // speeds are told apart to 2 cm/s
    }
}

}  // namespace
}  // namespace trilat
