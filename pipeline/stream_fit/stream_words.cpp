// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/stream_words.h"

#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr const char* kBothSides = "left and right";

// A cause with its size, and how it is undone.
struct CauseText {
  std::string what, remedy;
};

CauseText size_text(const SizeChange& size, const StreamWords& words) {
  const std::string factor = factor_text(size);
  const char* const unit = unit_text(size);
  if (size.at_s) {
    const std::string when =
        size.until ? fmt::format("until {:.2f} s", *size.at_s) : fmt::format("from {:.2f} s on", *size.at_s);
    return {fmt::format("is {} times as large {}{}", factor, when, unit),
            fmt::format("divide its numbers {} by {}", when, factor)};
  }
  if (size.point)
    return {fmt::format("has {} {} times as far away as it is{}", words.names[*size.point], factor, unit),
            fmt::format("divide the numbers of {} by {}", words.names[*size.point], factor)};
  if (size.axis)
    return {fmt::format("has {} {} times as large as {}{}", "xyz"[*size.axis], factor, words.reference, unit),
            fmt::format("divide its {} by {}", "xyz"[*size.axis], factor)};
  return {fmt::format("is {} times as large as {}{}", factor, words.reference, unit),
          fmt::format("divide its numbers by {}", factor)};
}

CauseText start_text(const StreamChange& change, const StreamWords& words) {
  const char* const side = change.start_s > 0.0 ? "earlier" : "later";
  return {
      fmt::format("starts {:.2f} s {} than {}", std::abs(change.start_s), side, words.reference),
      words.clock_is_applied
          ? std::string("that start was applied")
          : fmt::format("{} {:.3f} s {} its times, or let the motion say it: --clock-by-motion, \"clock\": "
                        "\"motion\" beside the file",
                        change.start_s > 0.0 ? "add" : "take", std::abs(change.start_s),
                        change.start_s > 0.0 ? "to" : "from")};
}

CauseText rate_text(const StreamChange& change, const StreamWords& words) {
  constexpr double kDrift = 0.006, kPartsPerMillion = 1e6;
  const double stretch = change.stretch;
  const std::string remedy =
      fmt::format("multiply its times since its first frame by {:.4f}, or its stated rate by {:.4g}", stretch,
                  1.0 / stretch);
  if (std::abs(stretch - 1.0) < kDrift)
    return {fmt::format("has a clock that runs {:.0f} ppm {} than that of {}",
                        kPartsPerMillion * std::abs(1.0 / stretch - 1.0), stretch < 1.0 ? "faster" : "slower",
                        words.reference),
            remedy};
  return {fmt::format("runs {:.3g} times as fast as {}", stretch, words.reference), remedy};
}

// The points that a change exchanges, in pairs, or "left and right"; of points that change places in a larger
// circle "neck is head, head is spine_mid and 3 more".
struct NamesText {
  std::string text;
  bool is_exchange = true;
};

NamesText names_text(const StreamChange& change, const std::vector<std::string>& names) {
  constexpr std::size_t kMaxNames = 4;
  std::vector<std::string> pairs, renamed;
  const std::vector<std::size_t> mirrored = mirrored_points(names);
  bool is_all = true, any_side = false, is_exchange = true;
  for (std::size_t j = 0; j < change.order.size(); ++j) {
    const std::size_t other = change.order[j];
    if (other > j) pairs.push_back(names[j] + " and " + names[other]);
    if (other != j) renamed.push_back(names[other] + " is " + names[j]);
    is_all &= other == mirrored[j];
    any_side |= mirrored[j] != j;
    is_exchange &= change.order[other] == j;
  }
  if (is_all && any_side && pairs.size() > 1) return {kBothSides};
  if (is_exchange) return {fmt::format("{}", fmt::join(pairs, ", "))};
  const std::size_t more = renamed.size() - std::min(kMaxNames, renamed.size());
  renamed.resize(renamed.size() - more);
  return {fmt::format("{}{}", fmt::join(renamed, ", "), more > 0 ? fmt::format(" and {} more", more) : ""),
          false};
}

CauseText sides_text(const StreamChange& change, const StreamWords& words) {
  const NamesText names = names_text(change, words.names);
  return {order_text(change, words.names),
          fmt::format("{}, or say so under \"mapping\"", !names.is_exchange ? "name them so"
                                                         : names.text == kBothSides
                                                             ? "exchange the names of both sides"
                                                             : "exchange these names")};
}

std::string turn_text(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  const double degrees = kDegreesPerRad * turn.angle();
  for (const int axis : {0, 1, 2})
    if (constexpr double kAlong = 0.98; std::abs(turn.axis()[axis]) > kAlong)
      return fmt::format("turned by {:.0f} degrees about {}", turn.axis()[axis] > 0.0 ? degrees : -degrees,
                         "xyz"[axis]);
  return fmt::format("turned by {:.0f} degrees", degrees);
}

