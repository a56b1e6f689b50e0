// SPDX-License-Identifier: MIT
// Every CSV that the program writes, read back by another reader: Python's.
#include <gmock/gmock.h>

#include "datasets/base/text_output.h"
#include "tests/pipeline/program.h"

namespace trilat {
namespace {

const std::vector<std::string> kHostile{"nonlinear, 3 sensors",
                                        "say \"cheese\"",
                                        "\"",
                                        "two\nlines",
                                        "a\r\nb",
                                        " blank before",
                                        "Über Größe",
                                        ",",
                                        "=1+1",
                                        "",
                                        "tab\there",
                                        "'"};

// What the script prints as JSON.
Json python(const ScratchFolder& folder, const std::string& script,
            const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"python3", file_with(folder, "read.py", script)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const Ended ended = Process(folder, words, "python-", "/usr/bin/env").wait();
  EXPECT_EQ(ended.code, 0) << ended.err;
  return ended.code == 0 ? parse_json(ended.out, "python") : Json();
}

TEST(Csv, AnyTextIsReadBackAsItWas) {
  const ScratchFolder folder;
  std::string text;
  Json rows = Json::array();
  for (const std::string& first : kHostile)
    for (const std::string& second : kHostile) {
      text += csv_field(first) + ',' + csv_field(second) + ',' + csv_quoted(first) + "\r\n";
      rows.push_back({first, second, first});
    }
  const std::string read = python(folder, R"(
import csv, json, sys
print(json.dumps(list(csv.reader(open(sys.argv[1], newline='', encoding='utf-8'), strict=True))))
)",
                                  {file_with(folder, "hostile.csv", text)})
                               .dump();
  EXPECT_EQ(read, rows.dump());
}

// For each file under the folder how many rows it has, and those that are not as wide as its header. An
// OptiTrack export has a line of its own and an empty one before.
constexpr const char* kWidths = R"(
import csv, json, pathlib, sys
found = {}
for path in sorted(pathlib.Path(sys.argv[1]).rglob('*.csv')):
    rows = list(csv.reader(open(path, newline='', encoding='utf-8'), strict=True))
    if rows[0][0] == 'Format Version': rows = rows[2:]
    found[str(path.relative_to(sys.argv[1]))] = [len(rows), [r for r in rows if len(r) != len(rows[0])]]
print(json.dumps(found))
)";

TEST(Csv, EveryFileOfEveryVerbHasRowsAsWideAsItsHeader) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "work");
  const std::string spec = file_with(folder, "simulation.json",
                                     R"({"format": "trilat.simulation", "version": 1, "name": "a, \"b\"",
      "participants": 1, "activities": [{"name": "walking", "duration_s": 1}]})");
  const std::string study = file_with(folder, "study.json", R"({"format": "trilat.study", "version": 1,
      "kind": "accuracy", "name": "test", "methods": [{"method": "mean", "name": "the \"mean\", of all"},
      {"method": "nonlinear", "name": " nonlinear, 3 sensors, Größe"}, {"method": "linear"}]})");
  const std::string work = folder / "work", session = work + "/campaign/p01-walking/session.h5";
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"simulate", spec, "-o", work + "/campaign"},
           {"run", study, "--campaign", work + "/campaign", "-o", work + "/results"},
           {"fuse", session, "--calibration", work + "/campaign/calibration.json", "-o",
            work + "/joints.csv"},
           {"report", work + "/results", "-o", work + "/report"}}) {
    const Ended ended = run_trilat(folder, words);
    ASSERT_EQ(ended.code, 0) << ended.err;
  }
  const Json found = python(folder, kWidths, {work});
  EXPECT_GT(found.size(), 15u);
  for (const auto& [file, rows] : found.items()) EXPECT_EQ(rows[1], Json::array()) << file;
  for (const char* file :
       {"joints.csv", "campaign/p01-walking/truth.csv", "campaign/p01-walking/mocap.csv",
        "report/tables/results/errors-walking.csv", "report/figures/results/errors-walking.csv"})
    EXPECT_TRUE(found.contains(file) && found[file][0] > 1) << file;
  EXPECT_THAT(read_file(work + "/report/tables/results/errors-walking.csv"),
              testing::HasSubstr("\"the \"\"mean\"\", of all\""));
}

}  // namespace
}  // namespace trilat
