// A message that owns its body, and how one is shown to people.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tims/message.h"

namespace tims::test {

struct OwnedMessage {
  Header header;
  std::vector<std::byte> body;

  [[nodiscard]] MessageView view() const { return {header, body}; }
};

OwnedMessage copy_of(const MessageView& message);

// As it goes over a connection, in the machine's own order; the length is that of the body.
std::vector<std::byte> bytes_of(Header header, std::span<const std::byte> body = {});

// "type 3 prio 0 seq 5 flags 00 GUI(0/1) -> Ladar(0/0), 18 bytes, body 0a0b"; long bodies are cut.
std::string describe(const MessageView& message);

// dest = src = 0: between a client and its router.
inline bool is_router_message(const Header& h) { return h.dest == Address() && h.src == Address(); }
bool is_lifesign(const Header& header);

}  // namespace tims::test
