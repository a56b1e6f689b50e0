// SPDX-License-Identifier: MIT
#include "datasets/hdf5/hdf5_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include <blosc.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/hdf5/chunk_codec.h"

namespace trilat {
namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

int close_file(std::int64_t id) { return H5Fclose(id); }
int close_group(std::int64_t id) { return H5Gclose(id); }
int close_dataset(std::int64_t id) { return H5Dclose(id); }
int close_space(std::int64_t id) { return H5Sclose(id); }
int close_list(std::int64_t id) { return H5Pclose(id); }
int close_type(std::int64_t id) { return H5Tclose(id); }

// The library's innermost complaint: the one that names the cause.
std::string library_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
        auto& text = *static_cast<std::string*>(out);
        if (text.empty() && error->desc) text = error->desc;
        return 0;
      },
      &reason);
  // the library appends times, addresses and buffers
  reason = reason.substr(0, std::min(reason.find('\n'), reason.find(": time =")));
  return reason.empty() ? "the HDF5 library gives no reason" : reason;
}

// The root's place is "file.h5:", which a message follows with a colon of its own.
std::string without_colon(const std::string& place) {
  return place.ends_with(':') ? place.substr(0, place.size() - 1) : place;
}

[[noreturn]] void refuse(const std::string& place, const std::string& doing) {
  throw InputError(without_colon(place), doing + " (" + library_reason() + ")");
}

// Throws InputError for a file that the library cannot open, with what the file is by its first bytes.
[[noreturn]] void refuse_unreadable(const std::filesystem::path& path) {
  std::array<char, 32> bytes{};
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string(), std::string("cannot be opened: ") + std::strerror(errno));
  file.read(bytes.data(), bytes.size());
  const std::string_view head(bytes.data(), static_cast<std::size_t>(file.gcount()));
  if (head.empty()) throw InputError(path.string(), "is empty");
  if (head.starts_with("\x89HDF"))
    throw InputError(
        path.string(),
        "is cut short or damaged: it begins as HDF5 does, and is not a readable HDF5 file; copy it "
        "again whole");
  if (const std::string_view kind = foreign_kind(head); !kind.empty())
    throw InputError(path.string(), std::string(kind));
  throw InputError(path.string(), "is not an HDF5 file, as sessions and the takes of results are");
}

[[noreturn]] void refuse_output(const std::string& place, const std::string& doing) {
  throw OutputError(without_colon(place), doing + " (" + library_reason() + "); is the disk full?");
}

H5Handle wrap(hid_t id, H5Handle::Closer closer, const std::string& place, const std::string& doing) {
  if (id < 0) refuse(place, doing);
  return {id, closer};
}

static_assert(std::endian::native == std::endian::little, "numbers in memory are as in the file");
hid_t type_of(H5Type type) {
  switch (type) {
    case H5Type::u8:
      return H5T_STD_U8LE;
    case H5Type::u16:
      return H5T_STD_U16LE;
    case H5Type::u32:
      return H5T_STD_U32LE;
    case H5Type::u64:
      return H5T_STD_U64LE;
    case H5Type::i64:
      return H5T_STD_I64LE;
    case H5Type::f32:
      return H5T_IEEE_F32LE;
    case H5Type::f64:
      return H5T_IEEE_F64LE;
  }
  return -1;
}

// How the library reads rows that Blosc compressed. It writes none: those go to the file compressed already.
std::size_t read_blosc(unsigned flags, std::size_t count, const unsigned* values, std::size_t bytes,
                       std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0 || count <= kBloscChunkBytes) return 0;
  const std::size_t raw_bytes = values[kBloscChunkBytes];
  auto* const raw = static_cast<std::byte*>(H5allocate_memory(raw_bytes, false));
  if (!raw || !decompress_bytes({static_cast<const std::byte*>(*buffer), bytes}, ChunkCompression::blosc,
                                {raw, raw_bytes})) {
    H5free_memory(raw);
    return 0;
  }
  H5free_memory(std::exchange(*buffer, raw));
  return *buffer_bytes = raw_bytes;
}
constexpr H5Z_class2_t kBlosc{H5Z_CLASS_T_VERS, kBloscFilter, 1, 1, "blosc", nullptr, nullptr, read_blosc};

