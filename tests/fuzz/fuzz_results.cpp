// SPDX-License-Identifier: MIT
// A file of a results folder among sound ones: the first byte chooses which, JSON follows. All that a report
// and a gate make of it is made.
#include "datasets/results/gate_history.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/gate/found_results.h"
#include "reports/chapter.h"
#include "reports/claims/claims.h"
#include "reports/figures/draw_figures.h"
#include "reports/provenance.h"
#include "reports/render/latex.h"
#include "reports/render/render.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/sound_files.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

void print(const Table& table) {
  markdown_of(table);
  csv_of(table);
  latex_of(table);
}

void report_on(const SoundFile& file) {
  if (file.name == "accepted.json") {
    read_beside<AcceptedBaseline>(file.folder);
  } else if (file.name == "history.jsonl") {
    read_history(file.folder / file.name);
  } else if (file.name == "simulator.json") {
    print(parameters_table(read_declared_parameters(file.folder), "fuzz"));
  } else {
    const Chapter chapter = read_chapter(file.folder, true);
    for (const Table& table : chapter.tables) print(table);
    for (const DrawnFigure& figure : chapter.figures) gnuplot_script(figure.figure);
    if (const auto paper = judge_paper({file.folder})) print(claims_table(*paper));
  }
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trilat;
  static const FuzzFolder scratch("results");
  static const std::vector<SoundFile> files = sound_files(scratch.with_sound());
  if (size == 0) return 0;
  const SoundFile& file = files[data[0] % files.size()];
  put(file.folder / file.name, {reinterpret_cast<const char*>(data) + 1, size - 1});
  tolerate_bad_input([&] { report_on(file); });
  tolerate_bad_input([&] { find_results(file.folder); });
  put(file.folder / file.name, file.text);
  return 0;
}
