// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"
#include "datasets/rig/campaign.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study/study.h"

namespace trilat {

// Arguments of `trilat run`.
struct RunArguments {
  std::filesystem::path study;
  std::filesystem::path campaign;
  std::filesystem::path calibration;  // instead of the takes' own
  std::filesystem::path output;
  int threads = 0;  // 0: as many as there are processors
  bool cross_check = false;
  bool dry_run = false;
  std::string shard;   // k/n, or empty: all of it
  bool fresh = false;  // nothing is taken from what `output` holds
  bool force = false;  // may replace what others wrote
  bool json = false;
  bool tables = false;  // all of them are printed
};

// A study that was read, as `trilat run` needs it.
struct OpenedStudy {
  std::function<ItemCounts(const StudyOptions& options)> run;  // into the output, on the caller's threads
  // Says what would be computed, on stdout, and gives the exit code.
  std::function<int(const Shard& shard, bool json, const RunControl& control)> print_plan;
  std::vector<std::filesystem::path> inputs = {};            // that it reads beside what the arguments name
  std::optional<Campaign> campaign = {};                     // whose takes it evaluates
  std::function<void(const ItemCounts&)> print_failed = {};  // why, on stderr, where items may fail
};

// How results are said.
struct PrintOptions {
  bool json = false;
  bool tables = false;  // all of them, however long
};

// A kind of study.
struct Kind {
  StudyKind kind;
  std::string items;        // what its items are called
  std::string no_campaign;  // why a campaign is of no use; empty: it needs one
  OpenedStudy (*open)(const RunArguments& arguments, const Json& study);
  // Says what the results are, on stdout, and gives the exit code. `document`: what --json says besides.
  int (*print)(const std::filesystem::path& results, Json document, const PrintOptions& shown);
  Json (*schema)();  // JSON Schema of its study.json
};

// All of them; adding one is a row.
const std::vector<Kind>& kinds();
// Null when the kind is another.
const Kind* find_kind(const std::string& name);

// Errors under some alignments as --json prints them: a row a condition, group, method and alignment.
Json errors_json(const ResultsSummary& summary, std::span<const std::string> alignments);
// The campaign that the command line names, else the study's; InputError where neither does.
Campaign campaign_of(const std::filesystem::path& of_study, const RunArguments& arguments);
// Enters a recording that its name calls a wand's or a wall's ("wand/session.h5", "wall_2m.h5"), or beside
// which places.csv states a ball's distances; of several wands the first. False for another, which is a take.
bool add_calibration_recording(const std::filesystem::path& session, Campaign& campaign);
// Endings of a session's file, in small letters.
inline const std::set<std::string> kSessionEndings{".h5", ".hdf5"};
// All files that end so, in letters of either case, below a folder, in order; not in folders of results.
std::vector<std::filesystem::path> files_below(const std::filesystem::path& folder,
                                               const std::set<std::string>& extensions);
// Everything that it reads.
std::vector<std::filesystem::path> inputs_of(const Campaign& campaign);

OpenedStudy open_accuracy(const RunArguments& arguments, const Json& study);
int print_accuracy(const std::filesystem::path& results, Json document, const PrintOptions& shown);

// Prints the stored title, tables, findings and warnings of a study on stdout. Only the first tables are
// printed, cut to the width of a terminal; with `all` every table that a report shows is printed whole.
void print_stored(const std::filesystem::path& results, bool all = false);

// The scales that `trilat reproduce` knows, the smallest first; the documents that are built in say under
// "scales", as a JSON merge patch, what each changes of them. The last changes nothing.
inline const std::vector<std::string> kScales{"demo", "quick", "paper", "full"};

// A document of pipeline/studies at a scale, without its "scales". InternalError for a name that is none.
Json built_in_study(const std::string& name, const std::string& scale = "full");
Json built_in_campaign(const std::string& name, const std::string& scale = "full");

std::vector<std::string> built_in_studies();

// items, items_computed, items_found, items_failed, unchanged.
Json tally_json(const ItemCounts& tally);

// On stderr, what was not computed and what had to be computed again, when there was such; `items`: what they
// are called.
void print_item_counts(const std::string& items, const ItemCounts& tally);

// On stderr, what a run that was stopped has left where.
void tell_interrupted(const std::filesystem::path& folder);

}  // namespace trilat
