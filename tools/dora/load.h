// What is carried to the base while Dora drives: pictures of 1 MiB of her camera, and what
// DatalogRec records there. Both are of her robot files, off until somebody wants them.
//
// The camera's stream is samples: what is lost of one is not sent again, and of the 800 datagrams
// of such a picture Wi-Fi that loses 2 % loses some. So somebody asks for pictures besides, one
// after the other: answers come whole, and take all that the line has left.
#pragma once

#include <atomic>

#include "components/runtime/thread.h"
#include "tims/session.h"
#include "tools/dora/ears.h"

namespace rack::dora {

class Load {
 public:
  // At the base. Throws timsctl::Failure with what keeps them from running.
  explicit Load(Ears& base);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

  // Pictures of the stream that have come are taken.
  void keep();
  // No more from now on.
  void end();

  // Asked for, and of the stream.
  [[nodiscard]] std::size_t pictures() const { return pictures_; }
  [[nodiscard]] std::size_t streamed() const { return streamed_; }
  [[nodiscard]] std::size_t picture_bytes() const { return picture_bytes_; }
  // Data sets, of all that are recorded.
  [[nodiscard]] std::size_t recorded() const { return recorded_; }
  // How long it ran.
  [[nodiscard]] Duration length() const { return length_; }

 private:
  void begin();
  void look();
  void remove_files() const;

  Ears& base_;
  tims::Mailbox stream_;
  tims::Mailbox looks_;
  Time began_{};
  Duration length_{};
  std::size_t streamed_ = 0;
  std::atomic<std::size_t> pictures_ = 0;
  std::atomic<std::size_t> picture_bytes_ = 0;
  std::size_t recorded_ = 0;
  std::atomic<bool> ending_ = false;
  Thread looking_;
};

}  // namespace rack::dora
