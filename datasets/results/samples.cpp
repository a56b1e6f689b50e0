// SPDX-License-Identifier: MIT
#include "datasets/results/samples.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/hdf5/hdf5_file.h"

namespace trilat {
namespace {

constexpr const char* kSamplesFormat = "trilat.samples";
constexpr std::int64_t kSamplesVersion = 3;
constexpr std::size_t kMostTakes = 20'000;
constexpr std::int64_t kMostNs = std::int64_t{1} << 61;  // so that differences of two times cannot overflow
constexpr std::size_t kMaxEstimates = 1u << 14;          // of an instant: blocks of instants are read whole

struct TakeTables {
  H5Table time_ns, heading_rad, truth_m, ranges, occluded, estimate_m, error_m, status, iterations, cost_m2,
      gdop;
};

// Makes or opens one table of a take.
template <class Table>
TakeTables tables_of(std::uint64_t joints, std::uint64_t methods, const Table& table) {
  return {table("time_ns", H5Type::i64, {}),
          table("heading_rad", H5Type::f32, {}),
          table("truth_m", H5Type::f64, {joints, 3}),
          table("ranges", H5Type::u8, {joints}),
          table("occluded", H5Type::u8, {joints}),
          table("estimate_m", H5Type::f64, {joints, methods, 3}),
          table("error_m", H5Type::f32, {joints, methods, 3}),
          table("status", H5Type::u8, {joints, methods}),
          table("iterations", H5Type::u32, {joints, methods}),
          table("cost_m2", H5Type::f64, {joints, methods}),
          table("gdop", H5Type::f32, {joints, methods})};
}

using Shape = std::vector<std::uint64_t>;

void check_block(const SampleBlock& block, const TakeTables& t, std::size_t statuses) {
  const auto [first, last] = std::minmax_element(block.time_ns.begin(), block.time_ns.end());
  if (first != block.time_ns.end() && (*first < -kMostNs || *last > kMostNs))
    throw InputError(t.time_ns.place(), "holds a time beyond 73 years, which no clock shows");
  const auto status = std::ranges::max_element(block.status);
  if (status != block.status.end() && *status >= statuses)
    throw InputError(t.status.place(), fmt::format("holds the status {}, which has no name", *status));
}

// Groups are numbered so that they sort in the order of the takes.
std::string group_name(std::size_t take) { return fmt::format("{:05}", take); }

}  // namespace

void SampleBlock::reset(std::uint64_t first, std::uint64_t count, std::size_t joints, std::size_t methods) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  first_instant = first;
  instants = count;
  time_ns.assign(count, 0);
  heading_rad.assign(count, std::numeric_limits<float>::quiet_NaN());
  truth_m.assign(count * joints * 3, kNaN);
  ranges.assign(count * joints, 0);
  occluded.assign(count * joints, 0);
  estimate_m.assign(count * joints * methods * 3, kNaN);
  status.assign(count * joints * methods, 0);
  iterations.assign(count * joints * methods, 0);
  cost_m2.assign(count * joints * methods, kNaN);
  gdop.assign(count * joints * methods, std::numeric_limits<float>::quiet_NaN());
}

struct SamplesFile::State {
  std::filesystem::path path;
  H5File file;
  SamplesHeader header;
  std::vector<TakeTables> takes;
};

SamplesFile::SamplesFile() : state_(std::make_unique<State>()) {}
SamplesFile::~SamplesFile() = default;
SamplesFile::SamplesFile(SamplesFile&&) noexcept = default;

SamplesFile SamplesFile::create(const std::filesystem::path& path, const SamplesHeader& header) {
  SamplesFile samples;
  State& s = *samples.state_;
  s.path = path;
  s.header = header;
  s.file = H5File::create(path);
  s.file.set_text("format", kSamplesFormat);
  s.file.set_integer("version", kSamplesVersion);
  s.file.set_text("created_by", kProgramVersion);
  s.file.set_texts("joints", header.joints);
  s.file.set_texts("methods", header.methods);
  s.file.set_texts("status_names", header.status_names);
  s.file.set_text("alignment", header.alignment);
  s.file.set_number("training_share", header.training_share);
  H5Node takes = s.file.create_group("takes");
  for (std::size_t t = 0; t < header.takes.size(); ++t) {
    H5Node node = takes.create_group(group_name(t));
    node.set_text("id", header.takes[t].id);
    node.set_text("condition", header.takes[t].condition);
    const std::uint64_t instants = header.takes[t].instants;
    s.takes.push_back(tables_of(header.joints.size(), header.methods.size(),
                                [&](const char* name, H5Type type, const Shape& shape) {
                                  return node.create_table(name, type, shape, {}, instants);
                                }));
  }
  return samples;
}

