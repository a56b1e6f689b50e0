// SPDX-License-Identifier: MIT
#include "pipeline/gate/accept_results.h"

#include <algorithm>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/gate/found_results.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// Over names and contents of all files but accepted.json itself.
std::string content_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path() != folder / "accepted.json")
      files.push_back(fs::relative(entry.path(), folder));
  std::ranges::sort(files);
  std::string list;
  for (const fs::path& file : files)
    list += hash_of_file(folder / file) + "  " + file.generic_string() + "\n";
  return hash_of_text(list);
}

void copy_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy(from, to, fs::copy_options::recursive, error);
  if (error)
    throw OutputError(to.string(), "cannot be copied from " + from.string() + ": " + error.message());
}

// All files but what is known of the hashes of others. Items are kept for their samples: what one night
// answers and the other does not is not compared.
void copy_results(const fs::path& from, const fs::path& to) {
  make_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from))
    if (entry.path().filename() != "hashes.json") copy_to(entry.path(), to / entry.path().filename());
}

// A folder that is filled beside the baseline and takes its place at the end.
class NewBaseline {
 public:
  explicit NewBaseline(const fs::path& baseline)
      : baseline_(baseline),
        partial_(partial_name(baseline)),
        old_(partial_.string() + ".old"),
        lock_(baseline) {
    // from a process that was killed between two renames
    if (!fs::exists(baseline_) && fs::is_directory(old_)) fs::rename(old_, baseline_);
    fs::remove_all(partial_);
    make_folder(partial_);
  }
  const fs::path& partial() const { return partial_; }
  void put_in_place() const {
    fs::remove_all(old_);
    std::error_code error;
    if (fs::exists(baseline_)) fs::rename(baseline_, old_, error);
    if (!error) fs::rename(partial_, baseline_, error);
    if (error) throw OutputError(baseline_.string(), "cannot be put in place: " + error.message());
    fs::remove_all(old_, error);
  }

 private:
  fs::path baseline_, partial_, old_;
  FolderLock lock_;
};

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

}  // namespace

std::vector<std::string> studies_only_in_baseline(const fs::path& results, const fs::path& baseline) {
  std::vector<std::string> names;
  if (!fs::is_directory(baseline) || fs::is_empty(baseline)) return names;
  const ResultsSet now = find_results(results), before = find_results(baseline);
  if (now.single) return names;
  for (const FoundResults& older : before.results) {
    const auto same = [&](const FoundResults& f) { return f.name == older.name; };
    if (std::ranges::none_of(now.results, same)) names.push_back(older.name);
  }
  return names;
}

AcceptedBaseline accept_results(const fs::path& results, const fs::path& given, const std::string& reason,
                                const std::string& time) {
  if (is_blank(reason))
    throw InputError("--accept", "needs a reason: why are these results right and the baseline is not?");
  const ResultsSet set = find_results(results);
  const fs::path baseline = given.has_filename() ? given : given.parent_path();
  AcceptedBaseline accepted{reason, time, kProgramVersion, "", "", ""};
  bool keeps_others = false;
  if (fs::exists(baseline) && !(fs::is_directory(baseline) && fs::is_empty(baseline))) {
    const ResultsSet before = find_results(baseline);  // never anything else's folder
    accepted.replaces_sha256 = content_of(baseline);
    if (const auto older = read_json_file<AcceptedBaseline>(baseline)) accepted.replaces_time = older->time;
    keeps_others = set.single && !before.single;
  }
  const NewBaseline folder(baseline);
  const fs::path& partial = folder.partial();
  if (keeps_others) {
    fs::remove_all(partial);
    copy_to(baseline, partial);
    std::string name = set.results[0].name;
    for (const FoundResults& other : find_results(baseline).results)
      if (other.study == set.results[0].study) name = other.name;
    fs::remove_all(partial / name);
    copy_results(set.results[0].folder, partial / name);
  } else if (set.single) {
    copy_results(set.results[0].folder, partial);
  } else {
    for (const FoundResults& found : set.results) copy_results(found.folder, partial / found.name);
  }
  accepted.sha256 = content_of(partial);
  write_json_file(partial, accepted);
  folder.put_in_place();
  return accepted;
}

}  // namespace trilat
