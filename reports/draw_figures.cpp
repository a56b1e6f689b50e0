// SPDX-License-Identifier: MIT
#include "reports/draw_figures.h"

#include <cctype>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "reports/figure_script.h"
#include "reports/svg_look.h"

extern char** environ;

namespace trilat {
namespace {

constexpr const char* kMissing =
    "gnuplot is not installed (apt-get install gnuplot-nox), so no figure can be drawn";
constexpr std::size_t kMostPicture = 32u << 20;  // bytes

// A folder of this run alone, gone at the end.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "trilat-figures-XXXXXX").string();
    if (!mkdtemp(name.data())) throw OutputError(name, "cannot be made");
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

// Runs gnuplot without the user's settings; what it says goes to `said`. Its exit code, or 127 when there is
// none.
int run_gnuplot(const std::string& argument, const std::filesystem::path& said) {
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

// Both pictures of a figure, into files named by its number.
std::string drawing_of(const Figure& figure, const WorkFolder& folder, std::size_t number) {
  const auto output = [&](const char* kind) {
    return "set output '" + (folder / fmt::format("{}.{}", number, kind)).string() + "'\n";
  };
  const int height_px = figure.equal_scales ? 640 : 480;
  return fmt::format(
             "reset session\nset terminal svg noenhanced size 760,{} dynamic mouse standalone font "
             "'Helvetica,13' "
             "background '#ffffff' name '{}'\n",
             height_px, letters_of(figure.id)) +
         output("svg") + gnuplot_script(figure) +
         fmt::format("set output\nset terminal pdfcairo noenhanced size 16cm,{}cm font 'Helvetica,9'\n",
                     0.02 * height_px + 0.4) +
         output("pdf") + "replot\nset output\n";
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

bool can_draw_figures() { return run_gnuplot("--version", "/dev/null") == 0; }

std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures) {
  std::vector<DrawnFigure> drawn;
  if (figures.empty()) return drawn;
  const WorkFolder folder;
  std::string script;
  for (std::size_t k = 0; k < figures.size(); ++k) script += drawing_of(figures[k], folder, k);
  write_file(folder / "script", script);
  const int code = run_gnuplot((folder / "script").string(), folder / "said");
  if (code == 127) throw InputError("gnuplot", kMissing);
  if (code != 0)
    throw InputError("gnuplot", fmt::format("ended with {} and says: {}", code, read_file(folder / "said")));
  for (std::size_t k = 0; k < figures.size(); ++k) {
    DrawnFigure picture{std::move(figures[k]),
                        svg_with_rules(read_file(folder / fmt::format("{}.svg", k), kMostPicture)),
                        read_file(folder / fmt::format("{}.pdf", k), kMostPicture)};
    set_fixed_date(picture.pdf);
    drawn.push_back(std::move(picture));
  }
  return drawn;
}

}  // namespace trilat
