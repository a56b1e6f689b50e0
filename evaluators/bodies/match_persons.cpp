// SPDX-License-Identifier: MIT
#include "evaluators/bodies/match_persons.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "datasets/base/error.h"
#include "datasets/base/median.h"

namespace trilat {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

double seconds(std::int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

double overlap_s(const Tracklet& a, const Tracklet& b) {
  return seconds(std::min(a.time_ns.back(), b.time_ns.back()) -
                 std::max(a.time_ns.front(), b.time_ns.front()));
}

// Distances at the times of `a` at which `b` is seen before and after.
std::vector<double> distances_m(const Tracklet& a, const Tracklet& b, double longest_hole_s) {
  std::vector<double> result;
  std::size_t after = 1;
  for (std::size_t i = 0; i < a.time_ns.size(); ++i) {
    while (after < b.time_ns.size() && b.time_ns[after] < a.time_ns[i]) ++after;
    if (after >= b.time_ns.size()) break;
    const std::int64_t from = b.time_ns[after - 1], to = b.time_ns[after];
    if (a.time_ns[i] < from || seconds(to - from) > longest_hole_s) continue;
    const double part = static_cast<double>(a.time_ns[i] - from) / static_cast<double>(to - from);
    const Eigen::Vector3d place_m =
        (1.0 - part) * b.centre_in_world_m[after - 1] + part * b.centre_in_world_m[after];
    result.push_back((a.centre_in_world_m[i] - place_m).norm());
  }
  return result;
}

// Above 0 when two tracklets look like one person, below when like two, more so the longer they overlap; 0
// when they cannot be compared.
double log_likelihood_ratio(const Tracklet& a, const Tracklet& b, const PersonOptions& options) {
  const double together_s = overlap_s(a, b);
  if (a.sensor == b.sensor && together_s >= 0.0) return kNever;
  if (together_s < options.least_overlap_s) return 0.0;
  std::vector<double> values_m = distances_m(a, b, options.longest_hole_s);
  if (values_m.empty()) return 0.0;
  return together_s * (1.0 - std::min(upper_median(values_m) / options.same_m, 2.0));
}

// The score of a merge is the sum over all pairs of their tracklets. A cluster is named by one of them.
class Clusters {
 public:
  Clusters(std::span<const Tracklet> tracklets, const PersonOptions& options)
      : count_(tracklets.size()), likeness_(count_ * count_, 0.0), cluster_(count_), best_(count_) {
    std::iota(cluster_.begin(), cluster_.end(), std::size_t{0});
    for (std::size_t a = 0; a < count_; ++a)
      for (std::size_t b = a + 1; b < count_; ++b)
        like(a, b) = like(b, a) = log_likelihood_ratio(tracklets[a], tracklets[b], options);
    for (std::size_t a = 0; a < count_; ++a) find_best(a);
  }

  std::size_t of(std::size_t tracklet) const { return cluster_[tracklet]; }
  double between(std::size_t a, std::size_t b) const { return likeness_[a * count_ + b]; }

  // The two clusters with most in common; nothing when no two have anything.
  std::optional<std::pair<std::size_t, std::size_t>> most_alike() const {
    std::optional<std::pair<std::size_t, std::size_t>> result;
    double most = 0.0;
    for (std::size_t a = 0; a < count_; ++a) {
      if (cluster_[a] != a || best_[a] == a || between(a, best_[a]) <= most) continue;
      most = between(a, best_[a]);
      result = std::minmax(a, best_[a]);
    }
    return result;
  }

  void join(std::size_t kept, std::size_t gone) {
    for (std::size_t& cluster : cluster_)
      if (cluster == gone) cluster = kept;
    for (std::size_t c = 0; c < count_; ++c)
      if (cluster_[c] == c && c != kept) like(c, kept) = like(kept, c) = between(kept, c) + between(gone, c);
    find_best(kept);
    for (std::size_t c = 0; c < count_; ++c) {
      if (cluster_[c] != c || c == kept) continue;
      if (best_[c] == kept || best_[c] == gone)
        find_best(c);
      else if (between(c, kept) > 0.0 && (best_[c] == c || between(c, kept) > between(c, best_[c])))
        best_[c] = kept;
    }
  }

 private:
  double& like(std::size_t a, std::size_t b) { return likeness_[a * count_ + b]; }
  // The cluster that has most in common with `a`; `a` itself when none has.
  void find_best(std::size_t a) {
    best_[a] = a;
    double most = 0.0;
    for (std::size_t b = 0; b < count_; ++b) {
      if (b == a || cluster_[b] != b || between(a, b) <= most) continue;
      most = between(a, b);
      best_[a] = b;
    }
  }

  std::size_t count_;
  std::vector<double> likeness_;
  std::vector<std::size_t> cluster_, best_;
};

struct TrackletLink {
  double cost;  // distance and time, each as a part of what is allowed
  std::size_t before, after;
};

// One tracklet after the other, or two of different sensors that overlap too shortly to be compared.
std::optional<TrackletLink> link_of(std::span<const Tracklet> tracklets, std::size_t before,
                                    std::size_t after, const PersonOptions& options) {
  const Tracklet &a = tracklets[before], &b = tracklets[after];
  const double absence_s = seconds(b.time_ns.front() - a.time_ns.back());
  const double earliest_s = a.sensor == b.sensor ? 0.0 : -options.least_overlap_s;
  if (absence_s < earliest_s || absence_s > options.longest_absence_s) return std::nullopt;
  const double away_s = std::max(absence_s, 0.0);
  const double distance_m = (b.centre_in_world_m.front() - a.centre_in_world_m.back()).norm();
  const double farthest_m = options.same_m + options.fastest_m_s * away_s;
  if (distance_m > farthest_m) return std::nullopt;
  return TrackletLink{distance_m / options.same_m + away_s, before, after};
}

void link_followers(std::span<const Tracklet> tracklets, const PersonOptions& options, Clusters& clusters) {
  std::vector<TrackletLink> links;
  for (std::size_t a = 0; a < tracklets.size(); ++a)
    for (std::size_t b = 0; b < tracklets.size(); ++b)
      if (a != b && clusters.of(a) != clusters.of(b))
        if (const auto link = link_of(tracklets, a, b, options)) links.push_back(*link);
  std::ranges::stable_sort(links,
                           [](const TrackletLink& a, const TrackletLink& b) { return a.cost < b.cost; });
  for (const TrackletLink& link : links) {
    const auto [kept, gone] = std::minmax({clusters.of(link.before), clusters.of(link.after)});
    if (kept != gone && clusters.between(kept, gone) >= 0.0) clusters.join(kept, gone);
  }
}

PersonMatch numbered(std::span<const Tracklet> tracklets, const Clusters& clusters) {
  struct Seen {
    std::size_t cluster, frames;
    std::int64_t first_ns;
  };
  std::vector<Seen> seen(tracklets.size());
  for (std::size_t i = 0; i < tracklets.size(); ++i)
    seen[i] = {i, 0, std::numeric_limits<std::int64_t>::max()};
  for (std::size_t i = 0; i < tracklets.size(); ++i) {
    Seen& person = seen[clusters.of(i)];
    person.frames += tracklets[i].time_ns.size();
    person.first_ns = std::min(person.first_ns, tracklets[i].time_ns.front());
  }
  std::erase_if(seen, [](const Seen& person) { return person.frames == 0; });
  std::ranges::stable_sort(seen, [](const Seen& a, const Seen& b) {
    return a.frames != b.frames ? a.frames > b.frames : a.first_ns < b.first_ns;
  });
  std::vector<std::size_t> number(tracklets.size(), 0);
  for (std::size_t n = 0; n < seen.size(); ++n) number[seen[n].cluster] = n;
  PersonMatch match{seen.size(), {}};
  for (std::size_t i = 0; i < tracklets.size(); ++i)
    match.person_of_tracklet.push_back(number[clusters.of(i)]);
  return match;
}

}  // namespace

PersonMatch match_persons(std::span<const Tracklet> tracklets, const PersonOptions& options) {
  for (const Tracklet& tracklet : tracklets)
    TRILAT_CHECK(
        !tracklet.time_ns.empty() && tracklet.time_ns.size() == tracklet.centre_in_world_m.size() &&
            std::ranges::adjacent_find(tracklet.time_ns, std::greater_equal<>()) == tracklet.time_ns.end(),
        "a tracklet has one place for each of its rising times");
  Clusters clusters(tracklets, options);
  while (const auto pair = clusters.most_alike()) clusters.join(pair->first, pair->second);
  link_followers(tracklets, options, clusters);
  return numbered(tracklets, clusters);
}

}  // namespace trilat
