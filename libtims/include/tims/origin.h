// Whether a message comes from a program of this host.
//
// A program that opens the router's Unix socket has passed its permissions, and can do no more than
// its user may. Messages over TCP and WebSocket, and those of other hosts, come from anybody in the
// network. The router marks them when it delivers them into a mailbox of this host; the mark is not
// taken from the sender, and messages that a program of this host writes into a mailbox itself have
// none. A program that is connected to its router over TCP cannot tell the senders apart: all its
// messages are marked.
#pragma once

#include "tims/message.h"

namespace tims {

namespace flag {
// Bit 2 of the flags, which the original uses below its RTnet driver only.
inline constexpr std::uint8_t kForeign = 0x04;
}  // namespace flag

// True for messages over TCP or WebSocket, and from other hosts.
[[nodiscard]] constexpr bool is_foreign(const Header& header) {
  return (header.flags & flag::kForeign) != 0;
}

// The header with or without the mark.
[[nodiscard]] constexpr Header marked_foreign(Header header, bool foreign) {
  header.flags = static_cast<std::uint8_t>(foreign ? header.flags | flag::kForeign
                                                   : header.flags & ~flag::kForeign);
  return header;
}

}  // namespace tims
