// Writes SVG: lines, areas and text. Pure.
//
// Coordinates have one decimal (a tenth of a pixel). Points of a line that are less than a pixel
// from the previous one are omitted; so the picture of a drive of one hour has about 50 kB.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "components/pictures/canvas.h"

namespace rack::plot {

using pictures::Anchor;
using pictures::Box;
using pictures::Canvas;
using pictures::CellRun;
using pictures::Pen;
using pictures::Spot;
using pictures::TextStyle;

class Svg : public Canvas {
 public:
  Svg(double width, double height);

  void line(const Spot& from, const Spot& to, const Pen& pen) override;
  void lines(std::span<const Spot> spots, const Pen& pen) override;
  void frame(const Box& box, const Pen& pen) override;
  void area(const Box& box, std::string_view colour) override;
  void cells(std::span<const CellRun> runs, const Spot& left_top, double cell,
             std::string_view colour) override;
  void dot(const Spot& at, double radius, std::string_view colour, double opacity) override;
  void text(const Spot& at, std::string_view content, const TextStyle& style) override;
  void clip(const Box& box) override;
  void end_clip() override;

  [[nodiscard]] std::string finish() &&;

 private:
  std::string out_;
  int clips_ = 0;
  bool clipped_ = false;
};

}  // namespace rack::plot
