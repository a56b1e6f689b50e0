// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/take_summary.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <string_view>
#include <type_traits>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr const char* kFile = "summary.bin";
constexpr std::string_view kSummaryFormat = "trilat.take_summary 3\n";
constexpr std::size_t kHashDigits = 64;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::size_t kOtherBytes = 1 << 20;  // that most summaries have besides block sums

static_assert(std::endian::native == std::endian::little, "numbers are stored as they lie in memory");

class Writer {
 public:
  explicit Writer(std::string& bytes) : bytes_(bytes) {}
  template <class T>
  void operator()(const T& value) const {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
  }
  void resize(const std::vector<double>& values, std::uint64_t) const {
    (*this)(std::uint64_t{values.size()});
  }

 private:
  std::string& bytes_;
};

class Reader {
 public:
  Reader(std::string_view bytes, std::string place) : left_(bytes), place_(std::move(place)) {}
  template <class T>
  void operator()(T& value) const {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    if (left_.size() < sizeof(T)) refuse();
    std::memcpy(&value, left_.data(), sizeof(T));
    left_.remove_prefix(sizeof(T));
  }
  void operator()(bool& value) const {
    std::uint8_t byte = 0;
    (*this)(byte);
    value = byte != 0;
  }
  void resize(std::vector<double>& values, std::uint64_t most) const {
    std::uint64_t count = 0;
    (*this)(count);
    if (count > most) refuse();
    values.resize(count);
  }
  void finish() const {
    if (!left_.empty()) refuse();
  }
  [[noreturn]] void refuse() const {
    throw InputError(place_, "has another shape than its take; run that shard again");
  }

 private:
  mutable std::string_view left_;
  std::string place_;
};

template <class See, class M>
void see_mean(const See& see, M& mean) {
  see(mean.sum);
  see(mean.n);
}

template <class See, class A>
void see_alignment(const See& see, A& joint) {
  see(joint.kind);
  see(joint.alignment.status);
  for (int k = 0; k < 4; ++k) see(joint.alignment.truth_from_estimate.rotation.coeffs()[k]);
  for (int k = 0; k < 3; ++k) see(joint.alignment.truth_from_estimate.translation_m[k]);
  see(joint.alignment.pairs);
  JointOffset::see_state(joint.offset, see);
  see(joint.first_instant);
  see(joint.turns);
}

template <class See, class S>
void see_statistics(const See& see, S& s, std::uint64_t blocks) {
  for (auto& cell : s.sums) {
    ErrorSums::see_state(cell.errors, see);
    CompensatedSum::see_state(cell.gdop, see);
    CompensatedSum::see_state(cell.iterations, see);
    CompensatedSum::see_state(cell.square_gdop, see);
    CompensatedSum::see_state(cell.square_error_m2, see);
    see(cell.with_gdop);
  }
  for (Eigen::Index k = 0; k < s.cells.size(); ++k) see(s.cells.data()[k]);
  for (Eigen::Index k = 0; k < s.bodies.size(); ++k) see(s.bodies.data()[k]);
  for (auto& cell : s.one_frame) {
    see_mean(see, cell.later_m);
    see_mean(see, cell.earlier_m);
  }
  for (auto& joint : s.of_joint) {
    see(joint.asked);
    for (auto* mean : {&joint.distance_m, &joint.slow_m, &joint.fast_m}) see_mean(see, *mean);
    for (auto* paired : {&joint.both, &joint.complete}) {
      see_mean(see, paired->method_m);
      see_mean(see, paired->reference_m);
    }
  }
  for (auto& bodies : s.of_method) {
    for (auto& count : bodies.within) see(count);
    see(bodies.joints);
    see(bodies.bones);
    see_mean(see, bodies.bone_sd_m);
    see_mean(see, bodies.jerk_m_s3);
  }
  for (auto& truth : s.of_group) {
    see_mean(see, truth.speed_m_s);
    see.resize(truth.noise_sigma_m, blocks);
    for (auto& sigma_m : truth.noise_sigma_m) see(sigma_m);
  }
  see_mean(see, s.truth_jerk_m_s3);
}

template <class See, class S>
void see_summary(const See& see, S& summary, std::uint64_t blocks) {
  for (auto& table : summary.alignments)
    for (auto& joint : table) see_alignment(see, joint);
  see_statistics(see, summary.statistics, blocks);
}

