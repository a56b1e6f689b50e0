// SPDX-License-Identifier: MIT
#include "reports/figures/draw_figures.h"

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

extern char** environ;

namespace trilat {
namespace {

constexpr const char* kAllDrawn = "all figures are drawn";
constexpr std::size_t kMaxPicture = 32u << 20;  // bytes

// A file in memory, which gnuplot inherits: it does not tell when a disk is full or cannot be read.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view text = {}) : descriptor_(::memfd_create("figure", 0)) {
    if (descriptor_ < 0) fail("made");
    while (!text.empty()) {
      const ssize_t count = ::write(descriptor_, text.data(), text.size());
      if (count <= 0) fail("written");
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  MemoryFile(MemoryFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ~MemoryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  std::string name() const { return fmt::format("/proc/self/fd/{}", descriptor_); }
  std::string text() const { return read_file(name(), kMaxPicture); }

 private:
  [[noreturn]] static void fail(const char* doing) {
    throw OutputError("a file in memory, for a figure,",
                      fmt::format("cannot be {}: {}", doing, std::strerror(errno)));
  }
  int descriptor_;
};

struct Pictures {
  MemoryFile svg{}, pdf{};
};

// Runs gnuplot without the user's settings; what it says goes to `said`. Its exit code, or nothing when it is
// not installed.
std::optional<int> run_gnuplot(const std::string& argument, const std::string& said) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  for (int descriptor : {1, 2})
    posix_spawn_file_actions_addopen(&actions, descriptor, said.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  std::string program = "gnuplot", defaults = "-d", file = argument;
  char* arguments[] = {program.data(), defaults.data(), file.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT) return {};
  if (error != 0) throw InputError("gnuplot", fmt::format("cannot be started: {}", std::strerror(error)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR)
      throw InputError("gnuplot", fmt::format("cannot be waited for: {}", std::strerror(errno)));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

// Both pictures of a figure, behind one that makes every picture begin with the same colour. They have the
// same size: a millimetre is 96 / 25.4 px, 8 pt are 10.7 px. pdfcairo takes a point for a pixel of 96 dpi.
std::string drawing_of(const Figure& figure, const Pictures& pictures) {
  constexpr double kPixelsPerMm = 96.0 / 25.4;
  const auto output = [&](const MemoryFile& file) { return "set output '" + file.name() + "'\n"; };
  const FigureSize size = size_of(figure);
  const std::string script = gnuplot_script(figure);
  return fmt::format(
             "reset session\nset terminal svg noenhanced size {:.0f},{:.0f} fixed font 'Helvetica,10.7' "
             "background '#ffffff'\nset output '/dev/null'\nplot 0\n",
             kPixelsPerMm * size.width_mm, kPixelsPerMm * size.height_mm) +
         output(pictures.svg) + script +
         fmt::format(
             "set output\nreset session\nset terminal pdfcairo noenhanced size {}cm,{}cm font 'Helvetica,8' "
             "fontscale 0.75\n",
             0.1 * size.width_mm, 0.1 * size.height_mm) +
         output(pictures.pdf) + script + "set output\n";
}

// A PDF has the time when it was drawn in it, 14 digits, which would make every run's another one.
void set_fixed_date(std::string& pdf) {
  constexpr std::string_view kBefore = "/CreationDate (D:";
  constexpr std::string_view kDate = "20000101000000";
  for (std::size_t at = pdf.find(kBefore); at != std::string::npos; at = pdf.find(kBefore, at + 1))
    if (at + kBefore.size() + kDate.size() <= pdf.size())
      pdf.replace(at + kBefore.size(), kDate.size(), kDate);
}

}  // namespace

std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures) {
  std::vector<DrawnFigure> drawn;
  if (figures.empty()) return drawn;
  std::vector<Pictures> pictures(figures.size());
  std::string script;
  for (std::size_t k = 0; k < figures.size(); ++k) script += drawing_of(figures[k], pictures[k]);
  script += fmt::format("print '{}'\n", kAllDrawn);
  const MemoryFile commands(script), said;
  const std::optional<int> code = run_gnuplot(commands.name(), said.name());
  if (!code) {
    for (Figure& figure : figures) drawn.push_back({std::move(figure), {}, {}});
    return drawn;
  }
  const std::string text = said.text();
  if (*code != 0 || text.find(kAllDrawn) == std::string::npos)
    throw InputError("gnuplot", fmt::format("ended with {} and says: {}", *code, text));
  for (std::size_t k = 0; k < figures.size(); ++k) {
    DrawnFigure picture{std::move(figures[k]), pictures[k].svg.text(), pictures[k].pdf.text()};
    if (!picture.svg.ends_with("</svg>\n\n") || !picture.pdf.ends_with("%%EOF\n"))
      throw InputError("gnuplot", "did not draw the figure \"" + picture.figure.id + "\" to its end");
    set_fixed_date(picture.pdf);
    drawn.push_back(std::move(picture));
  }
  return drawn;
}

}  // namespace trilat
