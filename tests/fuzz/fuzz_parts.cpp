// SPDX-License-Identifier: MIT
// A file of a part of a study among sound ones: the first byte chooses which, its text follows. The part is
// merged.
#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sweep/sweep_study.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/sound_parts.h"
#include "tests/fuzz/tolerate_bad_input.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

void merge(const fs::path& part, const fs::path& output) {
  const std::vector<FoundPart> parts = read_parts(std::vector{part});
  const std::string& kind = parts[0].part.kind;
  const Json& work = parts[0].part.work;
  const std::string place = (part / "part.json").string();
  const auto put_together = [&](const Study& study) {
    merge_parts(study, parts, output / kind, {.threads = 1});
  };
  if (kind == "accuracy") put_together(accuracy_of_parts(work, place));
  if (kind == "threshold_sweep") put_together(sweep_study(plan_of_work(work, place)));
  if (kind == "recording") put_together(recording_study(parse_recording_spec(work, place)));
  if (kind == "calibration") put_together(calibration_study(parse_calibration_spec(work, place)));
}

// What is sound is merged, so what is refused later is refused for what was changed.
fs::path sound_parts_in(const FuzzFolder& scratch) {
  const fs::path parts = scratch.with_sound("parts");
  for (const char* kind : {"accuracy", "sweep", "recording", "calibration"})
    merge(parts / kind, scratch.path() / "merged");
  return parts;
}

}  // namespace
}  // namespace trilat

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace trilat;
  static const FuzzFolder scratch("parts");
  static const std::filesystem::path parts = sound_parts_in(scratch);
  if (size == 0) return 0;
  const SoundPartFile& file = kSoundPartFiles[data[0] % kSoundPartFiles.size()];
  const std::filesystem::path path = parts / file.folder / file.name;
  const std::string sound = read_file(path);
  put(path, {reinterpret_cast<const char*>(data) + 1, size - 1});
  tolerate_bad_input([&] { merge(parts / file.folder, scratch.path() / "merged"); });
  put(path, sound);
  return 0;
}
