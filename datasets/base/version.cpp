// SPDX-License-Identifier: MIT
#include "datasets/base/version.h"

#include <cstring>

#include <elf.h>
#include <fmt/format.h>
#include <link.h>

#include "datasets/base/content_hash.h"

namespace trilat {
namespace {

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

// The build id among the notes of one segment; empty when there is none.
std::string id_in_notes(const unsigned char* note, std::size_t size) {
  while (size >= sizeof(ElfW(Nhdr))) {
    ElfW(Nhdr) head;
    std::memcpy(&head, note, sizeof head);
    const std::size_t whole = sizeof head + padded(head.n_namesz) + padded(head.n_descsz);
    if (whole > size) break;
    if (head.n_type == NT_GNU_BUILD_ID) {
      const unsigned char* id = note + sizeof head + padded(head.n_namesz);
      return fmt::format("{:02x}", fmt::join(id, id + head.n_descsz, ""));
    }
    note += whole;
    size -= whole;
  }
  return {};
}

// The program itself is the first of all loaded objects.
int find_in_program(dl_phdr_info* object, std::size_t, void* found) {
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = object->dlpi_phdr[i];
    if (segment.p_type != PT_NOTE) continue;
    const auto* notes = reinterpret_cast<const unsigned char*>(object->dlpi_addr + segment.p_vaddr);
    auto& id = *static_cast<std::string*>(found);
    id = id_in_notes(notes, segment.p_memsz);
    if (!id.empty()) break;
  }
  return 1;
}

}  // namespace

std::string build_id() {
  static const std::string id = [] {
    std::string found;
    dl_iterate_phdr(find_in_program, &found);
    return found.empty() ? hash_of_file("/proc/self/exe") : found;
  }();
  return id;
}

}  // namespace trilat