CauseText frame_text(const StreamChange& change, const StreamWords& words) {
  const bool has_axes = change.frame == FrameChange::axes || change.frame == FrameChange::axes_shifted;
  std::vector<std::string> shift_m;
  for (const double axis_m : change.shift_m)
    shift_m.push_back(fmt::format("{:.2f}", std::abs(axis_m) < 0.005 ? 0.0 : axis_m));
  const std::string shift =
      change.frame == FrameChange::axes || change.frame == FrameChange::none || change.root
          ? ""
          : fmt::format("shifted by ({}) m", fmt::join(shift_m, ", "));
  const char* const rigid = "compare it under the alignment \"rigid\"";
  if (has_axes) {
    const std::string axes = axes_text(change.rotation);
    return {fmt::format("has other axes than {}, read as {}{}{}{}", words.reference, axes,
                        change.mirrored ? ", which mirrors it" : "", shift.empty() ? "" : " and ", shift),
            "write its x, y, z as " + axes};
  }
  if (change.mirrored)
    return {fmt::format("is mirrored, in a frame {} and {}",
                        turn_text(change.rotation * Eigen::DiagonalMatrix<double, 3>(-1.0, 1.0, 1.0)), shift),
            "write its x as -x, and then " + std::string(rigid)};
  if (change.frame == FrameChange::turned)
    return {fmt::format("lies in another frame than {}, {}{}{}", words.reference, turn_text(change.rotation),
                        shift.empty() ? "" : " and ", shift),
            rigid};
  return {fmt::format("lies in another frame than {}, {}", words.reference, shift), rigid};
}

CauseText root_text(const StreamChange& change, const StreamWords& words) {
  const BodyRoot& root = *change.root;
  const std::string name =
      root.one == root.other
          ? words.names[root.one]
          : fmt::format("the middle of {} and {}", words.names[root.one], words.names[root.other]);
  return {
      fmt::format("gives positions relative to {}{}{}", name, root.keeps_height ? ", but for heights" : "",
                  root.turns ? ", in axes that turn with the body" : ""),
      root.turns ? "give positions in the room: turn them back, and add where that was"
                 : "give positions in the room: add where that was"};
}

std::vector<CauseText> texts_of(const StreamChange& change, const StreamWords& words) {
  std::vector<CauseText> texts;
  const unsigned causes = causes_of(change);
  for (const SizeChange& size : change.sizes) texts.push_back(size_text(size, words));
  if (change.has_stretch) texts.push_back(rate_text(change, words));
  if (change.has_start && std::abs(change.start_s) > 0.01) texts.push_back(start_text(change, words));
  if ((causes & kSidesCause) != 0) texts.push_back(sides_text(change, words));
  if (change.root) texts.push_back(root_text(change, words));
  const bool is_of_body = change.root && change.root->turns && !change.mirrored;
  if (change.frame != FrameChange::none && !is_of_body) texts.push_back(frame_text(change, words));
  return texts;
}

std::string joined(const std::vector<CauseText>& texts, std::string CauseText::*part, const char* between) {
  std::vector<std::string> parts;
  for (const CauseText& text : texts) parts.push_back(text.*part);
  return fmt::format("{}", fmt::join(parts, between));
}

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string effect_text(const StreamFit& fit, const StreamWords& words) {
  if (std::isnan(fit.before_m))
    return fmt::format("as it is they have no time in common; put right, its mean distance is {:.1f} cm",
                       kCentimetresPerMetre * fit.after_m);
  return fmt::format("put right, its mean distance from {} falls from {:.1f} to {:.1f} cm", words.reference,
                     kCentimetresPerMetre * fit.before_m, kCentimetresPerMetre * fit.after_m);
}

}  // namespace

std::string factor_text(const SizeChange& size) {
  return size.is_unit ? fmt::format("{:.6g}", size.factor) : fmt::format("{:.3g}", size.factor);
}

const char* unit_text(const SizeChange& size) {
  if (!size.is_unit) return "";
  struct Unit {
    double factor;
    const char* text;
  };
  constexpr std::array kUnitNames{Unit{1000.0, ", as millimetres taken for metres"},
                                  Unit{100.0, ", as centimetres taken for metres"},
                                  Unit{10.0, ", as millimetres taken for centimetres"},
                                  Unit{0.1, ", as centimetres taken for millimetres"},
                                  Unit{0.01, ", as metres taken for centimetres"},
                                  Unit{0.001, ", as metres taken for millimetres"},
                                  Unit{39.3701, ", as inches taken for metres"},
                                  Unit{3.28084, ", as feet taken for metres"},
                                  Unit{0.0254, ", as metres taken for inches"},
                                  Unit{0.3048, ", as metres taken for feet"}};
  for (const Unit& unit : kUnitNames)
    if (std::abs(size.factor / unit.factor - 1.0) < 1e-3) return unit.text;
  return "";
}

std::string axes_text(const Eigen::Matrix3d& axes) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      if (axes(row, column) != 0.0)
        text += fmt::format("{}{}{}", text.empty() ? "(" : ", ", axes(row, column) < 0.0 ? "-" : "",
                            "xyz"[column]);
  return text + ")";
}

