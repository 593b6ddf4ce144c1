// A message that owns its body, and its description as text.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "client/tcp_client.h"
#include "tims/message.h"

namespace tims::test {

using OwnedMessage = client::Message;
using wire::is_router_message;

OwnedMessage copy_of(const MessageView& message);

// The bytes on a connection, in the machine's byte order; the length is set from the body.
std::vector<std::byte> bytes_of(Header header, std::span<const std::byte> body = {});

// "type 3 prio 0 seq 5 flags 00 GUI(0/1) -> Ladar(0/0), 18 bytes, body 0a0b"; long bodies are
// truncated.
std::string describe(const MessageView& message);

// A body that is a text without terminator.
inline std::string text_of(std::span<const std::byte> body) {
  return {reinterpret_cast<const char*>(body.data()), body.size()};
}

bool is_lifesign(const Header& header);

}  // namespace tims::test
