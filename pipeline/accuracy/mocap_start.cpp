// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/mocap_start.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/calibration/calibration.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

bool is_in_mocap_world(const Take& take) { return read_calibration(take.calibration).world == "optitrack"; }

MocapStart find_mocap_start(const Take& take, double search_s, const Watch& watch) {
  Json joints = Json::array();
  for (const JointMapping::Entry& entry : read_mapping(take.mapping).joints)
    joints.push_back(std::string(name_of(entry.joint)));
  StudySpec study = parse_study({{"format", "trilat.study"},
                                 {"version", 1},
                                 {"kind", "accuracy"},
                                 {"name", "start"},
                                 {"joints", joints},
                                 {"alignments", {is_in_mocap_world(take) ? "none" : "rigid"}},
                                 {"clock", "motion"},
                                 {"methods", {{{"method", "mean"}}}}},
                                "start", {});
  study.clock_search_s = search_s;
  const Plan plan = make_plan(study, {.name = "start", .takes = {take}}, watch);
  PlannedTake planned = plan.takes.front();
  if (!planned.ok) throw InputError(planned.place, planned.problem);
  planned.take.mocap_start_host_ns = planned.start.ns;
  const ClockRow clock = load_take(plan, planned, watch.stop_requested).clock;
  if (!clock.applied) return {clock.status};
  return {clock.status, planned.start.ns - duration_from_s(clock.offset_s).ns, -clock.offset_s, -clock.high_s,
          -clock.low_s};
}

}  // namespace trilat
