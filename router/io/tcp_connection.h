// One client of the TCP port.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "os/file.h"
#include "router/core/ids.h"
#include "router/core/statistics.h"
#include "router/io/tcp_output.h"
#include "router/io/watch.h"
#include "wire/tcp_protocol.h"

namespace tims::io {

struct TcpConnection {
  TcpConnection(os::File socket, std::uint32_t message_max, core::BlockPool& pool,
                std::uint64_t queue_bytes_max, const core::PriorityClasses& classes);

  // Reads what is there, at most `scratch` and the rest of a large message. The bytes that are not
  // yet in the reader come back as a part of `scratch`.
  enum class ReadStatus : std::uint8_t { kSome, kNothing, kClosed, kLost };
  struct Read {
    ReadStatus status;
    std::span<std::byte> chunk;
  };
  Read read(std::span<std::byte> scratch);

  os::File socket;
  std::optional<Watch> watch;
  wire::StreamReader reader;
  TcpOutput output;
  core::ClientId id{};
  std::uint32_t token = 0;
  bool touched = false;  // the port must look at it when it flushes
  bool closing = false;  // the router knows it no more; goes with the next flush
};

}  // namespace tims::io
