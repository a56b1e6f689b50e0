// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "datasets/results/gate_history.h"
#include "datasets/results/paper_evidence.h"
#include "datasets/results/summary.h"
#include "datasets/results/table.h"
#include "reports/figures/draw_figures.h"
#include "reports/provenance.h"

namespace trilat {

// The data for the replay of one take, as JSON: names, the skeleton, counts, and `points` in base64, which is
// a zlib stream of 16-bit little-endian millimetres (-32768: there is none). Each channel is all instants of
// one number, the first as it is and then differences modulo 2^16. Channels, in order: x, y, z of
// the truth of every evaluated joint; of every method's estimate of these joints.
struct PackedReplay {
  std::string title;  // "table3: walking, take p01-walking"
  std::string json;
};

// The first evaluated take of each condition: of its first 35 s at most 15 instants a second, with the truth,
// the study's reference, the best method, nonlinear and mean.
std::vector<PackedReplay> packed_replays(const std::filesystem::path& results, const ResultsSummary& summary);

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

// Content of the first screen; **bold** and `code` as in Markdown.
struct Headline {
  std::string origin;                 // "Simulated data", "Recorded data", or both
  std::string asked;                  // one question
  std::vector<std::string> answers;   // one sentence or two each, the first ones first
  std::vector<std::string> warnings;  // what to know before believing them
  std::vector<std::string> legend;    // one line a method of the figure
  std::vector<std::pair<ClaimVerdict, std::size_t>> verdicts;  // on the paper's claims, and how many
  std::optional<DrawnFigure> history;                          // errors by night
};

// All that a report says, before it is written in any form. The ids of its tables and figures differ:
// STUDY/NAME.
struct ReportContent {
  Headline headline;
  std::optional<Table> changes;  // between two results of one study
  std::optional<Table> claims;
  std::optional<Table> errata;  // of the paper; beside its claims
  std::vector<Chapter> chapters;
  std::vector<Table> parameters;  // one for all studies that assume the same

  // All, in the order of the report.
  std::vector<const Table*> tables() const;
};

// Reads results folders in this order and draws their figures. `paper`: what they say about the paper, as far
// as that was asked; `changes`: between two of them; `history`: of the nights, whose verdict leads.
// `progress` gets the share that is done.
ReportContent read_report(const std::vector<std::filesystem::path>& results,
                          const std::optional<PaperFindings>& paper = {},
                          const std::optional<ErrorChanges>& changes = {},
                          const std::vector<Night>& history = {},
                          const std::function<void(double)>& progress = {});

// The first screen of a report, and which of its figures stand there.
Headline headline_of(ReportContent& content, const std::optional<PaperFindings>& paper,
                     const std::optional<ErrorChanges>& changes);
// The first screen for a terminal, in lines of at most 100 characters.
std::string headline_text(const Headline& headline);
// "3 warnings, the first".
std::string warnings_text(const Headline& headline);

}  // namespace trilat
