// SPDX-License-Identifier: MIT
#include "evaluators/metrics/cluster_contrast.h"

#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

// A mean of ratios whose numerators are scaled is their weighted sum.
RatioRange add_ratios(const std::vector<WeightedRatio>& sum, RowMatrix& columns,
                      std::vector<RatioColumns>& ratios) {
  const RatioRange range{ratios.size(), sum.size()};
  for (const WeightedRatio& ratio : sum) {
    const auto first = static_cast<Eigen::Index>(2 * ratios.size());
    const double scale = ratio.weight * static_cast<double>(sum.size());
    for (std::size_t c = 0; c < ratio.numerator.size(); ++c) {
      columns(static_cast<Eigen::Index>(c), first) = scale * ratio.numerator[c];
      columns(static_cast<Eigen::Index>(c), first + 1) = ratio.denominator[c];
    }
    ratios.push_back({2 * ratios.size(), 2 * ratios.size() + 1});
  }
  return range;
}

double half_width(const ContrastEstimate& e) {
  return e.clusters < 2 ? kNaN : student_quantile(e.clusters - 1) * e.standard_error;
}

}  // namespace

double ContrastEstimate::low() const { return value - half_width(*this); }
double ContrastEstimate::high() const { return value + half_width(*this); }

ContrastEstimate solve_contrast(const Contrast& contrast) {
  if (contrast.value.empty()) return {};
  RowMatrix columns(static_cast<Eigen::Index>(contrast.value.front().numerator.size()),
                    static_cast<Eigen::Index>(2 * (contrast.value.size() + contrast.base.size())));
  std::vector<RatioColumns> ratios;
  BootstrapQuantity quantity{add_ratios(contrast.value, columns, ratios)};
  if (!contrast.base.empty()) quantity.divided_by = add_ratios(contrast.base, columns, ratios);
  const std::vector<BootstrapQuantity> quantities{quantity};
  ContrastEstimate result;
  result.clusters = ClustersWithData(columns, ratios, quantities).count(0);
  ClusterRatios solved(ratios, quantities);
  solved.set(columns);
  const Studentised estimate = solved.of(0, result.clusters);
  if (!estimate.has_data) return result;
  result.value = estimate.value;
  result.standard_error = estimate.standard_error;
  return result;
}

}  // namespace trilat
