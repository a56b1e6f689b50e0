// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/work_part.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study/study.h"
#include "reports/table.h"

namespace trilat {

// What `trilat run` needs of a study before it is run.
struct OpenedStudy {
  Study study;
  Json plan;              // what --dry-run --json says
  std::string plan_text;  // what --dry-run says
  std::vector<std::filesystem::path> inputs = {};
};

// A kind of study that makes its own data.
struct GeneratedKind {
  StudyKind kind;
  std::string items;        // what its items are called
  std::string no_campaign;  // why a campaign is of no use
  OpenedStudy (*open)(const RunArguments& arguments, const Json& study);
  // To put parts together; `place`: of the work that they share.
  Study (*of_parts)(const Json& work, const std::string& place);
  std::vector<Table> (*tables)(const std::filesystem::path& results);
};

// All of them; adding one is a row.
const std::vector<GeneratedKind>& generated_kinds();
// Null when the kind is another.
const GeneratedKind* generated_kind(const std::string& name);

// `trilat merge` of such a study.
int merge_generated(const GeneratedKind& kind, const MergeArguments& arguments,
                    const std::vector<FoundPart>& parts);

}  // namespace trilat
