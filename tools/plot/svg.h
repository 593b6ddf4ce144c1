// Writes SVG: lines, areas and text. Pure.
//
// Coordinates have one decimal (a tenth of a pixel). Points of a line that are less than a pixel
// from the previous one are omitted; so the picture of a drive of one hour has about 50 kB.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rack::plot {

struct Spot {
  double x = 0;  // pixels to the right
  double y = 0;  // pixels down
};

struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

struct Pen {
  std::string_view colour = "#000000";
  double width = 1;
  std::string_view dashes{};  // "6 4"; empty: none
  double opacity = 1;
};

enum class Anchor { kStart, kMiddle, kEnd };

struct TextStyle {
  double size = 14;
  Anchor anchor = Anchor::kStart;
  std::string_view colour = "#222222";
  bool upwards = false;  // rotated by 90 degrees, read from below
  bool bold = false;
};

class Svg {
 public:
  Svg(double width, double height);

  void line(const Spot& from, const Spot& to, const Pen& pen);
  void lines(std::span<const Spot> spots, const Pen& pen);
  void frame(const Box& box, const Pen& pen);
  void area(const Box& box, std::string_view colour);
  // A path in SVG syntax, drawn with width 1 and then scaled by `scale`.
  void shape(std::string_view path, const Spot& left_top, double scale, std::string_view colour);
  void dot(const Spot& at, double radius, std::string_view colour, double opacity = 1);
  void text(const Spot& at, std::string_view content, const TextStyle& look);
  // Clips the following output to the box, until the next clip() or end_clip().
  void clip(const Box& box);
  void end_clip();

  [[nodiscard]] std::string finish() &&;

 private:
  std::string out_;
  int clips_ = 0;
  bool clipped_ = false;
};

}  // namespace rack::plot
