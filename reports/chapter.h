// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/table.h"
#include "reports/figures/draw_figures.h"
#include "reports/page/replay_data.h"
#include "reports/provenance.h"

namespace trilat {

// The chapter of one results folder.
struct Chapter {
  Provenance provenance;
  std::filesystem::path results;
  std::string paper = {};  // of words<PaperStudy>
  std::string asked = {};  // the study's question
  std::string title;       // "table3 on paper campaign"
  std::string
      about;  // one sentence: how much of what, simulated or recorded; **bold** and `code` as in Markdown
  bool simulated = true;
  std::vector<std::string> findings = {};      // for the page's first screen, marked up alike
  std::vector<std::string> on_the_paper = {};  // findings beside what the paper prints
  std::vector<std::string> warnings = {};      // what a reader must know before believing a number
  std::vector<std::string> legend = {};        // one line a method of the first table, marked up alike
  std::vector<std::string> sentences = {};     // what it says, marked up alike
  std::vector<Table> tables = {};              // those that answer the study's question first, files last
  std::vector<DrawnFigure> figures = {};       // not drawn yet; those that answer the question first
  std::vector<PackedReplay> replays = {};
};

// Reads a results folder of any kind; with `paper`, what the paper says comes beside it and first.
// InputError with the place when it holds no results of this version.
Chapter read_chapter(const std::filesystem::path& results, bool paper);

}  // namespace trilat
