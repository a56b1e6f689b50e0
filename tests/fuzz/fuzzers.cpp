// SPDX-License-Identifier: MIT
#include "tests/fuzz/fuzzers.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_take.h"
#include "datasets/mocap/read_mocap.h"
#include "datasets/session/event_log.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "recorders/link/byte_stream.h"
#include "recorders/link/messages.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/memory_file.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSomeBodies = 4096;

// Bad input may be refused; whatever else is thrown is a finding.
template <class Work>
void tolerate_bad_input(const Work& work) {
  try {
    work();
  } catch (const InputError&) {
  }
}

// A reader of a file as a fuzzer.
template <auto read_file_at>
void file(FuzzInput input) {
  const MemoryFile held(input);
  tolerate_bad_input([&] { (void)read_file_at(held.path()); });
}

// ---- what other programs write
// A motion capture in any of its formats, as it is inspected and as ground truth.
void inspect_mocap(const fs::path& path) { summarize_mocap(read_mocap(path, {.block_bytes = 4096})); }

void read_some_assets(const fs::path& path) {
  std::vector<std::size_t> assets;
  for (std::size_t a = 0; a < read_mocap_header(path).assets.size(); a += 2) assets.push_back(a);
  read_positions(path, {.assets = assets, .block_bytes = 64});
}

void read_joints(const fs::path& path) {
  if (is_joint_csv(path)) read_joint_csv(path);
}

// ---- event logs
void read_log(FuzzInput input) {
  const auto bytes = std::as_bytes(input);
  LogScanner scanner("a log", [](std::size_t, LogEvent&&) {});
  tolerate_bad_input([&] {
    scanner.feed(bytes.first(bytes.size() / 3));
    scanner.feed(bytes.subspan(bytes.size() / 3));
    (void)scanner.finish();
  });
}

// ---- HDF5
void read_session(const fs::path& path) {
  const SessionReader session(path);
  verify_session(session, {});
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    session.body_frames(s, 0, std::min<std::uint64_t>(session.counts(s).body_frames, kSomeBodies));
    session.clock_exchanges(s);
    session.drop_counts(s);
    session.notices(s);
  }
}

// ---- messages to a recorder or an agent
void read_messages(FuzzInput input) {
  const std::span<const std::byte> bytes = std::as_bytes(input);
  MessageReader reader;
  try {
    reader.add(bytes.first(bytes.size() / 2));
    for (int half = 0; half < 2; ++half) {
      while (const auto message = reader.next()) (void)encode_message(*message);
      if (half == 0) reader.add(bytes.subspan(bytes.size() / 2));
    }
  } catch (const BadMessage&) {
  }
}

void read_address(FuzzInput input) {
  tolerate_bad_input([&] {
    const SocketAddress address = parse_address(std::string(input.begin(), input.end()));
    is_loopback(address);
    parse_address(text_of(address));
  });
}

constexpr Fuzzer kFuzzers[] = {
    {"mocap_summary", file<inspect_mocap>},
    {"mocap", file<read_some_assets>},
    {"joint_csv", file<read_joints>},
    {"event_log", read_log},
    {"session", file<read_session>},
    {"messages", read_messages},
    {"address", read_address},
};

}  // namespace

std::span<const Fuzzer> fuzzers() { return kFuzzers; }

void fuzz(std::string_view name, FuzzInput input) {
  const auto known = std::ranges::find(kFuzzers, name, &Fuzzer::name);
  if (known == std::end(kFuzzers)) {
    std::fprintf(stderr, "there is no fuzzer \"%s\"; there are:", std::string(name).c_str());
    for (const Fuzzer& fuzzer : kFuzzers) std::fprintf(stderr, " %s", std::string(fuzzer.name).c_str());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  known->read(input);
}

}  // namespace trilat

// HDF5 itself forgets some memory when a file's metadata are damaged.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
