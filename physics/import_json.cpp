// SPDX-License-Identifier: MIT
//
// Reads what write_json writes: a JSON reader for this one format, which keeps the line of what it rejects.
#include <cctype>
#include <charconv>
#include <cmath>
#include <istream>
#include <map>
#include <stdexcept>

#include "physics/import.h"
#include "physics/text.h"

namespace skerry {
namespace {

struct Value {
  enum class Type : std::uint8_t { Number, Text, List, Object } type = Type::Number;
  int line = 0;
  double number = 0;
  std::string text;
  std::vector<Value> list;
  std::map<std::string, Value> object;
};

class Parser {
 public:
  Parser(std::istream& in, const std::string& name) : in_(in), name_(name) {}

  Value parse() {
    Value value = parse_value(0);
    if (peek() != EOF) fail("text after the end");
    return value;
  }

  [[noreturn]] void fail(const std::string& reason, int line = 0) const {
    throw std::invalid_argument(name_ + ":" + std::to_string(line ? line : line_) + ": " + reason);
  }

  const Value& member(const Value& object, const char* key) const {
    if (object.type != Value::Type::Object) fail("expected an object", object.line);
    const auto found = object.object.find(key);
    if (found == object.object.end()) fail(std::string("missing \"") + key + '"', object.line);
    return found->second;
  }

  double number(const Value& value) const {
    if (value.type == Value::Type::Number) return value.number;
    if (value.type == Value::Type::Text && value.text == "inf") return kInfinity;
    if (value.type == Value::Type::Text && value.text == "-inf") return -kInfinity;
    fail("expected a number", value.line);
  }

  int integer(const Value& value) const {
    const double x = number(value);
    if (!(std::abs(x) < 2e9) || x != std::floor(x))
      fail("expected an integer, got " + to_text(x), value.line);
    return static_cast<int>(x);
  }

  std::vector<double> numbers(const Value& value) const {
    std::vector<double> result;
    for (const Value& entry : items(value)) result.push_back(number(entry));
    return result;
  }

  double finite(const Value& value, const char* what) const {
    const double x = number(value);
    if (!std::isfinite(x)) fail(std::string(what) + " must be finite, got " + to_text(x), value.line);
    return x;
  }

  const std::vector<Value>& items(const Value& value) const {
    if (value.type != Value::Type::List) fail("expected a list", value.line);
    return value.list;
  }

 private:
  int peek() {
    for (int c = in_.peek(); c != EOF && std::isspace(c); c = in_.peek()) {
      if (in_.get() == '\n') ++line_;
    }
    return in_.peek();
  }
  void expect(char wanted) {
    const int c = peek();
    if (c != wanted) {
      std::string reason = "expected ' ', got the character ' '";
      reason[10] = wanted;
      reason[reason.size() - 2] = static_cast<char>(c);
      fail(c == EOF ? "ends too early" : reason);
    }
    in_.get();
  }
  bool take(char wanted) {
    if (peek() != wanted) return false;
    in_.get();
    return true;
  }

  Value parse_value(int depth) {
    // The format nests four deep; a file of brackets must not use up the stack.
    if (depth > 16) fail("nested too deeply");
    Value value;
    const int c = peek();
    value.line = line_;
    if (c == '{') {
      value.type = Value::Type::Object;
      expect('{');
      while (!take('}')) {
        if (!value.object.empty()) expect(',');
        peek();
        std::string key = parse_text();
        expect(':');
        value.object[std::move(key)] = parse_value(depth + 1);
      }
    } else if (c == '[') {
      value.type = Value::Type::List;
      expect('[');
      while (!take(']')) {
        if (!value.list.empty()) expect(',');
        value.list.push_back(parse_value(depth + 1));
      }
    } else if (c == '"') {
      value.type = Value::Type::Text;
      value.text = parse_text();
    } else {
      value.number = parse_number();
    }
    return value;
  }

  std::string parse_text() {
    expect('"');
    std::string text;
    for (int c = in_.get(); c != '"'; c = in_.get()) {
      if (c == EOF || c == '\n' || c == '\\') fail("text is not closed, or holds an escape");
      text.push_back(static_cast<char>(c));
    }
    return text;
  }

