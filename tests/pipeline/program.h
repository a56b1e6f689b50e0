// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "datasets/base/files.h"
#include "datasets/base/json.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {

struct Ended {
  int code = -1;  // -1 when a signal ended it
  std::string out, err;
};

// A started `trilat`; its streams go to files in the folder, whose names begin with `name`.
class Process {
 public:
  Process(const ScratchFolder& folder, const std::vector<std::string>& arguments,
          const std::string& name = "", const char* program = kProgram)
      : out_(folder / (name + "stdout.txt")), err_(folder / (name + "stderr.txt")) {
    std::vector<char*> argv{const_cast<char*>(program)};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    const int err = ::open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  void interrupt() const { kill(pid_, SIGINT); }
  void kill_at_once() const { kill(pid_, SIGKILL); }
  void hang_up() const { kill(pid_, SIGHUP); }
  Ended wait() const {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out_), read_file(err_)};
  }

 private:
  std::filesystem::path out_, err_;
  pid_t pid_ = -1;
};

inline Ended run_trilat(const ScratchFolder& folder, const std::vector<std::string>& arguments) {
  return Process(folder, arguments).wait();
}

// Exit code 2 with one line on stderr that says what is wrong, and nothing on stdout.
inline void expect_refused(const Ended& ended, const std::string& message) {
  EXPECT_EQ(ended.code, 2) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_THAT(ended.err, testing::StartsWith("trilat: "));
  EXPECT_THAT(ended.err, testing::HasSubstr(message));
  EXPECT_EQ(std::ranges::count(ended.err, '\n'), 1) << ended.err;
  EXPECT_THAT(ended.err, testing::EndsWith("\n"));
}

inline Json only_json(const Ended& ended) { return parse_json(ended.out, "stdout"); }

inline std::string file_with(const ScratchFolder& folder, const std::string& name, const std::string& text) {
  write_file(folder / name, text);
  return (folder / name).string();
}

}  // namespace trilat