// For chunks of `chunk_bytes`, of elements of `element_bytes`.
bool set_compression(hid_t list, ChunkCompression compression, std::size_t element_bytes,
                     std::size_t chunk_bytes) {
  if (compression == ChunkCompression::none) return true;
  if (compression == ChunkCompression::deflate) return H5Pset_deflate(list, kChunkLevel) >= 0;
  constexpr unsigned kFilterRevision = 2;
  const std::array<unsigned, kBloscValues> values{kFilterRevision,
                                                  BLOSC_VERSION_FORMAT,
                                                  static_cast<unsigned>(element_bytes),
                                                  static_cast<unsigned>(chunk_bytes),
                                                  kChunkLevel,
                                                  BLOSC_BITSHUFFLE,
                                                  BLOSC_ZSTD};
  return H5Pset_filter(list, kBloscFilter, H5Z_FLAG_MANDATORY, values.size(), values.data()) >= 0;
}

void prepare_library() {
  static const bool ready = [] {
    // before any other call, which would start the library with its work at exit. Every file is closed by its
    // owner; at exit the library would stumble over a full disk
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    hbool_t safe = false;
    TRILAT_CHECK(H5open() >= 0 && H5is_library_threadsafe(&safe) >= 0 && safe,
                 "the HDF5 library is a thread-safe build");
    TRILAT_CHECK(H5Zregister(&kBlosc) >= 0, "HDF5 takes the Blosc filter");
    H5PLset_loading_state(0);  // a file must not make this program load code
    return true;
  }();
  (void)ready;
  // the setting is per thread
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

H5Handle access_list(const std::string& place) {
  H5Handle list = wrap(H5Pcreate(H5P_FILE_ACCESS), close_list, place, "cannot be prepared");
  H5Pset_libver_bounds(list.id(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  return list;
}

// How often the library may read metadata again that a writer seems to be writing: it waits twice as long
// each time, beginning with a nanosecond, so that this is 17 ms in all. Its own 100 attempts would never end
// on a damaged file.
constexpr unsigned kMetadataReadAttempts = 24;

H5Handle follower_access_list(const std::string& place) {
  H5Handle list = wrap(H5Pcreate(H5P_FILE_ACCESS), close_list, place, "cannot be prepared");
  H5Pset_metadata_read_attempts(list.id(), kMetadataReadAttempts);
  return list;
}

}  // namespace

H5Handle& H5Handle::operator=(H5Handle&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(closer_, other.closer_);
  std::swap(failed_, other.failed_);
  return *this;
}

H5Handle::~H5Handle() {
  if (close() < 0 && failed_) *failed_ = true;
}

int H5Handle::close() {
  const Closer closer = std::exchange(closer_, nullptr);
  return closer && id_ >= 0 ? closer(std::exchange(id_, -1)) : 0;
}

std::uint64_t H5Table::rows() const {
  const H5Handle space = wrap(H5Dget_space(id_.id()), close_space, place_, "has no shape");
  hsize_t dims[H5S_MAX_RANK] = {};
  if (H5Sget_simple_extent_dims(space.id(), dims, nullptr) < 1) refuse(place_, "has no rows");
  return dims[0];
}

std::uint64_t H5Table::stored_bytes() const { return H5Dget_storage_size(id_.id()); }

void H5Table::extend_to(std::uint64_t rows) {
  std::vector<hsize_t> dims{rows};
  dims.insert(dims.end(), row_shape_.begin(), row_shape_.end());
  if (H5Dset_extent(id_.id(), dims.data()) < 0) refuse_output(place_, "cannot grow");
}

void H5Table::append_raw(const void* data, std::size_t elements, H5Type type) {
  if (elements == 0) return;
  TRILAT_CHECK(elements % row_elements_ == 0, "whole rows are appended");
  const std::uint64_t first = rows();
  extend_to(first + elements / row_elements_);
  transfer(first, const_cast<void*>(data), elements, type, true);
}

bool H5Table::move_rows(std::uint64_t first_row, void* data, std::size_t elements, H5Type type, bool write,
                        std::int64_t transfer) const {
  std::vector<hsize_t> start(1 + row_shape_.size(), 0);
  std::vector<hsize_t> count{elements / row_elements_};
  count.insert(count.end(), row_shape_.begin(), row_shape_.end());
  start[0] = first_row;
  const H5Handle file_space = wrap(H5Dget_space(id_.id()), close_space, place_, "has no shape");
  const H5Handle memory_space = wrap(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                                     close_space, place_, "cannot be addressed");
  H5Sselect_hyperslab(file_space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  const hid_t memory = type_of(type), from = memory_space.id(), to = file_space.id();
  return (write ? H5Dwrite(id_.id(), memory, from, to, transfer, data)
                : H5Dread(id_.id(), memory, from, to, transfer, data)) >= 0;
}

void H5Table::transfer(std::uint64_t first_row, void* data, std::size_t elements, H5Type type,
                       bool write) const {
  if (elements == 0) return;
  TRILAT_CHECK(elements % row_elements_ == 0, "whole rows are transferred");
  prepare_library();
  const std::uint64_t end_row = first_row + elements / row_elements_;
  if (end_row > rows()) throw InputError(place_, "ends before row " + std::to_string(end_row));
  if (write) {
    if (!move_rows(first_row, data, elements, type, true, H5P_DEFAULT))
      refuse_output(place_, "cannot be written");
    return;
  }
  // Rows of a torn last chunk are read by themselves, without its checksum.
  const std::uint64_t torn_from = last_checksum_ignored_ && stored_.chunk_rows > 0
                                      ? (rows() - 1) / stored_.chunk_rows * stored_.chunk_rows
                                      : rows();
  const std::uint64_t sound_end = std::clamp(torn_from, first_row, end_row);
  const std::size_t sound = (sound_end - first_row) * row_elements_;
  const H5Handle unchecked = wrap(H5Pcreate(H5P_DATASET_XFER), close_list, place_, "cannot be prepared");
  H5Pset_edc_check(unchecked.id(), H5Z_DISABLE_EDC);
  auto* const rest = static_cast<std::byte*>(data) + sound * H5Tget_size(type_of(type));
  if ((sound > 0 && !move_rows(first_row, data, sound, type, false, H5P_DEFAULT)) ||
      (elements > sound && !move_rows(sound_end, rest, elements - sound, type, false, unchecked.id())))
    refuse(place_,
           fmt::format("cannot be read: the stored data are damaged (rows {} and following)", first_row));
}

std::string H5Node::place_of(const std::string& name) const {
  return place_ + (place_.ends_with('/') ? "" : "/") + name;
}

H5Node H5Node::create_group(const std::string& name) {
  H5Node node;
  node.place_ = place_of(name);
  node.rows_lost_ = rows_lost_;
  const H5Handle list = wrap(H5Pcreate(H5P_GROUP_CREATE), close_list, node.place_, "cannot be prepared");
  H5Pset_obj_track_times(list.id(), false);
  node.id_ = wrap(H5Gcreate2(id_.id(), name.c_str(), H5P_DEFAULT, list.id(), H5P_DEFAULT), close_group,
                  node.place_, "cannot be created");
  return node;
}

H5Node H5Node::group(const std::string& name) const {
  H5Node node;
  node.place_ = place_of(name);
  if (!has(name)) throw InputError(node.place_, "is missing");
  node.id_ = wrap(H5Gopen2(id_.id(), name.c_str(), H5P_DEFAULT), close_group, node.place_, "is not a group");
  return node;
}

bool H5Node::has(const std::string& name) const {
  prepare_library();
  H5L_info_t info{};
  const htri_t exists = H5Lexists(id_.id(), name.c_str(), H5P_DEFAULT);
  // what cannot be read is not said to be absent: much of a file may be
  if (exists < 0 || (exists > 0 && H5Lget_info(id_.id(), name.c_str(), &info, H5P_DEFAULT) < 0))
    refuse(place_of(name), "cannot be looked up");
  // Only what lies in this file: soft and external links could lead anywhere.
  return exists > 0 && info.type == H5L_TYPE_HARD;
}

std::vector<std::string> H5Node::children(std::size_t limit) const {
  H5G_info_t info{};
  if (H5Gget_info(id_.id(), &info) < 0) refuse(place_, "cannot be listed");
  if (info.nlinks > limit)
    throw InputError(place_, "holds " + std::to_string(info.nlinks) + " entries, more than the " +
                                 std::to_string(limit) + " allowed");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    char name[256] = {};
    if (H5Lget_name_by_idx(id_.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof name, H5P_DEFAULT) < 0)
      refuse(place_, "cannot be listed");
    names.emplace_back(name);
  }
  std::ranges::sort(names);
  return names;
}

H5Table H5Node::create_table(const std::string& name, H5Type type,
                             const std::vector<std::uint64_t>& row_shape, const H5Layout& layout,
                             std::uint64_t rows) {
  H5Table table;
  table.place_ = place_of(name);
  table.row_shape_ = row_shape;
  for (std::uint64_t extent : row_shape) table.row_elements_ *= extent;
  std::vector<hsize_t> dims{rows}, limits{layout.chunk_rows ? H5S_UNLIMITED : rows};
  dims.insert(dims.end(), row_shape.begin(), row_shape.end());
  limits.insert(limits.end(), row_shape.begin(), row_shape.end());
  const H5Handle space = wrap(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), limits.data()),
                              close_space, table.place_, "cannot be shaped");
  const H5Handle list = wrap(H5Pcreate(H5P_DATASET_CREATE), close_list, table.place_, "cannot be prepared");
  H5Pset_obj_track_times(list.id(), false);
  if (layout.chunk_rows > 0) {
    std::vector<hsize_t> chunk{layout.chunk_rows};
    chunk.insert(chunk.end(), row_shape.begin(), row_shape.end());
    H5Pset_chunk(list.id(), static_cast<int>(chunk.size()), chunk.data());
    const std::size_t element_bytes = H5Tget_size(type_of(type));
    if (layout.shuffle) H5Pset_shuffle(list.id());
    if (!set_compression(list.id(), layout.compression, element_bytes,
                         layout.chunk_rows * table.row_elements_ * element_bytes))
      refuse(table.place_, "cannot use the compression filter");
    if (layout.checksum) H5Pset_fletcher32(list.id());
  } else {
    H5Pset_alloc_time(list.id(), H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(list.id(), H5D_FILL_TIME_NEVER);
  }
  table.id_ =
      wrap(H5Dcreate2(id_.id(), name.c_str(), type_of(type), space.id(), H5P_DEFAULT, list.id(), H5P_DEFAULT),
           close_dataset, table.place_, "cannot be created");
  table.id_.tell_failure_to(rows_lost_);
  return table;
}

namespace {

// "float32 (N, 25, 3)"
std::string text_of(hid_t type, const std::vector<std::uint64_t>& row_shape) {
  const H5T_class_t kind = H5Tget_class(type);
  std::string text = kind == H5T_FLOAT                   ? "float"
                     : kind != H5T_INTEGER               ? "another type"
                     : H5Tget_sign(type) == H5T_SGN_NONE ? "uint"
                                                         : "int";
  if (kind == H5T_FLOAT || kind == H5T_INTEGER) text += std::to_string(8 * H5Tget_size(type));
  text += " (N";
  for (const std::uint64_t extent : row_shape) text += ", " + std::to_string(extent);
  return text + ")";
}

}  // namespace

H5Table H5Node::table(const std::string& name, H5Type type,
                      const std::vector<std::uint64_t>& row_shape) const {
  H5Table table;
  table.place_ = place_of(name);
  if (!has(name)) throw InputError(table.place_, "is missing");
  table.id_ =
      wrap(H5Dopen2(id_.id(), name.c_str(), H5P_DEFAULT), close_dataset, table.place_, "is not a dataset");
  const H5Handle space = wrap(H5Dget_space(table.id_.id()), close_space, table.place_, "has no shape");
  const int rank = H5Sget_simple_extent_ndims(space.id());
  hsize_t dims[H5S_MAX_RANK] = {};
  if (rank < 1 || H5Sget_simple_extent_dims(space.id(), dims, nullptr) != rank)
    refuse(table.place_, "has no rows");
  const bool same_shape = static_cast<std::size_t>(rank) == row_shape.size() + 1 &&
                          std::equal(row_shape.begin(), row_shape.end(), dims + 1);
  const H5Handle stored = wrap(H5Dget_type(table.id_.id()), close_type, table.place_, "has no type");
  if (!same_shape || H5Tequal(stored.id(), type_of(type)) <= 0) {
    const std::string wanted = text_of(type_of(type), row_shape);
    const std::string found = text_of(stored.id(), {dims + 1, dims + rank});
    throw InputError(table.place_, wanted + " is wanted, " + found +
                                       (wanted == found ? " in another byte order" : "") + " is there");
  }
  table.row_shape_ = row_shape;
  for (std::uint64_t extent : row_shape) table.row_elements_ *= extent;
  table.stored_ = check_stored_rows(table.id_.id(), table.place_, row_shape, H5Tget_size(type_of(type)));
  // The library keeps one decoded chunk: small reads in a row are of the same one.
  const H5Handle access = wrap(H5Pcreate(H5P_DATASET_ACCESS), close_list, table.place_, "cannot be prepared");
  H5Pset_chunk_cache(access.id(), 1, table.stored_.chunk_bytes, 1.0);
  table.id_ = {};
  table.id_ =
      wrap(H5Dopen2(id_.id(), name.c_str(), access.id()), close_dataset, table.place_, "is not a dataset");
  return table;
}

H5File H5File::create(const std::filesystem::path& path) {
  prepare_library();
  H5File file;
  file.place_ = path.string() + ":";
  const H5Handle access = access_list(file.place_);
  // time stamps would make equal contents unequal files
  const H5Handle creation = wrap(H5Pcreate(H5P_FILE_CREATE), close_list, file.place_, "cannot be prepared");
  H5Pset_obj_track_times(creation.id(), false);
  file.id_ = wrap(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), close_file,
                  path.string(), "cannot be created");
  file.rows_lost_ = std::make_shared<bool>(false);
  return file;
}

