#include "tests/support/message.h"

#include <algorithm>

#include "base/text.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {

OwnedMessage copy_of(const MessageView& message) {
  return {message.header, {message.body.begin(), message.body.end()}};
}

std::vector<std::byte> bytes_of(Header header, std::span<const std::byte> body) {
  header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
  std::vector<std::byte> bytes(header.length);
  wire::encode_header(header, wire::HeaderBytes(bytes.data(), kHeaderSize));
  std::ranges::copy(body, bytes.begin() + kHeaderSize);
  return bytes;
}

std::string describe(const MessageView& message) {
  constexpr std::size_t kShownMax = 24;
  const Header& h = message.header;
  const std::byte flags{h.flags};
  std::string text = "type " + std::to_string(h.type) + " prio " + std::to_string(h.priority) +
                     " seq " + std::to_string(h.seq_nr) + " flags " + base::to_hex({&flags, 1}) +
                     " " + h.src.to_string() + " -> " + h.dest.to_string() + ", " +
                     std::to_string(h.length) + " bytes";
  if (message.body.empty()) return text;
  text += ", body " + base::to_hex(message.body.first(std::min(message.body.size(), kShownMax)));
  return message.body.size() > kShownMax ? text + "..." : text;
}

bool is_lifesign(const Header& header) {
  return is_router_message(header) && header.type == wire::router_command::kLifesign;
}

}  // namespace tims::test
