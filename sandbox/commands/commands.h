// SPDX-License-Identifier: MIT
//
// The commands' set-up functions, one file each; registry.cpp lists them.
#pragma once

#include "sandbox/cli.h"

namespace skerry::sandbox {

Action setup_list(OptionTable& table);
Action setup_run(OptionTable& table);
Action setup_capture(OptionTable& table);
Action setup_export(OptionTable& table);
Action setup_analyze(OptionTable& table);
Action setup_test(OptionTable& table);
Action setup_open(OptionTable& table);
Action setup_record(OptionTable& table);
Action setup_replay(OptionTable& table);
Action setup_solve(OptionTable& table);
Action setup_golden(OptionTable& table);
Action setup_doctor(OptionTable& table);

}  // namespace skerry::sandbox
