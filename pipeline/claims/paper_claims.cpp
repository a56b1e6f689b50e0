// SPDX-License-Identifier: MIT
#include "pipeline/claims/paper_claims.h"

#include <array>

namespace trilat {
namespace {

using Errors = ErrorMeasures;
using Clocks = ClocksSummary;

constexpr const char* kLastDigit3 = "the last printed digit of Table III, 0.1 of 8.7 cm";
constexpr const char* kLastDigit2 = "the last printed digit of Table II, 0.1 of 13.3 cm";
constexpr const char* kSimilar =
    "between the 3.8 % that the paper calls similar and the 17.8 % that it calls a big difference";
constexpr const char* kBig = "what counts as a big difference at the joints";
constexpr const char* kCompensated = "nonlinear, occlusion corrected";
constexpr const char* kMended = "nonlinear mended, C = 1e-4";
constexpr const char* kClocks = "corrected, causal";
constexpr const char* kQueueMargin =
    "17,997 of 18,000: what the paper loses without the seven frames that it calls slow; processing times "
    "are not in ours";

Measurements joined(Measurements first, Measurements second) {
  for (Measurement& more : second) first.push_back(std::move(more));
  return first;
}

Measurements against_nonlinear(const Errors& e, const std::string& of) {
  return joined(e.difference({of, "nonlinear"}), e.difference({"best of " + of, "nonlinear"}));
}

const std::array kClaims{
    PaperClaim{"combining_by_mean", "Introduction",
               "Several Kinects are more accurate than one: their plain mean, against one at random and "
               "against the best (chosen on other participants)",
               "no number", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) {
                 return joined(e.difference({"single", "mean"}), e.difference({"best of single", "mean"}));
               }},
    PaperClaim{"combining_by_trilateration", "Introduction",
               "Several Kinects are more accurate than one: nonlinear trilateration, against one at random "
               "and against the best (chosen on other participants)",
               "no number", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) { return against_nonlinear(e, "single"); }},
    PaperClaim{"better_than_linear", "Table III",
               "Nonlinear trilateration is more accurate than linear, on average over head, shoulder, elbow "
               "and wrist",
               "8.7 against 10.8 cm, 24.1 %", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) {
                 return e.difference({"linear", "nonlinear"});
               }},
    PaperClaim{"better_than_geometric", "Table III",
               "Nonlinear trilateration with four sensors is more accurate than geometric with three",
               "8.7 against 14.1 cm, 62.1 %", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) {
                 return e.difference({"geometric", "nonlinear"});
               }},
    PaperClaim{"better_than_every_triple", "Table III",
               "The same whichever three sensors geometric uses: their mean, and the best triple (chosen on "
               "other participants)",
               "one triple, not named", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) { return against_nonlinear(e, "geometric, each three"); }},
    PaperClaim{"head_similar", "Table III", "At the head the three methods are about the same",
               "5.3, 5.5, 5.3 cm", ClaimKind::tested, "table3", within(10), kSimilar,
               +[](const Errors& e) {
                 return joined(e.difference({.of = "linear", .against = "nonlinear", .each = {"head"}}),
                               e.difference({.of = "geometric", .against = "nonlinear", .each = {"head"}}));
               }},
    PaperClaim{"joints_differ", "Accuracy",
               "At shoulder, elbow and wrist the other two are far worse than nonlinear", "17.8 to 90.4 %",
               ClaimKind::tested, "table3", more_than(10), kSimilar,
               +[](const Errors& e) {
                 const std::vector<std::string> joints{"shoulder", "elbow", "wrist"};
                 return joined(e.difference({.of = "linear", .against = "nonlinear", .each = joints}),
                               e.difference({.of = "geometric", .against = "nonlinear", .each = joints}));
               }},
    PaperClaim{"wrist_worst", "Accuracy", "The wrist has the largest error (of nonlinear)",
               "14.2 cm; 86.8 % above the shoulder, the next", ClaimKind::tested, "table3", more_than(1),
               "the last printed digit of Table III, 0.1 of 7.6 cm",
               +[](const Errors& e) {
                 Measurements all;
                 for (const char* other : {"shoulder", "head", "elbow"})
                   all = joined(all, e.places("nonlinear", {.group = "wrist"}, {.group = other}));
                 return all;
               }},
    PaperClaim{"abrupt_joints_worse", "Accuracy",
               "Abrupt changes of velocity cause errors: a joint errs more in the half of its samples with "
               "the larger acceleration (of nonlinear)",
               "no number", ClaimKind::tested, "table3", more_than(1), kLastDigit3,
               +[](const Errors& e) { return e.abrupt(); }},
    PaperClaim{"three_sensors", "Accuracy",
               "Geometric is worst because it uses three sensors: nonlinear loses by it too, and on the same "
               "three the two are about the same",
               "no number", ClaimKind::tested, "table3", more_than(1),
               "the last printed digit of Table III; about the same: as at the head",
               +[](const Errors& e) {
                 Measurements same = e.difference({"geometric, each three", "nonlinear, each three"});
                 for (Measurement& number : same) number.bound = within(10);
                 return joined(joined(e.difference({"geometric, each three", "nonlinear"}),
                                      e.difference({"nonlinear, each three", "nonlinear"})),
                               std::move(same));
               }},
    PaperClaim{
        "more_sensors", "Introduction",
        "More sensors make trilateration more accurate: eight against sets of four of them, on each rig",
        "no number", ClaimKind::tested, "sensors", more_than(1), kLastDigit3,
        +[](const Errors& e) {
          return e.difference({"nonlinear, 4 sensors", "nonlinear, 8 sensors"});
        }},
    PaperClaim{"occlusion_arms", "Table II", "Occlusion compensation lowers the error of occluded arms",
               "18.5 without, 13.3 cm with, 39.1 %", ClaimKind::tested, "table2", more_than(1), kLastDigit2,
               +[](const Errors& e) {
                 return e.difference({"nonlinear", kCompensated, "arm_swing, occluded"});
               }},
    PaperClaim{"occlusion_legs", "Table II", "Occlusion compensation lowers the error of occluded legs",
               "23.2 without, 19.4 cm with, 19.6 %", ClaimKind::tested, "table2", more_than(1), kLastDigit2,
               +[](const Errors& e) {
                 return e.difference({"nonlinear", kCompensated, "leg_crossing, occluded"});
               }},
    PaperClaim{"occlusion_both", "Occlusion, figure of trajectories",
               "With compensation the joints are closer to OptiTrack in both experiments: elbow and ankle, "
               "all samples",
               "two curves, no number", ClaimKind::tested, "table2", more_than(1), kLastDigit2,
               +[](const Errors& e) {
                 return joined(e.difference({"nonlinear", kCompensated, "arm_swing", {"elbow"}}),
                               e.difference({"nonlinear", kCompensated, "leg_crossing", {"ankle"}}));
               }},
    PaperClaim{"legs_worse", "Table II",
               "Legs are worse than arms, with compensation, in the same participants",
               "19.4 against 13.3 cm, 45.9 %", ClaimKind::tested, "table2", more_than(1), kLastDigit2,
               +[](const Errors& e) {
                 return e.places(kCompensated, {.condition = "leg_crossing, occluded"},
                                 {.condition = "arm_swing, occluded"});
               }},
    PaperClaim{"wrist_deviation", "Accuracy, figure of trajectories",
               "The right wrist's height deviates by 5 cm at most, in extreme positions, and by less than 1 "
               "cm elsewhere (of nonlinear; the figure is of one person)",
               "5 cm; 1 cm", ClaimKind::tested, "table3", std::nullopt,
               "as printed; by less than 1 cm elsewhere: in the mean",
               +[](const Errors& e) { return e.wrist_deviation("nonlinear"); }},
    PaperClaim{"clock_good_enough", "Experiments",
               "Clocks of OptiTrack and Kinects that agree to 5 ms are good enough", "5 ms",
               ClaimKind::tested, "table3", less_than(10),
               "a tenth of the error at the fastest joints, which moves its square by a hundredth",
               +[](const Errors& e) { return e.clock_cost("nonlinear", 0.005); }},
    PaperClaim{"wand_accuracy", "Calibration",
               "A wand position inside the recommended range is known to 0.73 cm", "0.73 +- 0.85 cm of 50",
               ClaimKind::tested, "calibration", within(0.24),
               "the paper's own uncertainty: 1.96 times 0.85 cm by the root of 50",
               +[](const CalibrationSummary& s) { return wand_error(s, kRecommendedZone, 0.0073); }},
    PaperClaim{"wand_nearer", "Calibration", "The wand's error rises below 0.8 m", "a figure, no number",
               ClaimKind::tested, "calibration", more_than(10), kBig,
               +[](const CalibrationSummary& s) {
                 return wand_error(s, {{0.5, 0.8}, {0, 26}}, kRecommendedZone);
               }},
    PaperClaim{"wand_farther", "Calibration", "The wand's error rises beyond 3 m", "a figure, no number",
               ClaimKind::tested, "calibration", more_than(10), kBig,
               +[](const CalibrationSummary& s) {
                 return wand_error(s, {{3.0, 8.0}, {0, 26}}, kRecommendedZone);
               }},
    PaperClaim{"wand_aside", "Calibration", "The wand's error rises above 26 degrees", "a figure, no number",
               ClaimKind::tested, "calibration", more_than(10), kBig,
               +[](const CalibrationSummary& s) {
                 return wand_error(s, {{0.8, 3.0}, {26, 90}}, kRecommendedZone);
               }},
    PaperClaim{"image_edges",
               "Calibration, figure of distortion",
               "Columns 0 to 150 and 350 to 512 have a much higher depth error than those between",
               "a figure, no number",
               ClaimKind::untestable,
               "",
               std::nullopt,
               "the simulated unit's error at the edges of the image is a guess: real units would have to be "
               "measured",
               {}},
    PaperClaim{"clock_below_4ms", "Table IV",
               "All clock errors are below 4 ms (equations corrected, as a live system can)",
               "100 % of 71,998", ClaimKind::tested, "clocks", more_than(99.99),
               "one in 10,000, where the paper has none of 71,998",
               +[](const Clocks& s) { return clock_share(s, kClocks, 0.004); }},
    PaperClaim{"clock_below_2ms", "Table IV",
               "Clock errors are below 2 ms (equations corrected, as a live system can)",
               "71,740 of 71,998, which is 99.64 %", ClaimKind::tested, "clocks", more_than(99.64),
               "the printed counts", +[](const Clocks& s) { return clock_share(s, kClocks, 0.002); }},
    PaperClaim{"real_time", "Table IV",
               "Frames are taken in real time, when the server takes them as they come",
               "99.94 %; 3 of 18,000 lost", ClaimKind::tested, "clocks", more_than(99.98), kQueueMargin,
               +[](const Clocks& s) { return queue_share(s, kClocks, "as they come"); }},
    PaperClaim{"real_time_own_frames", "Table IV",
               "Frames are taken in real time, when the server takes them once a frame of its own",
               "99.94 %; 3 of 18,000 lost", ClaimKind::tested, "clocks", more_than(99.98), kQueueMargin,
               +[](const Clocks& s) { return queue_share(s, kClocks, "once a frame of its own"); }},
    PaperClaim{"threshold", "Table I",
               "C = 1e-4 is a compromise: 1e-6 takes more steps, 1 is less accurate, at every error range",
               "7.3 cm in 10 us against 6.6 cm in 783 us and 17.2 cm in less than 0.1 us", ClaimKind::listed,
               "table1", more_than(50),
               "of the study's interpretations whose errors all lie within a factor of 2 of the printed "
               "ones, with nine "
               "trials in ten answered; more steps: twice as many; less accurate: by a tenth",
               +[](const SweepSummary& s) { return acceptable_interpretations(s); }},
    PaperClaim{"percentages",
               "abstract, Table III",
               "By how many percent it is better than linear and geometric",
               "38.3 and 24.1 % in the abstract, 24.1 and 38.3 % in the text",
               ClaimKind::contradicts,
               "E12",
               std::nullopt,
               "by the paper's own numbers: see docs/explanation/paper.md",
               {}},
    PaperClaim{"averages",
               "Table III",
               "The averages of the four joints",
               "10.8, 14.1, 8.7 cm",
               ClaimKind::contradicts,
               "E13",
               std::nullopt,
               "by the paper's own numbers: see docs/explanation/paper.md",
               {}},
    PaperClaim{"cycles_and_systems",
               "Accuracy",
               "How many gait cycles, and how many systems are compared",
               "4 cycles and 6; four systems, of which three are shown",
               ClaimKind::contradicts,
               "E15",
               std::nullopt,
               "by the paper's own numbers: see docs/explanation/paper.md",
               {}},
    PaperClaim{"clock_share_printed",
               "Table IV",
               "The share of clock errors below 2 ms",
               "99.36 % in the text, 99.64 % by the table",
               ClaimKind::contradicts,
               "E14",
               std::nullopt,
               "by the paper's own numbers: see docs/explanation/paper.md",
               {}},
    PaperClaim{"wand_near",
               "Calibration",
               "Nearer than 0.5 m few calibrations are valid",
               "20 %",
               ClaimKind::untestable,
               "",
               std::nullopt,
               "a Kinect v2 gives no depth there, and neither does the simulated one: what the real one "
               "gives would have to be recorded",
               {}}};

