// SPDX-License-Identifier: MIT
#include "reports/figures/draw_figures.h"

#include <cctype>
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
#include "reports/figures/figure_script.h"

extern char** environ;

namespace trilat {

namespace {

constexpr const char* kNoGnuplot =
    "gnuplot is not installed (apt-get install gnuplot-nox), so no figure can be drawn";
constexpr const char* kAllDrawn = "all figures are drawn";
constexpr std::size_t kMostPicture = 32u << 20;  // bytes

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
  std::string text() const { return read_file(name(), kMostPicture); }

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

// Runs gnuplot without the user's settings; what it says goes to `said`. Its exit code, or 127 when there is
// none.
int run_gnuplot(const std::string& argument, const std::string& said) {
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
  if (error != 0) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return 127;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

// What gnuplot takes for the name of a picture.
std::string letters_of(std::string id) {
  for (char& c : id)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return id;
}

// Both pictures of a figure.
std::string drawing_of(const Figure& figure, const Pictures& pictures) {
  const auto output = [&](const MemoryFile& file) { return "set output '" + file.name() + "'\n"; };
  const int height_px = figure.equal_scales ? 640 : 480;
  return fmt::format(
             "reset session\nset terminal svg noenhanced size 760,{} dynamic mouse standalone font "
             "'Helvetica,13' background '#ffffff' name '{}'\n",
             height_px, letters_of(figure.id)) +
         output(pictures.svg) + gnuplot_script(figure) +
         fmt::format("set output\nset terminal pdfcairo noenhanced size 16cm,{}cm font 'Helvetica,9'\n",
                     0.02 * height_px + 0.4) +
         output(pictures.pdf) + "replot\nset output\n";
}

// A PDF has the time when it was drawn in it, 14 digits, which would make every run's another one.
void set_fixed_date(std::string& pdf) {
  constexpr std::string_view kBefore = "/CreationDate (D:";
  constexpr std::string_view kDate = "20000101000000";
  for (std::size_t at = pdf.find(kBefore); at != std::string::npos; at = pdf.find(kBefore, at + 1))
    if (at + kBefore.size() + kDate.size() <= pdf.size())
      pdf.replace(at + kBefore.size(), kDate.size(), kDate);
}

void mark_companions(std::string& svg) {
  constexpr std::string_view kPlot = "_plot_", kTitle = "\" ><title>", kEnd = "</title>";
  for (std::size_t at = svg.find(kTitle); at != std::string::npos; at = svg.find(kTitle, at + 1)) {
    const std::size_t quote = svg.rfind('"', at - 1), text = at + kTitle.size(), end = svg.find(kEnd, text);
    if (quote == std::string::npos || end == std::string::npos) return;
    const std::string id = svg.substr(quote + 1, at - quote - 1);
    if (id.find(kPlot) == std::string::npos || svg.substr(text, end - text) != id) continue;
    svg.replace(at, end + kEnd.size() - at, "\" class=\"companion\">");
  }
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
  const int code = run_gnuplot(commands.name(), said.name());
  if (code == 127) throw InputError("gnuplot", kNoGnuplot);
  const std::string text = said.text();
  if (code != 0 || text.find(kAllDrawn) == std::string::npos)
    throw InputError("gnuplot", fmt::format("ended with {} and says: {}", code, text));
  for (std::size_t k = 0; k < figures.size(); ++k) {
    DrawnFigure picture{std::move(figures[k]), pictures[k].svg.text(), pictures[k].pdf.text()};
    if (!picture.svg.ends_with("</svg>\n\n") || !picture.pdf.ends_with("%%EOF\n"))
      throw InputError("gnuplot", "did not draw the figure \"" + picture.figure.id + "\" to its end");
    picture.svg = svg_with_rules(std::move(picture.svg));
    set_fixed_date(picture.pdf);
    drawn.push_back(std::move(picture));
  }
  return drawn;
}

std::string svg_with_rules(std::string svg) {
  mark_companions(svg);
  const std::size_t root = svg.find("<svg");
  const std::size_t open_end = root == std::string::npos ? root : svg.find("\n>", root);
  if (open_end == std::string::npos) return svg;
  svg.insert(open_end + 2, "\n<style>g[visibility=\"hidden\"]+g.companion{visibility:hidden}</style>");
  return svg;
}

}  // namespace trilat
