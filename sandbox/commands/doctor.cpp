// SPDX-License-Identifier: MIT
#include "render/doctor.h"

#include <ostream>

#include "sandbox/commands/commands.h"
#include "sandbox/errors.h"

namespace skerry::sandbox {

Action setup_doctor(OptionTable&) {
  return [](const Io& io) {
    bool good = true;
    for (const render::DoctorLine& line : render::examine()) {
      io.out << (line.ok ? "  ok       " : line.required ? "  MISSING  " : "  absent   ") << line.what;
      if (!line.detail.empty()) io.out << ": " << line.detail;
      if (!line.remedy.empty()) io.out << " -> " << line.remedy;
      io.out << '\n';
      good = good && (line.ok || !line.required);
    }
    io.out << (good ? "Captures work here.\n" : "Captures do not work here.\n");
    return static_cast<int>(good ? kGood : kEnvironmentError);
  };
}

}  // namespace skerry::sandbox
