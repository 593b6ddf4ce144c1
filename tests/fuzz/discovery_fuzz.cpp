// Any bytes as messages of DDS discovery, decoded and filtered.
#include "router/io/dds/discovery_filter.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;

// All views are within the message; a submessage for one receiver has the same sender.
void parse(std::span<const std::byte> bytes) {
  const auto message = io::parse_rtps(bytes);
  fuzz::require(message.has_value() == io::rtps_sender(bytes).has_value());
  if (!message) return;
  fuzz::require(message->from == *io::rtps_sender(bytes));
  if (message->announced && !message->announced->user_data.empty()) {
    const auto text = message->announced->user_data;
    fuzz::require(text.data() >= bytes.data() &&
                  text.data() + text.size() <= bytes.data() + bytes.size());
  }
  const auto again = io::parse_rtps(io::directed(bytes, {7}));
  fuzz::require(again && again->from == message->from && again->to.has_value());
}

// The filter passes only messages of participants that have announced themselves.
void filter(std::span<const std::byte> bytes) {
  io::DiscoveryFilter filter({.fleet = std::string_view("harbour"), .identity = {.epoch = 1}});
  const Time start{};
  bool announced = false;
  for (const bool multicast : {true, false, true}) {
    const io::DiscoveryFilter::Verdict verdict = filter.on_message(start, bytes, multicast);
    announced = announced || verdict.announced;
    fuzz::require(announced || (!verdict.passes && verdict.first.empty()));
    if (const auto from = io::rtps_sender(bytes)) (void)filter.admit(*from);
  }
  fuzz::require(filter.expire(start + std::chrono::hours(1'000'000)).size() <= 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  parse(bytes);
  filter(bytes);
  return 0;
}
