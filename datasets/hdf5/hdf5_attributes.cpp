// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstring>

#include <hdf5.h>

#include "datasets/base/error.h"
#include "datasets/hdf5/hdf5_file.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxTextBytes = 1u << 16;
constexpr std::size_t kMaxTexts = 4096;
constexpr std::size_t kMaxTextsBytes = 1u << 20;  // of all together

struct Ids {
  hid_t attribute = -1, type = -1, space = -1;
  ~Ids() {
    if (space >= 0) H5Sclose(space);
    if (type >= 0) H5Tclose(type);
    if (attribute >= 0) H5Aclose(attribute);
  }
};

void write_attribute(std::int64_t node, const std::string& place, const std::string& name, hid_t file_type,
                     hid_t memory_type, const void* value, std::size_t count = 0) {
  Ids ids;
  const hsize_t extent = count;
  ids.space = count ? H5Screate_simple(1, &extent, nullptr) : H5Screate(H5S_SCALAR);
  if (H5Aexists(node, name.c_str()) > 0)
    ids.attribute = H5Aopen(node, name.c_str(), H5P_DEFAULT);
  else
    ids.attribute = H5Acreate2(node, name.c_str(), file_type, ids.space, H5P_DEFAULT, H5P_DEFAULT);
  if (ids.attribute < 0 || H5Awrite(ids.attribute, memory_type, value) < 0)
    throw OutputError(place + "@" + name, "cannot be written");
}

Ids open_attribute(std::int64_t node, const std::string& place, const std::string& name, H5T_class_t wanted,
                   const char* what) {
  Ids ids;
  if (H5Aexists(node, name.c_str()) <= 0) throw InputError(place, "is missing");
  ids.attribute = H5Aopen(node, name.c_str(), H5P_DEFAULT);
  ids.type = H5Aget_type(ids.attribute);
  ids.space = H5Aget_space(ids.attribute);
  if (ids.type < 0 || ids.space < 0 || H5Tget_class(ids.type) != wanted)
    throw InputError(place, std::string("must be ") + what);
  return ids;
}

// Texts of variable length, as h5py writes them.
std::vector<std::string> read_variable_texts(const Ids& ids, std::size_t count, const std::string& place) {
  std::vector<char*> pointers(count, nullptr);
  if (H5Aread(ids.attribute, ids.type, pointers.data()) < 0) throw InputError(place, "cannot be read");
  std::vector<std::string> texts;
  std::size_t bytes = 0;
  for (const char* text : pointers) {
    texts.emplace_back(text ? std::string_view(text, strnlen(text, kMaxTextBytes + 1)) : std::string_view());
    bytes += texts.back().size();
  }
  H5Dvlen_reclaim(ids.type, ids.space, H5P_DEFAULT, pointers.data());
  if (bytes > kMaxTextsBytes ||
      std::ranges::any_of(texts, [](const auto& t) { return t.size() > kMaxTextBytes; }))
    throw InputError(place, "is longer than a text of this format");
  return texts;
}

std::vector<std::string> read_texts(const Ids& ids, const std::string& place) {
  const std::size_t size = H5Tget_size(ids.type);
  const hssize_t count = H5Sget_simple_extent_npoints(ids.space);
  if (H5Tis_variable_str(ids.type) > 0 && count >= 0 && static_cast<std::size_t>(count) <= kMaxTexts)
    return read_variable_texts(ids, static_cast<std::size_t>(count), place);
  if (size == 0 || size > kMaxTextBytes || count < 0 || static_cast<std::size_t>(count) > kMaxTexts ||
      size * static_cast<std::size_t>(count) > kMaxTextsBytes)
    throw InputError(place, "is a text of a kind or size this format does not have");
  std::vector<char> buffer(size * static_cast<std::size_t>(count) + 1, '\0');
  if (H5Aread(ids.attribute, ids.type, buffer.data()) < 0) throw InputError(place, "cannot be read");
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const char* start = buffer.data() + i * size;
    texts.emplace_back(start, strnlen(start, size));
  }
  return texts;
}

template <class T>
T read_scalar(const Ids& ids, const std::string& place, hid_t memory_type) {
  T value{};
  if (H5Sget_simple_extent_npoints(ids.space) != 1 || H5Aread(ids.attribute, memory_type, &value) < 0)
    throw InputError(place, "must be one value");
  return value;
}

}  // namespace

void H5Node::set_text(const std::string& name, const std::string& text) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, std::max<std::size_t>(1, text.size()));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const H5Handle owner(type, [](std::int64_t id) -> int { return H5Tclose(id); });
  std::string padded = text;
  padded.push_back('\0');
  write_attribute(id_.id(), place_, name, type, type, padded.data());
}

void H5Node::set_texts(const std::string& name, const std::vector<std::string>& texts) {
  std::size_t size = 1;
  for (const std::string& text : texts) size = std::max(size, text.size());
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, size);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const H5Handle owner(type, [](std::int64_t id) -> int { return H5Tclose(id); });
  std::vector<char> buffer(size * texts.size(), '\0');
  for (std::size_t i = 0; i < texts.size(); ++i) texts[i].copy(buffer.data() + i * size, size);
  write_attribute(id_.id(), place_, name, type, type, buffer.data(), texts.size());
}

void H5Node::set_integer(const std::string& name, std::int64_t value) {
  write_attribute(id_.id(), place_, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void H5Node::set_number(const std::string& name, double value) {
  write_attribute(id_.id(), place_, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

bool H5Node::has_attribute(const std::string& name) const {
  const htri_t exists = H5Aexists(id_.id(), name.c_str());
  if (exists < 0) throw InputError(place_ + "@" + name, "cannot be looked up");
  return exists > 0;
}

std::string H5Node::text(const std::string& name) const {
  const std::string place = place_ + "@" + name;
  const auto texts = read_texts(open_attribute(id_.id(), place, name, H5T_STRING, "a text"), place);
  if (texts.size() != 1) throw InputError(place, "must be one text");
  return texts[0];
}

std::vector<std::string> H5Node::texts(const std::string& name) const {
  const std::string place = place_ + "@" + name;
  return read_texts(open_attribute(id_.id(), place, name, H5T_STRING, "a list of texts"), place);
}

std::int64_t H5Node::integer(const std::string& name) const {
  const std::string place = place_ + "@" + name;
  return read_scalar<std::int64_t>(open_attribute(id_.id(), place, name, H5T_INTEGER, "an integer"), place,
                                   H5T_NATIVE_INT64);
}

double H5Node::number(const std::string& name) const {
  const std::string place = place_ + "@" + name;
  const double value = read_scalar<double>(open_attribute(id_.id(), place, name, H5T_FLOAT, "a number"),
                                           place, H5T_NATIVE_DOUBLE);
  if (!std::isfinite(value)) throw InputError(place, "must be a finite number");
  return value;
}

}  // namespace trilat
