// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

#include "pipeline/cli/exchange.h"

namespace trilat {

struct ExchangeArguments {
  ImportArguments import;
  ExportArguments output;
};

// The verbs that speak other people's formats. `arguments` live as long as `app` is used; `code` gets the
// verb's exit code.
void add_exchange_verbs(CLI::App& app, ExchangeArguments& arguments, int& code);

}  // namespace trilat
