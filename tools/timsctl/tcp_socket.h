// A TCP connection whose every wait has an end.
#pragma once

#include <cstddef>
#include <span>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"
#include "tools/timsctl/host.h"

namespace timsctl {

class TcpSocket {
 public:
  // Each address of the name in turn. Throws Failure.
  static TcpSocket connect(const TcpHost& host, tims::Duration timeout);

  [[nodiscard]] int descriptor() const { return file_.get(); }
  tims::Result<void> write_all(std::span<const std::byte> bytes, tims::Time deadline);
  // kEmpty: nothing there. kClosed: the other side has gone.
  tims::Result<std::size_t> read_some(std::span<std::byte> buffer);
  // Until there is something to read; false at the deadline.
  [[nodiscard]] bool wait_readable(tims::Time deadline) const;

 private:
  explicit TcpSocket(tims::os::File file) : file_(std::move(file)) {}
  tims::os::File file_;
};

}  // namespace timsctl
