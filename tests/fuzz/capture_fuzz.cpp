// Recordings and device addresses: a parsed line is written in a form that yields the same values
// when parsed again; the statistics accept all of them. Packets of all links.
#include <array>
#include <span>
#include <string>

#include "components/devices/core/packet.h"
#include "components/recordings/capture_statistics.h"
#include "rack/devices/device_address.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using rack::device::CaptureRecord;
using rack::device::Direction;

void read_back(const CaptureRecord& record) {
  std::string line;
  if (record.direction == Direction::kEvent)
    rack::device::append_event(line, record.time, record.event);
  else
    append_record(line, record.time, record.direction, record.id, record.bytes);
  tims::fuzz::require(line.ends_with('\n'));
  line.pop_back();
  tims::fuzz::require(line.find('\n') == std::string::npos);
  CaptureRecord again;
  const auto parsed = rack::device::parse_record(line, again);
  tims::fuzz::require(parsed && *parsed && again.time == record.time && again.id == record.id &&
                      again.direction == record.direction && again.bytes == record.bytes);
}

void check_address(std::string_view text) {
  const auto address = rack::device::DeviceAddress::parse(text);
  if (!address) return;
  const auto again = rack::device::DeviceAddress::parse(address->to_string());
  tims::fuzz::require(again && *again == *address);
}

// The first byte selects the link; packets follow, each after its length.
void read_packets(std::span<const std::byte> bytes) {
  constexpr std::array kTypes = {0, 1, 101, 108, 113, 228, 229, 276};
  if (bytes.empty()) return;
  const auto type = kTypes[std::to_integer<std::size_t>(bytes[0]) % kTypes.size()];
  rack::device::PacketReader reader(*rack::device::packet_link(type));
  rack::device::StreamOrder order;
  bytes = bytes.subspan(1);
  while (!bytes.empty()) {
    const auto size = std::min(std::to_integer<std::size_t>(bytes[0]), bytes.size() - 1);
    if (const auto payload = reader.take(bytes.subspan(1, size)); payload) {
      tims::fuzz::require(payload->bytes.size() <= 65535);
      const auto fresh = payload->is_tcp ? order.take(*payload) : payload->bytes;
      tims::fuzz::require(fresh.size() <= payload->bytes.size());
    }
    bytes = bytes.subspan(1 + size);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  read_packets(std::as_bytes(std::span(rest)));
  tims::fuzz::use(rack::device::format_of(std::as_bytes(std::span(rest))));
  rack::device::CaptureStatistics statistics;
  CaptureRecord record;
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    check_address(line);
    const auto parsed = rack::device::parse_record(line, record);
    if (!parsed || !*parsed) continue;
    statistics.add(record);
    read_back(record);
  }
  tims::fuzz::require(statistics.duration() >= rack::device::Duration(0));
  return 0;
}