const std::array kEffects{
    ErratumEffect{
        "E6", "table2",
        +[](const Errors& e) {
          return e.difference({"nonlinear, occlusion printed", kCompensated, "arm_swing, occluded"});
        }},
    ErratumEffect{"E7", "table3",
                  +[](const Errors& e) {
                    return e.difference({"nonlinear printed gradient, C = 1e-4", kMended});
                  }},
    ErratumEffect{"E8", "table3",
                  +[](const Errors& e) {
                    return e.difference({"nonlinear printed stop", kMended});
                  }},
    ErratumEffect{"E16", "table3", +[](const Errors& e) {
                    return e.difference({"nonlinear, each three", "nonlinear"});
                  }}};

void add_numbers(const char* id, const std::optional<ClaimBound>& bound, const Measurements& measured,
                 std::vector<ClaimNumber>& numbers) {
  for (const Measurement& one : measured) numbers.push_back(claim_number(id, one, bound));
}

// The numbers of every claim and erratum that such a repetition of the paper measures.
template <class Source>
std::vector<ClaimNumber> numbers_of(const std::string& paper, const Source& source) {
  std::vector<ClaimNumber> numbers;
  const auto measured_by = [&](const auto& row) -> Measurements (*)(const Source&) {
    const auto* measure = std::get_if<Measurements (*)(const Source&)>(&row.measure);
    return measure && row.study == paper ? *measure : nullptr;
  };
  for (const PaperClaim& claim : kClaims)
    if (const auto measure = measured_by(claim)) add_numbers(claim.id, claim.bound, measure(source), numbers);
  for (const ErratumEffect& effect : kEffects)
    if (const auto measure = measured_by(effect))
      add_numbers(effect.id, std::nullopt, measure(source), numbers);
  return numbers;
}

}  // namespace

std::span<const PaperClaim> paper_claims() { return kClaims; }
std::span<const ErratumEffect> erratum_effects() { return kEffects; }

std::vector<std::string> compared_with(const std::string& paper) {
  if (paper == name_of(PaperStudy::none)) return {};
  return {"nonlinear", "nonlinear, 8 sensors", "mean", kCompensated, kMended};
}

std::vector<ClaimNumber> claims_of(const StudyErrors& errors) {
  std::vector<ClaimNumber> numbers = numbers_of(errors.names().paper, ErrorMeasures(errors));
  if (errors.names().left_out())
    for (ClaimNumber& number : numbers)
      number = {.claim = number.claim, .missing = "motion capture: differences from a sensor are no errors"};
  return numbers;
}
std::vector<ClaimNumber> claims_of(const SweepSummary& summary) { return numbers_of(summary.paper, summary); }
std::vector<ClaimNumber> claims_of(const ClocksSummary& summary) {
  return numbers_of(summary.paper, summary);
}
std::vector<ClaimNumber> claims_of(const CalibrationSummary& summary) {
  return numbers_of(summary.paper, summary);
}

}  // namespace trilat
