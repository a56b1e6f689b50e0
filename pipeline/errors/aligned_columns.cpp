// SPDX-License-Identifier: MIT
#include "pipeline/errors/aligned_columns.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace trilat {
namespace {

bool learns(AlignmentKind kind) { return kind != AlignmentKind::none && kind != AlignmentKind::held_out; }

AlignmentRow row_of(std::uint32_t a, std::uint32_t m, std::uint32_t j, const JointAlignment& solved) {
  AlignmentRow row{j, m, a, static_cast<std::uint32_t>(solved.first_instant)};
  if (solved.kind == AlignmentKind::joint_offset) {
    Eigen::Map<Eigen::Vector3d>(row.offset_m.data()) = solved.offset.in_body_m();
    return row;
  }
  const Eigen::Quaterniond& q = solved.alignment.truth_from_estimate.rotation;
  row.rotation = {q.w(), q.x(), q.y(), q.z()};
  Eigen::Map<Eigen::Vector3d>(row.shift_m.data()) = solved.shift_m;
  return row;
}

}  // namespace

AlignedColumns::AlignedColumns(const Windows& windows, const TakeHead& head, const SampleMarks& marks,
                               const ErrorSettings& settings)
    : marks_(marks),
      joints_(head.joints.size()),
      methods_(head.methods.size()),
      alignments_(settings.alignments.size()),
      turns_(std::ranges::find(settings.alignments, AlignmentKind::rigid) != settings.alignments.end()),
      columns_of_(methods_) {
  if (std::ranges::any_of(settings.alignments, is_trained))
    training_end_ = static_cast<std::uint64_t>(
        std::llround(settings.training_share * static_cast<double>(head.instants)));
  const std::vector<SampleSet>& answered = marks.answered();
  for (std::size_t m = 0; m < methods_; ++m) columns_.push_back({m, answered[m]});
  for (const auto& [first, second] : settings.pairs) {
    const SampleSet both = answered[first] & answered[second];
    pairs_.push_back({column_of(first, both), column_of(second, both)});
  }
  for (std::size_t c = methods_; c < columns_.size(); ++c) columns_of_[columns_[c].method].push_back(c);
  std::vector<AlignedSums> sums(columns_.size() * joints_);
  if (std::ranges::any_of(settings.alignments, learns))
    windows.each([&](const Window& w) {
      for (std::size_t j = 0; j < joints_; ++j)
        for (std::size_t c = 0; c < columns_.size(); ++c) learn(w, j, columns_[c], sums[c * joints_ + j]);
    });
  for (const AlignmentKind kind : settings.alignments)
    for (std::size_t c = 0; c < columns_.size(); ++c)
      solve(kind, std::span(sums).subspan(c * joints_, joints_));
}

std::size_t AlignedColumns::column_of(std::size_t method, const SampleSet& samples) {
  for (std::size_t c = 0; c < columns_.size(); ++c)
    if (columns_[c].method == method && columns_[c].samples == samples) return c;
  columns_.push_back({method, samples});
  return columns_.size() - 1;
}

void AlignedColumns::learn(const Window& w, std::size_t j, const Column& column, AlignedSums& sums) const {
  for (std::uint64_t i = w.first; i < w.end; ++i) {
    if (!column.samples.has(marks_.place(i, j))) continue;
    const auto estimate_m = w.estimate_m(w.slot(i, j, column.method));
    sums.whole.add(estimate_m, w.truth_m(i, j), turns_);
    if (i >= training_end_) continue;
    if (const double heading_rad = w.block.heading_rad[i - w.begins()]; std::isfinite(heading_rad))
      sums.trained.add(estimate_m, w.truth_m(i, j), heading_rad);
  }
}

void AlignedColumns::solve(AlignmentKind kind, std::span<const AlignedSums> of_joints) {
  AlignmentSums whole;
  if (kind == AlignmentKind::rigid)
    for (const AlignedSums& sums : of_joints) whole.merge(sums.whole);
  for (const AlignedSums& sums : of_joints) {
    JointAlignment& solved = alignment_.emplace_back();
    solved.kind = kind;
    if (is_trained(kind)) solved.first_instant = training_end_;
    if (kind == AlignmentKind::joint_offset) {
      solved.offset = sums.trained;
      continue;
    }
    solved.alignment = solve_alignment(kind == AlignmentKind::rigid ? whole : sums.whole, kind);
    const RigidTransform& transform = solved.alignment.truth_from_estimate;
    solved.turns = transform.rotation.coeffs() != Eigen::Quaterniond::Identity().coeffs();
    solved.shift_m = transform.translation_m;
  }
}

std::vector<AlignmentRow> AlignedColumns::rows() const {
  std::vector<AlignmentRow> rows;
  for (std::uint32_t a = 0; a < alignments_; ++a)
    for (std::uint32_t m = 0; m < methods_; ++m)
      for (std::uint32_t j = 0; j < joints_; ++j) rows.push_back(row_of(a, m, j, alignment(a, m, j)));
  return rows;
}

}  // namespace trilat
