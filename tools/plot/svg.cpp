#include "tools/plot/svg.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/text.h"

namespace rack::plot {

namespace {

constexpr double kNear = 1;  // pixels

// "12.3", "12"; only forms that SVG permits.
std::string number(double value) {
  if (!std::isfinite(value)) value = 0;
  std::string text = fmt::format("{:.1f}", value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text == "-0" ? "0" : text;
}

// Limited to the range that renderers support.
double tenths(double pixels) {
  return std::isfinite(pixels) ? std::round(std::clamp(pixels, -1e5, 1e5) * 10) / 10 : 0;
}

// Escapes XML characters and replaces control characters, which XML does not permit.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : tims::base::printable(text)) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string stroke(const Pen& pen) {
  std::string text =
      fmt::format(R"(fill="none" stroke="{}" stroke-width="{}")", pen.colour, number(pen.width));
  if (!pen.dashes.empty()) text += fmt::format(R"( stroke-dasharray="{}")", pen.dashes);
  if (pen.opacity < 1) text += fmt::format(R"( stroke-opacity="{:.2f}")", pen.opacity);
  return text;
}

std::string_view name(Anchor anchor) {
  if (anchor == Anchor::kMiddle) return "middle";
  return anchor == Anchor::kEnd ? "end" : "start";
}

}  // namespace

Svg::Svg(double width, double height)
    : out_(fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" )"
                       R"(viewBox="0 0 {0} {1}" font-family="DejaVu Sans, Arial, sans-serif">)"
                       "\n",
                       number(width), number(height))) {
  Svg::area({0, 0, width, height}, "#ffffff");
}

void Svg::line(const Spot& from, const Spot& to, const Pen& pen) {
  out_ += fmt::format(R"(<path d="M{} {}L{} {}" {}/>)"
                      "\n",
                      number(from.x), number(from.y), number(to.x), number(to.y), stroke(pen));
}

// Each point is relative to the previous rounded one, in tenths of a pixel: errors do not add up.
void Svg::lines(std::span<const Spot> spots, const Pen& pen) {
  if (spots.size() < 2) return;
  std::string path;
  Spot last;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Spot spot{tenths(spots[i].x), tenths(spots[i].y)};
    const bool is_near = std::hypot(spot.x - last.x, spot.y - last.y) < kNear;
    if (i > 0 && i + 1 < spots.size() && is_near) continue;
    if (i == 0) {
      path = "M" + number(spot.x) + " " + number(spot.y) + "l";
    } else {
      const std::string down = number(spot.y - last.y);
      if (path.back() != 'l') path += ' ';
      path += number(spot.x - last.x) + (down.starts_with('-') ? "" : " ") + down;
    }
    last = spot;
  }
  out_ += fmt::format("<path d='{}' {} stroke-linejoin='round'/>\n", path, stroke(pen));
}

void Svg::frame(const Box& box, const Pen& pen) {
  out_ +=
      fmt::format(R"(<rect x="{}" y="{}" width="{}" height="{}" {}/>)"
                  "\n",
                  number(box.x), number(box.y), number(box.width), number(box.height), stroke(pen));
}

void Svg::area(const Box& box, std::string_view colour) {
  out_ += fmt::format(R"(<rect x="{}" y="{}" width="{}" height="{}" fill="{}"/>)"
                      "\n",
                      number(box.x), number(box.y), number(box.width), number(box.height), colour);
}

// A line through the middle of each run, as wide as a cell, in units of cells.
void Svg::cells(std::span<const CellRun> runs, const Spot& left_top, double cell,
                std::string_view colour) {
  std::string path = "M0 .5";
  std::int32_t x = 0;  // end of the last run
  std::int32_t y = 0;
  for (const CellRun& run : runs) {
    path += fmt::format("m{} {}h{}", run.column - x, run.row - y, run.length);
    x = run.column + run.length;
    y = run.row;
  }
  out_ += fmt::format("<path transform='matrix({2:.5g} 0 0 {2:.5g} {0:.2f} {1:.2f})' ", left_top.x,
                      left_top.y, cell);
  out_ += fmt::format("d='{}' fill='none' stroke='{}'/>\n", path, colour);
}

void Svg::dot(const Spot& at, double radius, std::string_view colour, double opacity) {
  out_ += fmt::format(R"(<circle cx="{}" cy="{}" r="{}" fill="{}" fill-opacity="{:.2f}"/>)"
                      "\n",
                      number(at.x), number(at.y), number(radius), colour, opacity);
}

void Svg::text(const Spot& at, std::string_view content, const TextStyle& style) {
  out_ += fmt::format("<text x='{}' y='{}' font-size='{}' text-anchor='{}' fill='{}'", number(at.x),
                      number(at.y), number(style.size), name(style.anchor), style.colour);
  if (style.bold) out_ += " font-weight='bold'";
  if (style.upwards)
    out_ += fmt::format(" transform='rotate(-90 {} {})'", number(at.x), number(at.y));
  out_ += fmt::format(">{}</text>\n", escaped(content));
}

void Svg::clip(const Box& box) {
  end_clip();
  ++clips_;
  clipped_ = true;
  out_ += fmt::format("<clipPath id='c{}'><rect x='{}' y='{}' width='{}' height='{}'/></clipPath>",
                      clips_, number(box.x), number(box.y), number(box.width), number(box.height));
  out_ += fmt::format("<g clip-path='url(#c{})'>\n", clips_);
}

void Svg::end_clip() {
  if (clipped_) out_ += "</g>\n";
  clipped_ = false;
}

std::string Svg::finish() && {
  end_clip();
  return std::move(out_) + "</svg>\n";
}

}  // namespace rack::plot
