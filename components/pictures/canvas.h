// What a drawing is made of: lines, areas, cells of a map and text, in pixels of a picture whose
// origin is its left top corner. One drawing (tools/plot/picture.h) is drawn on any canvas: as SVG,
// or as pixels by OpenCV (raster_canvas.h). Pure.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace rack::pictures {

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
  std::string_view colour = "#000000";  // "#rrggbb"
  double width = 1;
  std::string_view dashes{};  // "6 4": lengths of dashes and gaps in turns; empty: none
  double opacity = 1;
};

enum class Anchor : std::uint8_t { kStart, kMiddle, kEnd };

struct TextStyle {
  double size = 14;
  Anchor anchor = Anchor::kStart;
  std::string_view colour = "#222222";
  bool upwards = false;  // rotated by 90 degrees, read from below
  bool bold = false;
};

// Adjacent cells of a row of a grid. Row 0 is the top one.
struct CellRun {
  std::int32_t row = 0;
  std::int32_t column = 0;
  std::int32_t length = 1;
};

class Canvas {
 public:
  Canvas() = default;
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  virtual ~Canvas() = default;

  virtual void line(const Spot& from, const Spot& to, const Pen& pen) = 0;
  virtual void lines(std::span<const Spot> spots, const Pen& pen) = 0;
  virtual void frame(const Box& box, const Pen& pen) = 0;
  virtual void area(const Box& box, std::string_view colour) = 0;
  // `cell`: side of a cell in pixels.
  virtual void cells(std::span<const CellRun> runs, const Spot& left_top, double cell,
                     std::string_view colour) = 0;
  virtual void dot(const Spot& at, double radius, std::string_view colour, double opacity) = 0;
  // `at`: on the baseline, at the anchor.
  virtual void text(const Spot& at, std::string_view content, const TextStyle& style) = 0;
  // Clips the following output to the box, until the next clip() or end_clip().
  virtual void clip(const Box& box) = 0;
  virtual void end_clip() = 0;
};

}  // namespace rack::pictures