  double parse_number() {
    std::string text;
    for (int c = in_.peek(); c != EOF && (std::isalnum(c) || c == '+' || c == '-' || c == '.');
         c = in_.peek()) {
      text.push_back(static_cast<char>(in_.get()));
    }
    double value = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value)) {
      fail("expected a finite number, got \"" + text + '"');
    }
    return value;
  }

  std::istream& in_;
  std::string name_;
  int line_ = 1;
};

// Of the format, as written.
constexpr int kVersion = 1;

RowKind parse_kind(const Parser& parser, const Value& value) {
  const std::pair<const char*, RowKind> kinds[] = {
      {"normal", RowKind::Normal}, {"friction", RowKind::Friction}, {"rolling", RowKind::Rolling},
      {"joint", RowKind::Joint},   {"limit", RowKind::Limit},       {"motor", RowKind::Motor}};
  for (const auto& [name, kind] : kinds) {
    if (value.text == name) return kind;
  }
  parser.fail("unknown kind of row \"" + value.text + '"', value.line);
}

std::array<double, 3> parse_block(const Parser& parser, const Value& value) {
  const std::vector<double> entries = parser.numbers(value);
  if (entries.size() != 3)
    parser.fail("expected three numbers, got " + std::to_string(entries.size()), value.line);
  return {entries[0], entries[1], entries[2]};
}

Row parse_row(const Parser& parser, const Value& value) {
  Row row;
  row.kind = parse_kind(parser, parser.member(value, "kind"));
  row.a = parser.integer(parser.member(value, "a"));
  row.b = parser.integer(parser.member(value, "b"));
  row.Ja = parse_block(parser, parser.member(value, "Ja"));
  row.Jb = parse_block(parser, parser.member(value, "Jb"));
  row.lower = parser.number(parser.member(value, "lower"));
  row.upper = parser.number(parser.member(value, "upper"));
  row.normal = parser.integer(parser.member(value, "normal"));
  const Value& mu = parser.member(value, "mu");
  row.mu = parser.finite(mu, "mu");
  if (row.mu < 0) parser.fail("mu must not be negative, got " + to_text(row.mu), mu.line);
  const Value& source = parser.member(value, "source");
  const auto [end, error] =
      std::from_chars(source.text.data(), source.text.data() + source.text.size(), row.source);
  if (error != std::errc() || end != source.text.data() + source.text.size()) {
    parser.fail("source must be a decimal number in quotes, got \"" + source.text + '"', source.line);
  }
  return row;
}

}  // namespace

ImportedIsland read_json(std::istream& in, const std::string& name) {
  Parser parser(in, name);
  const Value root = parser.parse();
  const Value& format = parser.member(root, "format");
  if (format.text != "skerry-island")
    parser.fail("format must be \"skerry-island\", got \"" + format.text + '"');
  if (const auto version = root.object.find("version"); version != root.object.end()) {
    const int number = parser.integer(version->second);
    if (number != kVersion)
      parser.fail("version must be " + std::to_string(kVersion) + ", got " + std::to_string(number),
                  version->second.line);
  }
  ImportedIsland island;
  for (const Value& body : parser.items(parser.member(root, "bodies"))) {
    island.system.bodies.push_back({parser.number(parser.member(body, "inverse_mass")),
                                    parser.number(parser.member(body, "inverse_inertia"))});
    if (!body.object.contains("position")) continue;
    const std::vector<double> position = parser.numbers(body.object.at("position"));
    if (position.size() != 2) parser.fail("position must have two numbers", body.line);
    island.system.positions.push_back({position[0], position[1]});
  }
  for (const Value& row : parser.items(parser.member(root, "rows"))) {
    island.system.rows.push_back(parse_row(parser, row));
  }
  island.system.b = parser.numbers(parser.member(root, "b"));
  if (root.object.contains("compliance"))
    island.system.compliance = parser.numbers(root.object.at("compliance"));
  if (const auto lambda = root.object.find("lambda"); lambda != root.object.end()) {
    for (const Value& impulse : parser.items(lambda->second))
      island.lambda.push_back(parser.finite(impulse, "lambda"));
    if (!island.lambda.empty() && island.lambda.size() != island.system.rows.size())
      parser.fail("lambda must have " + std::to_string(island.system.rows.size()) +
                      " numbers, one a row, got " + std::to_string(island.lambda.size()),
                  lambda->second.line);
  }
  try {
    validate(island.system);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(name + ": " + error.what());
  }
  return island;
}

}  // namespace skerry
