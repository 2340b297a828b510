// SPDX-License-Identifier: MIT
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/lua_args.h"

namespace skerry::sandbox {
namespace {

using Json = nlohmann::ordered_json;

Json describe_parameter(const Parameter& parameter) {
  Json json{{"name", parameter.name}};
  if (!parameter.choices.empty()) {
    json["choices"] = parameter.choices;
    json["default"] = parameter.choices.front();
    return json;
  }
  json["default"] = parameter.standard;
  json["min"] = parameter.low;
  json["max"] = parameter.high;
  json["unit"] = parameter.unit;
  return json;
}

void print_parameter(std::ostream& out, const Parameter& parameter) {
  out << "    --set " << '"' << parameter.name << '=' << parameter.text() << '"';
  if (parameter.choices.empty()) {
    out << "  from " << format_number(parameter.low) << " to " << format_number(parameter.high);
    if (!parameter.unit.empty()) out << ' ' << parameter.unit;
  } else {
    out << "  one of:";
    for (const std::string& choice : parameter.choices) out << ' ' << choice;
  }
  out << '\n';
}

int list(const SharedOptions& shared, bool json, const Io& io) {
  int code = kGood;
  Json all = Json::array();
  std::string topic;
  for (const DemoFile& file : find_demos(demo_folder(shared.folder))) {
    try {
      const Demo demo(file.path, DemoOptions{});
      if (json) {
        Json entry{{"name", file.name},
                   {"topic", file.topic},
                   {"file", file.path},
                   {"title", demo.title()},
                   {"lesson", demo.lesson()},
                   {"seconds", demo.seconds()},
                   {"checks", demo.checks().size()},
                   {"parameters", Json::array()}};
        for (const Parameter& parameter : demo.parameters())
          entry["parameters"].push_back(describe_parameter(parameter));
        all.push_back(std::move(entry));
        continue;
      }
      if (file.topic != topic) io.out << file.topic << '\n';
      topic = file.topic;
      io.out << "  " << file.name << " - " << demo.title() << '\n';
      if (!demo.lesson().empty()) io.out << "    " << demo.lesson() << '\n';
      for (const Parameter& parameter : demo.parameters()) print_parameter(io.out, parameter);
    } catch (const ScriptError& error) {
      io.err << "skerry: " << error.what() << '\n';
      code = kScriptOrFile;
    }
  }
  if (json) io.out << all.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  return code;
}

}  // namespace

Action setup_list(OptionTable& table) {
  struct Options {
    SharedOptions shared;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  add_folder_option(table, options->shared);
  table.add_flag("--json", options->json, "Machine-readable");
  return [options](const Io& io) { return list(options->shared, options->json, io); };
}

}  // namespace skerry::sandbox