std::string order_text(const StreamChange& change, const std::vector<std::string>& names) {
  const NamesText found = names_text(change, names);
  return found.is_exchange ? fmt::format("has {} exchanged", found.text)
                           : fmt::format("has points under the names of others: {}", found.text);
}

std::string stream_note(const StreamFit& fit, const StreamWords& words) {
  switch (fit.status) {
    case StreamFitStatus::too_few:
    case StreamFitStatus::sound:
      return {};
    case StreamFitStatus::flat:
      return fmt::format(
          "has the same {} in every row: a result of two dimensions. Compare the other two axes alone, "
          "with the same number in this one of {}",
          "xyz"[fit.flat_axis], words.reference);
    case StreamFitStatus::found: {
      const std::vector<CauseText> texts = texts_of(fit.changes.front(), words);
      return fmt::format("{}: {}. {}", joined(texts, &CauseText::what, ", and "), effect_text(fit, words),
                         capitalised(joined(texts, &CauseText::remedy, "; ")));
    }
    case StreamFitStatus::one_of: {
      std::vector<std::string> ways;
      constexpr std::size_t kMaxWays = 4;
      for (std::size_t k = 0; k < std::min(kMaxWays, fit.changes.size()); ++k)
        ways.push_back(joined(texts_of(fit.changes[k], words), &CauseText::what, ", and "));
      return fmt::format("{}{}: {}. The motion does not say which of these it is", fmt::join(ways, "; or "),
                         fit.changes.size() > kMaxWays ? "; or others" : "", effect_text(fit, words));
    }
    case StreamFitStatus::unexplained:
      return fmt::format(
          "lies {:.0f} cm from {} in the mean, and none of these explains it: another unit, scale, start, "
          "rate, "
          "exchanged names, another frame; is it the same take, and the same person?",
          kCentimetresPerMetre * fit.before_m, words.reference);
  }
  return {};
}

std::string jump_note(const ClockJump& jump, double before_m, const StreamWords& words) {
  const auto with_sign = [](double add_s) {
    return fmt::format("{} {:.3f} s {} the times", add_s < 0.0 ? "take" : "add", std::abs(add_s),
                       add_s < 0.0 ? "from" : "to");
  };
  constexpr double kNoStart_s = 0.02;
  std::vector<std::string> remedies;
  if (std::abs(jump.start_s) > kNoStart_s) remedies.push_back(with_sign(jump.start_s) + " before it");
  if (std::abs(jump.start_s + jump.by_s) > kNoStart_s)
    remedies.push_back(with_sign(jump.start_s + jump.by_s) + " from there on");
  return fmt::format(
      "has a clock that jumps at {:.2f} s, where {}: put right, its mean distance from {} falls "
      "from {:.1f} to {:.1f} cm. {}",
      jump.at_s,
      jump.by_s > 0.0 ? fmt::format("{:.2f} s of the motion are missing though its times go on", jump.by_s)
                      : fmt::format("its times skip {:.2f} s that the motion does not have", -jump.by_s),
      words.reference, kCentimetresPerMetre * before_m, kCentimetresPerMetre * jump.after_m,
      capitalised(fmt::format("{}", fmt::join(remedies, ", and "))));
}

std::string part_note(const PartChange& part, double before_m, const StreamWords& words) {
  return fmt::format(
      "{} {:.2f} s{} {}: put right there, its mean distance from {} falls from {:.1f} to {:.1f} cm. Put that "
      "part "
      "right, or give both parts as files of their own; was a camera moved, or did a tracker begin anew?",
      part.is_later ? "from" : "until", part.at_s, part.is_later ? " on" : "",
      joined(texts_of(part.change, words), &CauseText::what, ", and "), words.reference,
      kCentimetresPerMetre * before_m, kCentimetresPerMetre * part.after_m);
}

std::string own_places_note(double after_m, double before_m, const StreamWords& words) {
  return fmt::format(
      "differs from {} by a constant of each point, as displacements from a mean or a first place do: "
      "without "
      "them its mean distance falls from {:.1f} to {:.1f} cm. Compare it under the alignment \"mean\"",
      words.reference, kCentimetresPerMetre * before_m, kCentimetresPerMetre * after_m);
}

std::string drift_note(const FrameDrift& drift, double before_m, const StreamWords& words) {
  return fmt::format(
      "moves against {}, by {:.0f} cm and {:.0f} degrees from its beginning to its end, as the positions of "
      "inertial suits drift: each {:.1f} s put right by a frame of their own, its mean distance falls from "
      "{:.1f} to {:.1f} cm. Compare shorter takes, under the alignment \"rigid\"",
      words.reference, kCentimetresPerMetre * drift.shift_m, kDegreesPerRad * drift.turn_rad, drift.piece_s,
      kCentimetresPerMetre * before_m, kCentimetresPerMetre * drift.after_m);
}

}  // namespace trilat
