// What is carried to the base while Dora drives: pictures of 1 MiB of her camera, and what
// DatalogRec records there. Both are of her robot files, off until somebody wants them.
#pragma once

#include "tims/session.h"
#include "tools/evaluation/dora/ears.h"

namespace rack::dora {

class Load {
 public:
  // At the base. Throws timsctl::Failure with what keeps them from running.
  explicit Load(Ears& base);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  // Pictures that have come are taken.
  void keep();
  // No more from now on.
  void end();

  [[nodiscard]] std::size_t pictures() const { return pictures_; }
  // Of all that the camera had in that time.
  [[nodiscard]] double share() const;
  [[nodiscard]] std::size_t picture_bytes() const { return picture_bytes_; }
  // Data sets, of all that are recorded.
  [[nodiscard]] std::size_t recorded() const { return recorded_; }
  // How long it ran.
  [[nodiscard]] Duration length() const { return length_; }

 private:
  void begin();
  void remove_files() const;

  Ears& base_;
  tims::Mailbox stream_;
  Time began_{};
  Duration length_{};
  std::size_t pictures_ = 0;
  std::size_t picture_bytes_ = 0;
  std::size_t recorded_ = 0;
};

}  // namespace rack::dora
