// Views of the board from files, or from a living camera until there are enough different ones.
// Progress is printed to the standard error.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/time.h"
#include "tools/camera_calibrate/views.h"
#include "tools/cli/connection.h"

namespace rack::camera_calibrate {

struct CollectedViews {
  int width = 0;
  int height = 0;
  std::vector<View> views{};
  std::vector<std::string> without_board{};  // names of pictures
};

class CollectProgress {
 public:
  explicit CollectProgress(bool is_quiet);
  CollectProgress(const CollectProgress&) = delete;
  CollectProgress& operator=(const CollectProgress&) = delete;
  ~CollectProgress();

  // On a terminal one line is updated; elsewhere only what `is_step` is printed.
  void show(const std::string& text, bool is_step);

 private:
  bool is_quiet_;
  bool is_terminal_;
  std::string last_;
};

// Folders are searched for .png, .pgm, .jpg and .jpeg. Throws Failure: a file cannot be read, or
// has another size than the first one. Interrupted: Ctrl-C.
CollectedViews views_of_files(const std::vector<std::string>& arguments, const Board& board,
                              const timsctl::Signals& signals, CollectProgress& progress);

struct LiveCollection {
  std::string camera{};
  std::string host{};
  tims::Duration timeout{};   // for an answer
  std::size_t views = 20;     // when nothing is missing; twice as many in any case
  tims::Duration duration{};  // 0: no limit
  std::string folder{};       // where the pictures of the views are written; empty: nowhere
};
// Throws Failure: see LivingCamera; too few views in `duration`. Interrupted: Ctrl-C.
CollectedViews views_of_camera(const LiveCollection& wanted, const Board& board,
                               const timsctl::Signals& signals, CollectProgress& progress);

}  // namespace rack::camera_calibrate
