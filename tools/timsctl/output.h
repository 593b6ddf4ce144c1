// Where a command writes: results to stdout, remarks to stderr.
#pragma once

#include <string>
#include <string_view>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/json.h"
#include "tools/timsctl/render.h"

namespace timsctl {

class Output {
 public:
  Output(const Options& options, bool no_color);

  [[nodiscard]] const Look& look() const { return look_; }
  [[nodiscard]] bool terminal() const { return terminal_; }
  [[nodiscard]] bool json() const { return look_.format == Format::kJson; }

  // To stdout, at once. Throws Interrupted when nobody reads it any more.
  void write(std::string_view text);
  void write(const json::object& object);  // one line
  // Over what was written before, when that can be done: a display that is drawn again and again.
  void redraw(std::string_view text);

  // To stderr: remarks that -q silences, and those only -v wants to see.
  void note(std::string_view text) const;
  void detail(std::string_view text) const;
  // As JSON on stdout, or as text on stderr.
  void failure(const Failure& failure);

 private:
  Look look_;
  bool terminal_;
  bool quiet_;
  bool verbose_;
};

}  // namespace timsctl
