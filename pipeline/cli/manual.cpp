// SPDX-License-Identifier: MIT
// `trilat manual`: the man page and the shells' completions, from the same definitions as --help.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/version.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct ManualArguments {
  std::string what;
};

std::vector<const CLI::App*> verbs_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

// Those that are in --help, without --help itself.
std::vector<const CLI::Option*> options_of(const CLI::App& verb) {
  return verb.get_options([](const CLI::Option* option) {
    return !option->get_group().empty() && !option->get_positional() && option->get_single_name() != "help";
  });
}

std::string replaced(std::string text, char what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, 1, by);
  return text;
}

// roff takes a backslash, and a point or quote that begins a line, for its own.
std::string roff(const std::string& text) {
  std::string escaped = replaced(replaced(text, '\\', "\\e"), '-', "\\-");
  if (escaped.starts_with('.') || escaped.starts_with('\'')) escaped.insert(0, "\\&");
  return escaped;
}

std::string man_page(const CLI::App& program) {
  std::string text = fmt::format(
      ".\\\" Made by `trilat manual man`.\n.TH TRILAT 1 \"\" \"{}\"\n.SH NAME\ntrilat \\- trilateration with "
      "several Kinect v2 against OptiTrack\n.SH SYNOPSIS\n.B trilat\n.I VERB\n[\\fIOPTIONS\\fR]\n.SH "
      "DESCRIPTION\n{}\n.SH VERBS\n",
      kProgramVersion, roff(program.get_description()));
  for (const CLI::App* verb : verbs_of(program)) {
    text += fmt::format(".SS {}\n{}\n.PP\n.B {}\n", roff(verb->get_name()), roff(verb->get_description()),
                        roff("trilat " + verb->get_name() + " [OPTIONS]"));
    for (const CLI::Option* option : verb->get_options())
      if (option->get_positional())
        text +=
            fmt::format(".TP\n.I {}\n{}\n", roff(option->get_name(true)), roff(option->get_description()));
    for (const CLI::Option* option : options_of(*verb))
      text += fmt::format(".TP\n.B {}\n{}\n", roff(option->get_name(false, true)),
                          roff(option->get_description()));
  }
  return text +
         ".SH EXIT STATUS\n0 done; 1 done, but items failed or the gate found a regression; 2 bad input or "
         "usage; 70 a bug.\n";
}

// "-o --output": as a shell wants them.
std::string flags_of(const CLI::App& verb) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : options_of(verb)) {
    for (const std::string& name : option->get_snames()) flags.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  flags.emplace_back("--help");
  return fmt::format("{}", fmt::join(flags, " "));
}

std::vector<std::string> names_of(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* verb : verbs_of(program)) names.push_back(verb->get_name());
  return names;
}

std::string bash_completion(const CLI::App& program) {
  std::string text = fmt::format(
      "# Made by `trilat manual bash`.\n_trilat() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}} words=\n  if "
      "[[ $COMP_CWORD -eq 1 ]]; then\n    words=\"{} --help --version\"\n  elif [[ $word == -* ]]; then\n    "
      "case ${{COMP_WORDS[1]}} in\n",
      fmt::join(names_of(program), " "));
  for (const CLI::App* verb : verbs_of(program))
    text += fmt::format("      {}) words=\"{}\" ;;\n", verb->get_name(), flags_of(*verb));
  return text +
         "    esac\n  fi\n  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n}\ncomplete -o "
         "default -F _trilat trilat\n";
}

std::string quoted(const std::string& text) { return "'" + replaced(text, '\'', "'\\''") + "'"; }

std::string zsh_completion(const CLI::App& program) {
  std::string text = "#compdef trilat\n# Made by `trilat manual zsh`.\nlocal -a verbs options\nverbs=(\n";
  for (const CLI::App* verb : verbs_of(program))
    text += "  " + quoted(verb->get_name() + ":" + replaced(verb->get_description(), ':', "\\:")) + "\n";
  text += ")\nif (( CURRENT == 2 )); then\n  _describe verb verbs\n  return\nfi\ncase $words[2] in\n";
  for (const CLI::App* verb : verbs_of(program))
    text += fmt::format("  {}) options=({}) ;;\n", verb->get_name(), flags_of(*verb));
  return text + "esac\nif [[ $PREFIX == -* ]]; then compadd -- $options; else _files; fi\n";
}

std::string fish_completion(const CLI::App& program) {
  std::string text = "# Made by `trilat manual fish`.\n";
  for (const CLI::App* verb : verbs_of(program)) {
    text += fmt::format("complete -c trilat -f -n __fish_use_subcommand -a {} -d {}\n", verb->get_name(),
                        quoted(verb->get_description()));
    for (const CLI::Option* option : options_of(*verb)) {
      text += fmt::format("complete -c trilat -n '__fish_seen_subcommand_from {}'", verb->get_name());
      for (const std::string& name : option->get_snames()) text += " -s " + name;
      for (const std::string& name : option->get_lnames()) text += " -l " + name;
      text += fmt::format("{} -d {}\n", option->get_items_expected_max() == 0 ? "" : " -r",
                          quoted(option->get_description()));
    }
  }
  return text;
}

int manual(const ManualArguments& arguments, const CLI::App& program) {
  const auto make = arguments.what == "man"    ? man_page
                    : arguments.what == "bash" ? bash_completion
                    : arguments.what == "zsh"  ? zsh_completion
                                               : fish_completion;
  fmt::print("{}", make(program));
  return kDone;
}

}  // namespace

void add_manual(CLI::App& app, int& code) {
  CLI::App* verb = app.add_subcommand(
      "manual", "the man page, or what makes bash, zsh or fish complete verbs and options");
  const auto arguments = std::make_shared<ManualArguments>();
  verb->add_option("what", arguments->what, "man, bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"man", "bash", "zsh", "fish"}));
  verb->callback([=, &app, &code] { code = manual(*arguments, app); });
}

}  // namespace trilat