SamplesFile SamplesFile::open(const std::filesystem::path& path) {
  SamplesFile samples;
  State& s = *samples.state_;
  s.path = path;
  s.file = H5File::open(path);
  if (!s.file.has_attribute("format") || s.file.text("format") != kSamplesFormat)
    throw InputError(path.string(), "is not a samples file of this program");
  if (s.file.integer("version") != kSamplesVersion)
    throw InputError(path.string(), "is a samples file of another format version");
  s.header.joints = s.file.texts("joints");
  s.header.methods = s.file.texts("methods");
  s.header.status_names = s.file.texts("status_names");
  s.header.alignment = s.file.text("alignment");
  s.header.training_share = s.file.number("training_share");
  if (s.header.joints.size() * s.header.methods.size() > kMaxEstimates)
    throw InputError(path.string(),
                     fmt::format("has {} joints x {} methods, more than the {} allowed",
                                 s.header.joints.size(), s.header.methods.size(), kMaxEstimates));
  const H5Node takes = s.file.group("takes");
  for (const std::string& name : takes.children(kMostTakes)) {
    const H5Node node = takes.group(name);
    s.takes.push_back(tables_of(
        s.header.joints.size(), s.header.methods.size(),
        [&](const char* table, H5Type type, const Shape& shape) { return node.table(table, type, shape); }));
    s.header.takes.push_back({node.text("id"), s.takes.back().time_ns.rows(), node.text("condition")});
  }
  return samples;
}

void SamplesFile::finish() {
  state_->takes.clear();
  state_->file.close();
  sync_file(state_->path);
}

const std::filesystem::path& SamplesFile::path() const { return state_->path; }
const SamplesHeader& SamplesFile::header() const { return state_->header; }

void SamplesFile::write(std::size_t take, const SampleBlock& b) {
  TakeTables& t = state_->takes.at(take);
  const auto put = [&](H5Table& table, const auto& values) {
    table.write(b.first_instant, std::span(values.data(), values.size()));
  };
  put(t.time_ns, b.time_ns);
  put(t.heading_rad, b.heading_rad);
  put(t.truth_m, b.truth_m);
  put(t.ranges, b.ranges);
  put(t.occluded, b.occluded);
  put(t.estimate_m, b.estimate_m);
  put(t.status, b.status);
  put(t.iterations, b.iterations);
  put(t.cost_m2, b.cost_m2);
  put(t.gdop, b.gdop);
}

void SamplesFile::write_errors(std::size_t take, std::uint64_t first_instant,
                               std::span<const float> error_m) {
  state_->takes.at(take).error_m.write(first_instant, error_m);
}

SampleBlock SamplesFile::read(std::size_t take, std::uint64_t first_instant, std::uint64_t instants,
                              SampleColumns columns) const {
  SampleBlock block;
  read(take, first_instant, instants, columns, block);
  return block;
}

void SamplesFile::read(std::size_t take, std::uint64_t first_instant, std::uint64_t instants,
                       SampleColumns columns, SampleBlock& b) const {
  const TakeTables& t = state_->takes.at(take);
  const bool all = columns == SampleColumns::all;
  b.first_instant = first_instant;
  b.instants = instants;
  const auto get = [&](const H5Table& table, auto& values, bool wanted = true) {
    values.resize(wanted ? instants * table.row_elements() : 0);
    if (wanted) table.read(first_instant, std::span(values.data(), values.size()));
  };
  get(t.time_ns, b.time_ns);
  get(t.heading_rad, b.heading_rad);
  get(t.truth_m, b.truth_m);
  get(t.estimate_m, b.estimate_m);
  get(t.status, b.status);
  get(t.occluded, b.occluded);
  check_block(b, t, state_->header.status_names.size());
  get(t.ranges, b.ranges, all);
  get(t.iterations, b.iterations, all);
  get(t.cost_m2, b.cost_m2, all);
  get(t.gdop, b.gdop, all);
}

std::vector<float> SamplesFile::read_errors(std::size_t take, std::uint64_t first_instant,
                                            std::uint64_t instants) const {
  std::vector<float> errors(instants * state_->header.joints.size() * state_->header.methods.size() * 3);
  state_->takes.at(take).error_m.read(first_instant, std::span<float>(errors));
  return errors;
}

}  // namespace trilat
