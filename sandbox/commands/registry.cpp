// SPDX-License-Identifier: MIT
#include "sandbox/commands/commands.h"

namespace skerry::sandbox {

std::span<const Command> commands() {
  static constexpr Command kCommands[] = {
      {"open", "Opens a window: play, step back, drag bodies, compare", "skerry open newtons_cradle",
       setup_open},
      {"list", "Demos with title, lesson and parameters", "skerry list", setup_list},
      {"run", "Steps a demo without pictures and checks its numbers",
       "skerry run newtons_cradle --set lifted=2 --report out.json", setup_run},
      {"capture", "Records demos to MP4, MKV, WebM, GIF or PNG",
       "skerry capture newtons_cradle -o cradle.mp4 --matrix", setup_capture},
      {"export", "Writes a moment of a demo as a figure: SVG, PNG, curves over time",
       "skerry export newtons_cradle --at 1 --svg cradle.svg --plot energy.svg", setup_export},
      {"analyze", "Will it stand? Forces at rest, margin, governing contact, bridges",
       "skerry analyze masonry_arch -o thrust.svg", setup_analyze},
      {"test", "Checks every number of demos, with every broad phase", "skerry test stack see_saw",
       setup_test},
      {"solve", "Solves a contact problem from a file, by any solver",
       "skerry solve island_W.mtx --solver body_space -o lambda.mtx", setup_solve},
      {"golden", "Compares pictures of known scenes with those that were blessed",
       "skerry golden --report golden_report", setup_golden},
      {"record", "Keeps every state of a demo in a file", "skerry record stack -o stack.skerry",
       setup_record},
      {"replay", "Runs a recording again and names the first state that differs",
       "skerry replay stack.skerry", setup_replay},
      {"doctor", "Says what of EGL, OpenGL and the encoders works here", "skerry doctor", setup_doctor},
  };
  return kCommands;
}

}  // namespace skerry::sandbox
