// SPDX-License-Identifier: MIT
#include "render/html_report.h"

#include <algorithm>

#include "render/html_report_page.h"
#include "render/utf8.h"

namespace skerry::render {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string span(const char* kind, const std::string& text) {
  return std::string("<span class=\"") + kind + "\">" + escaped(text) + "</span>";
}

std::string data_uri(const Image& image) {
  return "data:image/png;base64," + base64(encode_png(image));
}

std::string picture(const Image& image, const std::string& alt, const std::string& attributes = {}) {
  return "<img alt=\"" + escaped(alt) + "\" " + attributes + " src=\"" + data_uri(image) + "\">";
}

// A picture that is on the page already: the script fills it in.
std::string copy_of(const char* part) {
  return std::string("<img alt=\"") + part + "\" data-copy=\"" + part + "\">";
}

std::string figure(const std::string& content, const std::string& caption) {
  return "<figure>" + content + "<figcaption>" + escaped(caption) + "</figcaption></figure>";
}

std::string row(const std::string& name, const std::string& html) {
  return "<tr><td class=\"dim\">" + escaped(name) + "</td><td>" + html + "</td></tr>";
}

std::string command(const std::string& name, const std::string& text) {
  return row(name, "<code>" + escaped(text) + "</code> <button class=\"copy\">copy</button>");
}

// Picture and state, each with its own verdict.
std::string facts(const ReportScene& scene) {
  std::string html = "<table>";
  const char* kind = scene.picture_good ? "good" : scene.expected ? "bad" : "new";
  html += row("picture", span(kind, scene.picture_good ? "as blessed"
                                    : scene.expected   ? "differs"
                                                       : "none was blessed") +
                             " &mdash; " + escaped(scene.picture_reason));
  if (scene.state_expected.empty())
    html += row("state", span("new", "none was blessed") + " &mdash; <code>" + escaped(scene.state_actual) +
                             "</code>");
  else if (scene.state_good())
    html += row("state",
                span("good", "as blessed") + " &mdash; <code>" + escaped(scene.state_actual) + "</code>");
  else
    html += row("state", span("bad", "moved") + " &mdash; expected <code>" + escaped(scene.state_expected) +
                             "</code>, got <code>" + escaped(scene.state_actual) + "</code>");
  html += command("repeat", scene.repeat) + command("bless", scene.bless);
  return html + "</table>";
}

std::string controls() {
  std::string html = "<div class=\"bar\">";
  for (const auto& [mode, text] :
       {std::pair{"side", "side by side"}, std::pair{"slider", "slider"}, std::pair{"blink", "blink"},
        std::pair{"difference", "difference"}, std::pair{"map", "map"}})
    html += std::string("<button data-mode=\"") + mode + "\" aria-pressed=\"false\">" + text + "</button>";
  return html + "</div>";
}

std::string views(const ReportScene& scene, const DiffRule& rule) {
  const Image& expected = *scene.expected;
  const Image& actual = scene.actual;
  std::string html = "<div class=\"stage side\" data-view=\"side\">";
  html += figure(picture(expected, "expected", "data-part=\"expected\""), "expected");
  html += figure(picture(actual, "actual", "data-part=\"actual\""), "actual") + "</div>";
  html += "<div class=\"stage\" data-view=\"slider\" hidden><div class=\"over\">" + copy_of("expected") +
          "<div class=\"top\" data-part=\"slide-top\">" + copy_of("actual") +
          "</div><div class=\"rule\" data-part=\"rule\"></div></div><label class=\"dim\">expected "
          "<input type=\"range\" min=\"0\" max=\"1000\" value=\"500\" data-part=\"slider\"> "
          "actual</label></div>";
  html += "<div class=\"stage\" data-view=\"blink\" hidden><div class=\"over\">" + copy_of("expected") +
          "<div class=\"top\" data-part=\"blink-top\" hidden>" + copy_of("actual") +
          "</div></div><p class=\"dim\" data-part=\"blink-text\">expected</p></div>";
  html +=
      "<div class=\"stage\" data-view=\"difference\" hidden><div class=\"over\"><canvas "
      "data-part=\"difference\"></canvas></div><label class=\"dim\">gain <input type=\"range\" min=\"1\" "
      "max=\"64\" value=\"8\" data-part=\"gain\"> <span data-part=\"gain-text\"></span></label></div>";
  html += "<div class=\"stage\" data-view=\"map\" hidden><div class=\"over\">" +
          picture(difference_image(expected, actual, rule), "map") +
          "</div><p class=\"dim\">blue: rounding; yellow to red: beyond it</p></div>";
  html += "<div class=\"zoom\">";
  for (const char* which : {"expected", "actual", "difference"})
    html += figure(std::string("<canvas data-part=\"zoom-") + which + "\"></canvas>",
                   std::string(which) + ", worst group");
  return html + "</div>";
}

std::string section(const ReportScene& scene, const DiffRule& rule) {
  const DiffBox& box = scene.diff.worst_box;
  std::string html = "<section id=\"" + escaped(scene.name) + '"';
  const bool compared = scene.expected && scene.diff.same_size;
  if (compared)
    html += " data-limit=\"" + std::to_string(rule.max_channel) + "\" data-largest=\"" +
            std::to_string(scene.diff.max_difference) + "\" data-beyond=\"" +
            std::to_string(scene.diff.beyond) + "\" data-box='{\"x\":" + std::to_string(box.x) +
            ",\"y\":" + std::to_string(box.y) + ",\"w\":" + std::to_string(box.width) +
            ",\"h\":" + std::to_string(box.height) + "}'";
  html += "><header><h2>" + escaped(scene.name) + "</h2><span class=\"dim\">" + escaped(scene.about) +
          "</span></header>";
  if (!scene.problem.empty()) return html + "<p class=\"bad\">" + escaped(scene.problem) + "</p></section>\n";
  html += facts(scene);
  if (compared) {
    html += controls() + views(scene, rule);
  } else {
    html += "<div class=\"stage side\">";
    if (scene.expected) html += figure(picture(*scene.expected, "expected"), "expected");
    html += figure(picture(scene.actual, "actual"), "actual") + "</div>";
  }
  return html + "</section>\n";
}

std::string total(const char* kind, std::ptrdiff_t count, const char* what) {
  return std::string("<div><b class=\"") + (count > 0 ? kind : "") + "\">" + std::to_string(count) + "</b>" +
         what + "</div>";
}

}  // namespace

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < count ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string html_report(const ReportPage& page) {
  const auto count = [&](auto&& condition) {
    return std::count_if(page.scenes.begin(), page.scenes.end(), condition);
  };
  const auto settled = [](const ReportScene& s) {
    return s.problem.empty() && s.picture_good && s.state_good();
  };
  std::string html = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                     escaped(page.title) +
                     "</title><meta name=\"viewport\" content=\"width=device-width\"><style>" + kReportStyle +
                     "</style></head><body><main><h1>" + escaped(page.title) + "</h1><p class=\"dim\">" +
                     escaped(page.about) + "</p><div class=\"totals\">";
  html += total("", static_cast<std::ptrdiff_t>(page.scenes.size()), "scenes");
  html += total("bad", count([](const ReportScene& s) { return s.expected && !s.picture_good; }),
                "pictures differ");
  html += total("bad", count([](const ReportScene& s) {
                  return s.problem.empty() && !s.state_expected.empty() && !s.state_good();
                }),
                "states moved");
  html += total(
      "new", count([](const ReportScene& s) { return s.problem.empty() && !s.picture_good && !s.expected; }),
      "new");
  html += total("bad", count([](const ReportScene& s) { return !s.problem.empty(); }), "without a picture");
  html += "</div>\n";
  for (const ReportScene& scene : page.scenes)
    if (!settled(scene)) html += section(scene, page.rule);
  html += "<section><details><summary>" + std::to_string(count(settled)) +
          " scenes as blessed, picture and state</summary><div class=\"small\">";
  for (const ReportScene& scene : page.scenes)
    if (settled(scene)) html += figure(picture(scene.actual, scene.name), scene.name + ": " + scene.about);
  html +=
      std::string("</div></details></section></main><script>") + kReportScript + "</script></body></html>\n";
  return html;
}

}  // namespace skerry::render
