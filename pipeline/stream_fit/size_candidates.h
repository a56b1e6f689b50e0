// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/stream_fit/stream_change.h"

namespace trilat {

// Sizes that the numbers of the subject may have, the unchanged first: by ratios of distances between points,
// which need no common clock, frame or sides; of one point by how far it moves or how far from the origin it
// is.
std::vector<std::vector<SizeChange>> size_candidates(const StreamPair& pair);

// Points about which the subject's positions may have been taken: its point, or the middle of two, stays
// where it is while that of the reference moves; or it has no such point at all.
std::vector<BodyRoot> root_candidates(const StreamPair& pair, const std::vector<std::size_t>& mirrored);

// The axis along which all points of the subject are one number, while the reference moves along every axis.
std::optional<int> flat_axis(const StreamPair& pair);

}  // namespace trilat
