// What became of messages to mailboxes in shared memory, whoever sent them.
#pragma once

#include <cstdint>

namespace tims::io {

struct MailboxCounts {
  std::uint64_t received = 0;
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;
  std::uint64_t too_big = 0;
  std::uint64_t reclaimed = 0;

  MailboxCounts& operator+=(const MailboxCounts& more) {
    received += more.received;
    replaced += more.replaced;
    refused += more.refused;
    too_big += more.too_big;
    reclaimed += more.reclaimed;
    return *this;
  }
};

}  // namespace tims::io
