// SPDX-License-Identifier: MIT
#include "pipeline/part_plan.h"

#include <algorithm>
#include <span>

#include "datasets/results/declared_parameters.h"

namespace trilat {
namespace {

Json parameters_json(const Campaign& campaign) {
  Json parameters = Json::array();
  for (const DeclaredParameter& p : read_declared_parameters(campaign.folder))
    parameters.push_back({p.name, p.value, p.unit, p.source});
  return parameters;
}

PlannedTake read_planned_take(JsonObject& entry) {
  PlannedTake planned;
  planned.take.id = entry.text("id");
  planned.take.participant = entry.text("participant");
  planned.take.activity = entry.text("activity");
  planned.take.mocap_start_host_ns = entry.integer("mocap_start_host_ns");
  planned.ok = entry.boolean("ok", false);
  planned.instants = entry.count("instants");
  entry.boolean("tracker_truth", false);
  entry.finish();
  return planned;
}

void check_takes(const Plan& plan, std::span<const PartItem> items, const JsonObject& work) {
  const auto same = [](const PlannedTake& take, const PartItem& item) { return take.take.id == item.id; };
  if (!std::equal(plan.takes.begin(), plan.takes.end(), items.begin(), items.end(), same))
    work.refuse("takes", "must be the items, in their order");
}

}  // namespace

Json part_work(const Plan& plan, bool cross_check, Json inputs) {
  Json takes = Json::array(), joints = Json::array();
  for (const PlannedTake& t : plan.takes)
    takes.push_back({{"id", t.take.id},
                     {"participant", t.take.participant},
                     {"activity", t.take.activity},
                     {"mocap_start_host_ns", t.take.mocap_start_host_ns},
                     {"tracker_truth", !t.take.tracker_truth.empty()},
                     {"ok", t.ok},
                     {"instants", t.instants}});
  for (const Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  return {{"study", resolved_json(plan.study)},
          {"cross_check", cross_check},
          {"campaign", plan.campaign.name},
          {"campaign_simulated", plan.campaign.simulated},
          {"simulated", plan.simulated},
          {"rig", plan.rig},
          {"joints", joints},
          {"takes", takes},
          {"inputs", std::move(inputs)},
          {"parameters", parameters_json(plan.campaign)}};
}

PartPlan read_part_plan(const WorkPart& part, const std::string& place) {
  JsonObject work(part.work, place, "/work");
  PartPlan read;
  Plan& plan = read.plan;
  plan.study = parse_study(work.value("study"), place, {});
  plan.campaign.name = work.text("campaign");
  plan.campaign.simulated = work.boolean("campaign_simulated", false);
  plan.simulated = work.boolean("simulated", false);
  plan.rig = work.texts("rig");
  plan.methods = resolve_methods(plan.study, plan.rig);
  plan.reference = reference_of(plan.study, plan.methods);
  for (const std::string& name : work.texts("joints")) {
    const auto joint = joint_from_name(name);
    if (!joint) work.refuse("joints", "has \"" + name + "\", which is no joint");
    plan.joints.push_back(*joint);
  }
  for (JsonObject& entry : work.objects("takes")) {
    plan.takes.push_back(read_planned_take(entry));
    plan.campaign.takes.push_back(plan.takes.back().take);
  }
  check_takes(plan, part.items, work);
  if (!work.has("cross_check")) work.refuse("cross_check", "is missing");
  read.cross_check = work.boolean("cross_check", false);
  work.value("inputs");
  work.value("parameters");
  work.finish();
  return read;
}

}  // namespace trilat
