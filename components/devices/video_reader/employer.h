// The driver for which this process reads: the other end of its standard input (io/video_source.h).
#pragma once

#include <string_view>

#include "components/devices/io/video_source.h"
#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

class Employer {
 public:
  // Ends this process when the driver closes its end, also while a library blocks. `socket` must
  // stay open.
  explicit Employer(int socket);

  // Waits for the address of the device.
  [[nodiscard]] tims::Result<std::string> receive_address() const;
  void send(VideoNote note, std::string_view text = {});
  // For a frame that send() has reported.
  void wait_until_taken();
  // A driver that is gone ends the wait.
  void wait_until(tims::Time due);
  // Of the notes received so far. The rest of this object is only used by one thread.
  [[nodiscard]] bool is_gone();

 private:
  void take_notes(bool waits);

  int socket_;
  int not_taken_ = 0;
  bool is_gone_ = false;
};

}  // namespace rack::device
