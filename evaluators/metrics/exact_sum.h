// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace trilat {

// A sum of doubles that is rounded only when it is read: equal terms give the same bits in whatever order and
// groups they were added, if no sum on the way is beyond all doubles. As expansions after Shewchuk, "Adaptive
// precision floating-point arithmetic and fast robust geometric predicates", 1997.
class ExactSum {
 public:
  void add(double term);
  void add(const ExactSum& other);
  // The double that is nearest to the sum, of two the even one. Not finite when a term was not, or a sum on
  // the way was beyond all doubles, as of 1e308 + 1e308 - 1e308.
  double value() const;
  // Adding them up again gives the same sum; they depend on the order of the terms.
  std::vector<double> parts() const;

 private:
  std::vector<double> parts_;  // finite, do not overlap, smallest first
  double not_finite_ = 0.0;    // infinite or NaN once that was met
};

}  // namespace trilat
