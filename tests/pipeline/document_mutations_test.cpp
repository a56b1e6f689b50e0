// SPDX-License-Identifier: MIT
// Every kind of document that users write, changed at random places: it is read or refused, and nothing else
// happens. `--gtest_random_seed=N` makes other changes.
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_spec.h"
#include "tests/support/paths.h"

namespace trilat {
namespace {

constexpr std::uint64_t kChanges = 1500;

class Dice {
 public:
  explicit Dice(std::uint64_t item)
      : random_{static_cast<std::uint64_t>(testing::UnitTest::GetInstance()->random_seed()), Purpose::test,
                item} {}
  std::size_t below(std::size_t count) {
    return std::min(count - 1,
                    static_cast<std::size_t>(random_.uniform(next_++) * static_cast<double>(count)));
  }

 private:
  RandomStream random_;
  std::uint32_t next_ = 0;
};

void collect(Json& json, std::vector<Json*>& all) {
  all.push_back(&json);
  if (json.is_structured())
    for (Json& inside : json) collect(inside, all);
}

Json odd_value(Dice& dice, const std::vector<Json*>& others) {
  const std::vector<Json> values{nullptr,
                                 true,
                                 0,
                                 -1,
                                 1e300,
                                 -0.5,
                                 1e-300,
                                 std::numeric_limits<std::uint64_t>::max(),
                                 std::numeric_limits<std::int64_t>::min(),
                                 "",
                                 "head",
                                 "../x",
                                 Json::array(),
                                 Json::object(),
                                 Json::array({1, 2}),
                                 Json{{"name", 1}}};
  const std::size_t pick = dice.below(values.size() + 4);
  return pick < values.size() ? values[pick] : *others[dice.below(others.size())];
}

void change(Json& document, Dice& dice) {
  std::vector<Json*> all;
  collect(document, all);
  Json& at = *all[dice.below(all.size())];
  const Json value = odd_value(dice, all);
  switch (dice.below(4)) {
    case 0:
      if (!at.empty() && at.is_structured()) {
        auto gone = at.begin();
        std::advance(gone, static_cast<std::ptrdiff_t>(dice.below(at.size())));
        at.erase(gone);
      }
      return;
    case 1:
      if (at.is_object()) at[std::vector{"nme", "paper", "each", "mocap"}[dice.below(4)]] = value;
      if (at.is_array()) at.push_back(value);
      return;
    default:
      at = value;
  }
}

struct Kind {
  std::string name;
  Json document;
  std::function<void(const Json&)> read;
};

template <class Document>
std::function<void(const Json&)> reading() {
  return [](const Json& json) { read_as<Document>(json, {"document.json"}); };
}

std::vector<Kind> kinds() {
  const auto shipped = [](const char* name) {
    Json json = read_json(std::filesystem::path(kSourceDir) / "pipeline" / "studies" / name);
    json.erase("scales");
    return json;
  };
  const auto simulation = [](const Json& json) { parse_simulation(json, "simulation.json", {}); };
  std::vector<Kind> kinds{
      {"sweep", shipped("table1.json"), [](const Json& json) { parse_sweep(json, "s.json"); }},
      {"calibration study", shipped("calibration.json"), reading<CalibrationSpec>()},
      {"clocks", shipped("clocks.json"), reading<ClocksSpec>()},
      {"campaign", Json::parse(R"({"format": "trilat.campaign", "version": 1, "name": "gait",
      "wand": {"session": "w.h5", "mocap": "w.csv", "asset": "wand", "mocap_start_host_ns": 0},
      "stated_distances": [{"session": "b.h5", "places": "places.csv"}],
      "walls": [{"session": "f.h5", "distance_m": 2}], "takes": [
      {"id": "a", "participant": "p", "session": "s.h5", "calibration": "c.json", "mocap": "m.csv",
       "mapping": "mapping.json", "mocap_start_host_ns": 0, "up_axis": "z",
       "joints": [{"method": "m", "file": "m.trc", "mapping": {"head": ["Head"]}, "clock": "motion"}]}]})"),
       reading<Campaign>()},
      {"mapping", Json::parse(R"({"format": "trilat.mapping", "version": 1,
      "joints": {"head": ["a", "b"], "wrist_left": ["rigid_body:c"]}})"),
       reading<JointMapping>()},
      {"calibration", Json::parse(R"({"format": "trilat.calibration", "version": 1,
      "method": "wand", "sensors": [{"name": "k1", "position_m": [0, 1, 2], "rotation_xyzw": [0, 0, 0, 1],
      "covariance": [1, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1], "used": 3}],
      "rejected": [{"sensor": "k1", "position": 0, "time_s": 0, "off_by_m": 0}],
      "reduced_chi2": 1, "sources": [{"file": "s.h5", "sha256": ""}]})"),
       reading<Calibration>()}};
  for (const char* name : {"table2.json", "table3.json", "table3_stages.json"})
    kinds.push_back({name, shipped(name), reading<StudySpec>()});
  for (const char* name : {"paper_campaign.json", "calibration_campaign.json", "stages_campaign.json"})
    kinds.push_back({name, shipped(name), simulation});
  return kinds;
}

TEST(DocumentMutations, AreReadOrRefusedAndNothingElse) {
  std::uint64_t item = 0;
  for (const Kind& kind : kinds()) {
    ASSERT_NO_THROW(kind.read(kind.document)) << kind.name;
    std::uint64_t refused = 0;
    for (std::uint64_t i = 0; i < kChanges; ++i) {
      Dice dice(item++);
      Json changed = kind.document;
      for (std::size_t more = dice.below(3) + 1; more > 0; --more) change(changed, dice);
      try {
        kind.read(changed);
      } catch (const InputError& error) {
        ++refused;
        EXPECT_FALSE(error.problem().empty());
      } catch (const std::exception& error) {
        ADD_FAILURE() << kind.name << ": " << error.what() << "\n" << changed.dump();
        return;
      }
    }
    EXPECT_GT(refused, kChanges / 4) << kind.name;
    EXPECT_LT(refused, kChanges) << kind.name;
  }
}

}  // namespace
}  // namespace trilat
