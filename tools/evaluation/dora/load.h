// Network load while Dora drives: a stream of camera pictures of 1 MiB and a recording by
// DatalogRec, both sent to the base. The robot files contain both components; they are off by
// default.
#pragma once

#include "tims/session.h"
#include "tools/evaluation/dora/subscriptions.h"

namespace rack::dora {

class Load {
 public:
  // Starts the load. Throws timsctl::Failure with the reason if a component cannot be started.
  explicit Load(Subscriptions& base);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  // Takes the pictures that have arrived. Call it repeatedly.
  void keep();
  // Stops the load.
  void end();

  [[nodiscard]] std::size_t pictures() const { return pictures_; }
  // Received pictures divided by the pictures that the camera took in that time.
  [[nodiscard]] double share() const;
  [[nodiscard]] std::size_t picture_bytes() const { return picture_bytes_; }
  // The number of recorded data sets.
  [[nodiscard]] std::size_t recorded() const { return recorded_; }
  [[nodiscard]] Duration length() const { return length_; }

 private:
  void begin();
  void remove_files() const;

  Subscriptions& base_;
  tims::Mailbox stream_;
  Time began_{};
  Duration length_{};
  std::size_t pictures_ = 0;
  std::size_t picture_bytes_ = 0;
  std::size_t recorded_ = 0;
};

}  // namespace rack::dora