// Of rows of sums in groups of `of_each` columns: whether these ones of every group are counts, to `most`.
bool are_counts(const RowMatrix& sums, std::size_t of_each, std::initializer_list<std::size_t> columns,
                std::uint64_t most) {
  for (const std::size_t column : columns)
    for (auto c = static_cast<Eigen::Index>(column); c < sums.cols();
         c += static_cast<Eigen::Index>(of_each)) {
      const auto count = sums.col(c).array();
      if (!(count >= 0.0 && count <= static_cast<double>(most) && count == count.floor()).all()) return false;
    }
  return true;
}

// `most`: samples of one method in a take.
void check_counts(const TakeStatistics& statistics, std::uint64_t most, const std::string& place) {
  const auto refuse = [&] { throw InputError(place, "counts samples that cannot be; run that shard again"); };
  if (!are_counts(statistics.cells, CellColumns::count, {CellColumns::answered, CellColumns::both}, most) ||
      !are_counts(statistics.bodies, BodySumColumns::count, {BodySumColumns::whole, BodySumColumns::pa_whole},
                  most))
    refuse();
  for (const JointSums& joint : statistics.of_joint)
    for (const Mean* mean : {&joint.distance_m, &joint.slow_m, &joint.fast_m, &joint.both.method_m,
                             &joint.both.reference_m, &joint.complete.method_m, &joint.complete.reference_m})
      if (joint.asked > most || mean->n > joint.asked || !std::isfinite(mean->sum)) refuse();
  for (const CellSums& cell : statistics.sums) {
    std::uint64_t all = 0, answered = 0;
    bool right = cell.errors.asked() >= 0;
    for (int s = 0; s < kSolveStatusCount; ++s) {
      const std::int64_t count = cell.errors.count_of(static_cast<SolveStatus>(s));
      right = right && count >= 0 && static_cast<std::uint64_t>(count) <= most;
      if (!right) break;
      all += static_cast<std::uint64_t>(count);
      answered += is_usable(static_cast<SolveStatus>(s)) ? static_cast<std::uint64_t>(count) : 0;
    }
    if (!right || all != static_cast<std::uint64_t>(cell.errors.asked()) || all > most ||
        answered != static_cast<std::uint64_t>(cell.errors.answered()) || cell.with_gdop > answered ||
        !std::isfinite(cell.errors.distance_m().value()))
      refuse();
  }
}

std::string head_of(const std::string& key) { return std::string(kSummaryFormat) + key + '\n'; }

}  // namespace

TakeSummary summarise_take(const SamplesFile& samples, std::size_t take, const StatisticsLayout& layout) {
  TakeAlignments alignments = align_take(samples, take, layout);
  TakeSummary summary;
  summary.statistics = gather_take(samples, take, layout, alignments);
  for (KindAlignments& kind : alignments) summary.alignments.push_back(std::move(kind.own));
  return summary;
}

void write_take_summary(const std::filesystem::path& folder, const std::string& key,
                        const TakeSummary& summary) {
  const TakeStatistics& s = summary.statistics;
  std::string text = head_of(key);
  text.reserve(text.size() + sizeof(double) * static_cast<std::size_t>(s.cells.size() + s.bodies.size()) +
               kOtherBytes);
  see_summary(Writer(text), summary, static_cast<std::uint64_t>(s.cells.rows()));
  text += hash_of_text(text);
  write_file(folder / kFile, text);
}

std::optional<TakeSummary> read_take_summary(const std::filesystem::path& folder, const std::string& key,
                                             const StatisticsLayout& layout, std::uint64_t instants) {
  if (!std::filesystem::exists(folder / kFile)) return std::nullopt;
  const std::string place = (folder / kFile).string(), text = read_file(place, kMostBytes);
  const std::string head = head_of(key);
  if (text.size() < kHashDigits ||
      hash_of_text(std::string_view(text).substr(0, text.size() - kHashDigits)) !=
          std::string_view(text).substr(text.size() - kHashDigits))
    throw InputError(place, "is damaged; run that shard again");
  if (!text.starts_with(head)) return std::nullopt;
  TakeSummary summary;
  summary.alignments.assign(layout.axes.alignments, AlignmentTable(layout.axes.joints * layout.axes.methods));
  summary.statistics = empty_statistics(layout, instants);
  const Reader reader(std::string_view(text).substr(head.size(), text.size() - head.size() - kHashDigits),
                      place);
  see_summary(reader, summary, layout.blocks(instants));
  reader.finish();
  check_counts(summary.statistics, instants * layout.axes.joints, place);
  summary.file = place;
  return summary;
}

}  // namespace trilat
