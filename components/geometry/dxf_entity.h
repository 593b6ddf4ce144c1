// What dxflib does not check: the pairs of lines of which DXF consists, put together to entities,
// and whether an entity is complete and its numbers are numbers.
//
// dxflib takes a missing coordinate for 0 and text for a number, reads lines of at most 1023
// characters, allocates as many vertices as an entity announces, and writes before them when a
// bulge precedes the first one. So only entities without a fault are passed to it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack {

struct DxfGroup {
  int code = 0;
  std::string_view value{};
};

// An entity, or a variable of the header such as $INSUNITS.
struct DxfEntity {
  std::string_view type{};
  std::size_t line = 0;            // line number of its group code
  std::vector<DxfGroup> groups{};  // codes 1 to 99, and the extrusion's
  bool is_too_long = false;        // it has more groups than kGroupsMax

  // 20000 vertices with coordinates, bulge, widths and identifier.
  static constexpr std::size_t kGroupsMax = 140'000;
  static constexpr std::size_t kVerticesMax = 20'000;
  static constexpr std::size_t kValueMax = 1000;

  [[nodiscard]] std::size_t count(int code) const;
  // The value of the last group with this code; empty: there is none.
  [[nodiscard]] std::string_view value(int code) const;
  [[nodiscard]] int number(int code, int otherwise) const;  // also when it is not a number

  // Why it cannot be read; empty: there is no reason.
  [[nodiscard]] std::string fault() const;
  // As text that dxflib reads as intended.
  [[nodiscard]] std::string text() const;
};

class DxfEntities {
 public:
  explicit DxfEntities(std::string_view text) : left_(text) {}

  // Nothing: the end of the drawing. Groups before the first entity are ignored.
  tims::Result<std::optional<DxfEntity>> next();

 private:
  struct Pair {
    DxfGroup group;
    std::size_t line = 0;
  };
  tims::Result<std::optional<Pair>> next_pair();
  std::string_view take_line();

  std::string_view left_;
  std::size_t line_ = 0;
  std::optional<Pair> begun_;  // the first group of the next entity
};

}  // namespace rack
