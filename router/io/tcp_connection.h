// One client of the TCP port.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <boost/asio/posix/stream_descriptor.hpp>

#include "os/file.h"
#include "router/core/event.h"
#include "router/core/ids.h"
#include "router/io/tcp_output.h"
#include "wire/stream_reader.h"

namespace tims::io {

struct TcpConnection {
  TcpConnection(boost::asio::io_context& loop, os::File socket, std::uint32_t message_max,
                core::BlockPool& pool, std::uint64_t queue_bytes_max);
  TcpConnection(const TcpConnection&) = delete;
  TcpConnection& operator=(const TcpConnection&) = delete;
  ~TcpConnection();

  // Reads what is there, at most `scratch` and the rest of a large message. The bytes that are not
  // yet in the reader come back as a part of `scratch`.
  enum class ReadStatus : std::uint8_t { kSome, kNothing, kClosed, kLost };
  struct Read {
    ReadStatus status;
    std::span<std::byte> chunk;
  };
  Read read(std::span<std::byte> scratch);

  os::File file;
  boost::asio::posix::stream_descriptor socket;  // waits for `file`, which closes it
  wire::StreamReader reader;
  TcpOutput output;
  core::ClientId id{};
  std::uint32_t token = 0;
  bool touched = false;  // the port must look at it when it flushes
  bool waits_for_writable = false;
  bool closing = false;  // the router knows it no more; goes with the next flush
};

}  // namespace tims::io
