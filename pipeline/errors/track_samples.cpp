// SPDX-License-Identifier: MIT
#include "pipeline/errors/track_samples.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace trilat {

SampleFlags::SampleFlags(const Windows& windows, const TakeHead& head)
    : instants_(head.instants),
      marks_(head.joints.size() * head.instants),
      answered_(head.methods.size(), SampleSet(marks_.size())) {
  windows.each([&](const Window& w) {
    for (std::size_t j = 0; j < head.joints.size(); ++j)
      for (std::uint64_t i = w.first; i < w.end; ++i) {
        if (!w.has_truth(i, j)) continue;
        const std::size_t k = place(i, j);
        marks_[k] = kAsked;
        if (w.block.occluded[w.place(i, j)] > 0) marks_[k] |= kOccluded;
        for (std::size_t m = 0; m < answered_.size(); ++m)
          if (is_usable(w.status(w.slot(i, j, m)))) answered_[m].add(k);
      }
  });
}

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

ColumnAlignments::ColumnAlignments(const Windows& windows, const TakeHead& head, const SampleFlags& marks,
                                   const ErrorSettings& settings, std::span<const SampleColumn> columns)
    : marks_(marks),
      joints_(head.joints.size()),
      columns_(columns.size()),
      training_end_(settings.training_end(head.instants)),
      turns_(std::ranges::find(settings.alignments, AlignmentKind::rigid) != settings.alignments.end()) {
  std::vector<AlignedSums> sums(columns_ * joints_);
  if (std::ranges::any_of(settings.alignments, learns))
    windows.each([&](const Window& w) {
      for (std::size_t j = 0; j < joints_; ++j)
        for (std::size_t c = 0; c < columns_; ++c) learn(w, j, columns[c], sums[c * joints_ + j]);
    });
  for (const AlignmentKind kind : settings.alignments)
    for (std::size_t c = 0; c < columns_; ++c) solve(kind, std::span(sums).subspan(c * joints_, joints_));
}

void ColumnAlignments::learn(const Window& w, std::size_t j, const SampleColumn& column,
                             AlignedSums& sums) const {
  for (std::uint64_t i = w.first; i < w.end; ++i) {
    if (!column.samples.has(marks_.place(i, j))) continue;
    const Eigen::Vector3d estimate_m = w.estimate_m(w.slot(i, j, column.method));
    sums.whole.add(estimate_m, w.truth_m(i, j), turns_);
    if (i >= training_end_) continue;
    if (const double heading_rad = w.block.heading_rad[i - w.begins()]; std::isfinite(heading_rad))
      sums.trained.add(estimate_m, w.truth_m(i, j), heading_rad);
  }
}

void ColumnAlignments::solve(AlignmentKind kind, std::span<const AlignedSums> of_joints) {
  AlignmentSums whole;
  if (kind == AlignmentKind::rigid)
    for (const AlignedSums& sums : of_joints) whole.merge(sums.whole);
  for (const AlignedSums& sums : of_joints) {
    JointAlignment& solved = solved_.emplace_back();
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

std::vector<AlignmentRow> ColumnAlignments::rows() const {
  std::vector<AlignmentRow> rows;
  for (std::size_t k = 0; k < solved_.size(); ++k) {
    const auto row = static_cast<std::uint32_t>(k / joints_), columns = static_cast<std::uint32_t>(columns_);
    rows.push_back(row_of(row / columns, row % columns, static_cast<std::uint32_t>(k % joints_), solved_[k]));
  }
  return rows;
}

}  // namespace trilat
