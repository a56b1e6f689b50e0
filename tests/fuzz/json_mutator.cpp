// SPDX-License-Identifier: MIT
// Where an input is JSON, values of the document are changed, so that what comes is JSON still and gets past
// the parser. A byte before it, which chooses one of several files, stays.
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/philox.h"
#include "datasets/base/strict_json.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace trilat {
namespace {

constexpr std::uint32_t kBytesInstead = 5;  // one in so many changes is one of bytes

// Small whole numbers of one seed.
class Dice {
 public:
  explicit Dice(unsigned seed) : stream_{seed, Purpose::test, 0} {}
  std::size_t below(std::size_t count) {
    return std::min(count - 1,
                    static_cast<std::size_t>(stream_.uniform(next_++) * static_cast<double>(count)));
  }

 private:
  RandomStream stream_;
  std::uint32_t next_ = 0;
};

void collect(Json& node, std::vector<Json*>& nodes) {
  nodes.push_back(&node);
  if (node.is_structured())
    for (auto& child : node) collect(child, nodes);
}

const std::vector<Json>& odd_values() {
  static const std::vector<Json> values{nullptr,
                                        true,
                                        false,
                                        0,
                                        1,
                                        2,
                                        3,
                                        -1,
                                        7.5,
                                        1e-300,
                                        5e-324,
                                        1e300,
                                        -1e300,
                                        1e6,
                                        1e18,
                                        std::numeric_limits<std::uint64_t>::max(),
                                        std::numeric_limits<std::int64_t>::min(),
                                        std::numeric_limits<std::int64_t>::max(),
                                        "",
                                        "a",
                                        "../../up",
                                        "/absolute",
                                        "none",
                                        "mean",
                                        "\xff",
                                        std::string(300, 'x'),
                                        Json::array(),
                                        Json::object()};
  return values;
}

void remove_child(Json& node, Dice& dice) {
  auto child = node.begin();
  std::advance(child, static_cast<std::ptrdiff_t>(dice.below(node.size())));
  node.erase(child);
}

void change(Json& node, const std::vector<Json*>& nodes, Dice& dice) {
  switch (dice.below(5)) {
    case 0:
      if (node.is_structured() && !node.empty()) return remove_child(node, dice);
      break;
    case 1:
      if (node.is_array() && !node.empty()) return node.push_back(Json(node[dice.below(node.size())]));
      break;
    case 2:
      if (node.is_number()) {
        node = node.get<double>() * (dice.below(2) == 0 ? -1.0 : 1000.0);
        return;
      }
      break;
    case 3: {
      const Json other = *nodes[dice.below(nodes.size())];
      node = other;
      return;
    }
    default:
      break;
  }
  node = odd_values()[dice.below(odd_values().size())];
}

std::size_t mutate(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  Dice dice(seed);
  if (size < 2 || dice.below(kBytesInstead) == 0) return LLVMFuzzerMutate(data, size, most);
  const std::size_t begin = data[0] == '{' || data[0] == '[' ? 0 : 1;
  Json json = Json::parse(data + begin, data + size, nullptr, false);
  if (json.is_discarded()) return LLVMFuzzerMutate(data, size, most);
  for (std::size_t changes = 1 + dice.below(3); changes > 0; --changes) {
    std::vector<Json*> nodes;
    collect(json, nodes);
    change(*nodes[dice.below(nodes.size())], nodes, dice);
  }
  const std::string text = json_text(json, -1);
  if (text.size() + begin > most) return LLVMFuzzerMutate(data, size, most);
  std::copy(text.begin(), text.end(), data + begin);
  return text.size() + begin;
}

}  // namespace
}  // namespace trilat

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most,
                                               unsigned seed) {
  return trilat::mutate(data, size, most, seed);
}
