// One program of this host, as the client port sees it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "os/socket.h"
#include "os/uplink.h"
#include "router/core/ids.h"
#include "router/io/local_segments.h"
#include "router/io/watch.h"

namespace tims::io {

struct LocalClient {
  os::File socket;
  std::optional<Watch> socket_watch;
  core::ClientId id;  // kNoClient until it has said hello
  std::uint32_t token = 0;
  std::uint32_t writer = 0;
  std::unordered_map<std::uint64_t, LocalSegments::SegmentId> offered;  // by its own numbers
  std::unordered_map<std::uint32_t, LocalSegments::Handle> mailboxes;   // by raw address
  std::size_t wakers = 0;                                               // of its mailboxes
  std::unordered_set<LocalSegments::SegmentId> known;                   // segments it can write to
  std::unique_ptr<os::Uplink> uplink;
  std::optional<Watch> doorbell_watch;
  int taken_before_record = 0;  // messages, since the record or the end to be read next has come
};

}  // namespace tims::io
