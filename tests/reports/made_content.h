// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "reports/report_content.h"

namespace trilat {

// One row a method, with an interval, a mark and what the paper prints.
inline Table errors_table() {
  Table table;
  table.id = "table3/errors";
  table.title = "Error";
  table.about = "2 takes, simulated";
  table.columns = {{"method", "method", true},
                   interval_column("head (cm)", "head_mae_cm"),
                   interval_column("average (cm)", "average_mae_cm")};
  const auto row = [&](const char* method, double cm) {
    table.rows.push_back({TableValue::of(method), {cm, 1, {}, cm - 1.0, cm + 1.0}, TableValue::of(cm, 2)});
  };
  row("linear", 5.0);
  row("mean", 4.0);
  table.rows[0][1].mark = TableValue::Mark::not_distinguished;
  table.rows[1][1].mark = TableValue::Mark::best;
  table.rows[0][2].beside = "paper 8.7";
  table.notes = {"Of a < b."};
  table.shown = Table::Placement::first;
  return table;
}

inline Provenance made_of(const std::string& folder) {
  Provenance made;
  made.folder = folder;
  made.study = "walks";
  made.program = "trilat 0.5.0";
  made.campaign = "lab";
  made.seed = "7";
  made.rig = {"k1", "k2"};
  made.wall_s = "2.5";
  made.config = "{}";
  made.inputs = {{"t1", "session", "t1.h5", "ab12"}, {"t2", "mocap", "t2.csv", std::nullopt}};
  return made;
}

inline Chapter chapter_of(const std::string& folder) {
  Chapter chapter;
  chapter.provenance = made_of(folder);
  chapter.asked = "Which method errs least?";
  chapter.title = folder + " on lab";
  chapter.about = "Two takes.";
  chapter.simulated = false;
  return chapter;
}

inline DrawnFigure drawn_figure(const std::string& id, bool is_first) {
  DrawnFigure drawn;
  drawn.figure = {
      .id = id, .title = "Errors of " + id, .caption = "A caption.", .x_label = "", .y_label = ""};
  drawn.figure.is_first = is_first;
  drawn.svg = "<svg/>";
  drawn.pdf = "%PDF";
  return drawn;
}

}  // namespace trilat
