// One program of this host, as the client port sees it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <boost/asio/posix/stream_descriptor.hpp>

#include "os/unix_socket.h"
#include "router/core/ids.h"
#include "router/io/local_segments.h"
#include "router/io/uplink.h"

namespace tims::io {

struct LocalClient {
  explicit LocalClient(boost::asio::io_context& loop, os::File file)
      : socket_file(std::move(file)), socket(loop), doorbell(loop) {
    socket.assign(socket_file.get());
  }
  ~LocalClient() {  // the files close themselves
    socket.release();
    if (doorbell.is_open()) doorbell.release();
  }
  LocalClient(const LocalClient&) = delete;
  LocalClient& operator=(const LocalClient&) = delete;

  os::File socket_file;
  boost::asio::posix::stream_descriptor socket;
  boost::asio::posix::stream_descriptor doorbell;  // of the uplink
  core::ClientId id;  // kNoClient until it has said hello
  std::uint32_t token = 0;
  std::uint32_t writer = 0;
  std::unordered_map<std::uint64_t, LocalSegments::SegmentId> offered;  // by its own numbers
  std::unordered_map<std::uint32_t, LocalSegments::Handle> mailboxes;   // by raw address
  std::unordered_set<LocalSegments::SegmentId> known;                   // segments it can write to
  std::unique_ptr<Uplink> uplink;
};

}  // namespace tims::io
