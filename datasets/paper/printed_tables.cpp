// SPDX-License-Identifier: MIT
#include "datasets/paper/printed_tables.h"

#include <algorithm>
#include <limits>

#include "datasets/base/units.h"
#include "datasets/paper/embedded_paper.h"

namespace trilat {
namespace {

template <Described T>
T read_printed(const char* text, const std::string& name) {
  const std::string place = "datasets/paper/" + name;
  return read_as<T>(parse_json(text, place), {place});
}

}  // namespace

PrintedTable1 printed_table1() { return read_printed<PrintedTable1>(embedded::table1_json, "table1.json"); }
PrintedTable2 printed_table2() { return read_printed<PrintedTable2>(embedded::table2_json, "table2.json"); }
PrintedTable3 printed_table3() { return read_printed<PrintedTable3>(embedded::table3_json, "table3.json"); }
PrintedTable4 printed_table4() { return read_printed<PrintedTable4>(embedded::table4_json, "table4.json"); }
PrintedCalibration printed_calibration() {
  return read_printed<PrintedCalibration>(embedded::calibration_json, "calibration.json");
}
PrintedErrata printed_errata() { return read_printed<PrintedErrata>(embedded::errata_json, "errata.json"); }

double printed_cm(const PrintedTable3& table, const std::vector<std::string>& groups,
                  const std::string& group, const std::string& method) {
  const bool are_the_papers =
      groups.size() == table.rows.size() && std::ranges::all_of(table.rows, [&](const PrintedTable3::Row& r) {
        return std::ranges::find(groups, r.group) != groups.end();
      });
  if (group == table.rows.back().group && !are_the_papers) return kNaN;
  const auto column = std::ranges::find(table.methods, method);
  const auto row = std::ranges::find(table.rows, group, &PrintedTable3::Row::group);
  if (column == table.methods.end() || row == table.rows.end()) return kNaN;
  return row->mae_cm[static_cast<std::size_t>(column - table.methods.begin())];
}

}  // namespace trilat
