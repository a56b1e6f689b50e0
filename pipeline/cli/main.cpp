// SPDX-License-Identifier: MIT
#include <cstdio>
#include <exception>
#include <filesystem>
#include <system_error>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

int reported(const char* text, int code) {
  std::fprintf(stderr, "trilat: %s\n", text);
  return code;
}

// Exit code of the exception that is being handled: its type decides.
int exit_code_of_exception() {
  try {
    throw;
  } catch (const InputError& error) {
    return reported(error.what(), kBadInput);
  } catch (const Interrupted&) {
    return reported("interrupted", kInterrupted);
  } catch (const std::bad_alloc&) {
    return reported("there is not enough memory", kBadInput);
  } catch (const std::filesystem::filesystem_error& error) {
    return reported((error.path1().string() + ": " + error.code().message()).c_str(), kBadInput);
  } catch (const std::system_error& error) {  // of fmt, when stdout cannot be written
    return reported(error.what(), kBadInput);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trilat: this is a bug of the program, please report it: %s\n", error.what());
    return kInternalError;
  }
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  try {
    const int code = trilat::run_verb(argc, argv, std::string(trilat::kProgramVersion) + "\n" + TRILAT_BUILD);
    if (std::fflush(stdout) != 0) throw trilat::OutputError("stdout", "cannot be written to its end");
    return code;
  } catch (...) {
    return trilat::exit_code_of_exception();
  }
}
