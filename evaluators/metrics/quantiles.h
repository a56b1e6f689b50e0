// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace trilat {

// The quantiles of `values`, in the order asked for, which rises from 0 to 1. Quantile q of n values in order
// is x at position (n - 1) q, linear between neighbours (type 7 of Hyndman and Fan 1996); NaN without values.
// Infinity is allowed; InternalError for NaN.
std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles);

}  // namespace trilat