H5File H5File::open(const std::filesystem::path& path) {
  prepare_library();
  if (!std::filesystem::exists(path)) throw InputError(path.string(), "does not exist");
  if (std::filesystem::is_directory(path)) throw InputError(path.string(), "is a folder; a file is needed");
  if (!std::filesystem::is_regular_file(path)) throw InputError(path.string(), "is not a file");
  H5File file;
  file.place_ = path.string() + ":";
  hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  // once more: a disturbance of the moment must not make a finished file an unfinished one
  if (id < 0) id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) {
    const H5Handle access = follower_access_list(file.place_);
    id = H5Fopen(path.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access.id());
    file.unfinished_ = true;
  }
  if (id < 0) refuse_unreadable(path);
  file.id_ = {id, close_file};
  return file;
}

void H5File::flush() {
  if (H5Fflush(id_.id(), H5F_SCOPE_GLOBAL) < 0) refuse_output(place_, "cannot be flushed to disk");
}

void H5File::detach_after_write_error() noexcept {
  void* descriptor = nullptr;
  if (id_.id() < 0 || H5Fget_vfd_handle(id_.id(), H5P_DEFAULT, &descriptor) < 0) return;
  const int nowhere = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nowhere < 0) return;
  ::dup2(nowhere, *static_cast<const int*>(descriptor));
  ::close(nowhere);
}

void H5File::close() {
  TRILAT_CHECK(H5Fget_obj_count(id_.id(), H5F_OBJ_ALL | H5F_OBJ_LOCAL) == 1,
               "tables and groups are gone before their file, which else stays open");
  flush();
  if (rows_lost_ && *rows_lost_)
    throw OutputError(without_colon(place_), "could not be written to its end; is the disk full?");
  if (id_.close() < 0) refuse_output(place_, "cannot be closed");
}

}  // namespace trilat
