// SPDX-License-Identifier: MIT
//
// The commands' set-up functions, one file each; registry.cpp lists them.
#pragma once

#include "sandbox/cli.h"

namespace skerry::sandbox {

Action setup_list(CLI::App& app);
Action setup_run(CLI::App& app);
Action setup_capture(CLI::App& app);
Action setup_export(CLI::App& app);
Action setup_analyze(CLI::App& app);
Action setup_test(CLI::App& app);
Action setup_open(CLI::App& app);
Action setup_record(CLI::App& app);
Action setup_replay(CLI::App& app);
Action setup_solve(CLI::App& app);
Action setup_golden(CLI::App& app);
Action setup_doctor(CLI::App& app);

}  // namespace skerry::sandbox
