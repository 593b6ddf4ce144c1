// Any bytes as a router's announcements of its mailboxes.
#include <algorithm>
#include <vector>

#include "router/link/frame.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  const auto body = std::as_bytes(std::span(data, size));
  link::TableState state;
  fuzz::use(link::read_state(body, state));
  std::size_t addresses = 0;
  (void)link::read_addresses(body, [&](Address) { ++addresses; });
  fuzz::require(addresses <= size / 4);

  std::vector<std::pair<Address, core::Origin>> announced;
  link::ControlMessage message(link::control::kAdd);
  const bool ok = link::read_announcements(body, [&](Address address, const core::Origin& origin) {
    announced.emplace_back(address, origin);
    message.put(address, origin);
  });
  fuzz::require(announced.size() <= size / 4);
  if (!ok) return 0;
  // A decoded announcement is encoded to the same bytes.
  std::size_t n = 0;
  const auto again = message.finish().subspan(kHeaderSize);
  fuzz::require(link::read_announcements(again, [&](Address address, const core::Origin& origin) {
    fuzz::require(n < announced.size() && announced[n].first == address &&
                  announced[n].second == origin);
    ++n;
  }));
  fuzz::require(n == announced.size());
  return 0;
}
