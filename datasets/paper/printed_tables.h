// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace trilat {

// Table III as the paper prints it, centimetres. The printed averages differ from those of its rows (erratum
// E13).
struct PrintedTable3 {
  struct Row {
    std::string group;           // head, shoulder, elbow, wrist, average
    std::vector<double> mae_cm;  // by method
  };
  std::string source;
  std::vector<std::string> methods;  // linear, geometric, nonlinear
  std::vector<Row> rows;
};

PrintedTable3 printed_table3();

}  // namespace trilat
