// Bytes to the dialogues with range finders, in pieces of any size: none of them comes to harm, and
// what becomes a scan is a scan that can be sent.
#include <cmath>
#include <memory>

#include "devices/protocol/hokuyo.h"
#include "devices/protocol/ibeo.h"
#include "devices/protocol/ibeo_lux.h"
#include "devices/protocol/ld19.h"
#include "devices/protocol/rplidar.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace rack::device;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

void check(const rack::LadarData& scan) {
  tims::fuzz::require(scan.points.size() <= decltype(rack::LadarData::points)::kMax);
  for (const rack::LadarPoint& point : scan.points) {
    tims::fuzz::require(std::isfinite(static_cast<float>(point.angle)));
    tims::fuzz::require(point.distance >= 0);
  }
}

template <class Dialog>
void talk(Dialog dialogue, std::span<const std::byte> bytes, std::size_t piece) {
  Nobody nobody;
  Time now(std::chrono::seconds(1));
  rack::LadarData scan;
  Time recorded;
  dialogue.start(now, nobody);
  while (!bytes.empty()) {
    const auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    now += std::chrono::milliseconds(5);
    dialogue.on_arrival({.bytes = part, .first = now, .last = now, .id = 0x701}, nobody);
    while (dialogue.take(scan, recorded)) check(scan);
    if (dialogue.next_timeout() <= now) dialogue.on_timeout(now, nobody);
    if (dialogue.failure()) dialogue.start(now, nobody);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(2);
  const std::size_t piece = 1U + data[1];
  switch (data[0] % 8) {
    case 0:
      talk(Hokuyo({.only_listen = true}), bytes, piece);
      break;
    case 1:
      talk(Hokuyo({}), bytes, piece);
      break;
    case 2:
      talk(Rplidar({.only_listen = true}), bytes, piece);
      break;
    case 3:
      talk(Rplidar({}), bytes, piece);
      break;
    case 4:
      talk(Ld19({.only_listen = true}), bytes, piece);
      break;
    case 5:
      talk(Ibeo({.only_listen = true}), bytes, 8);
      break;
    case 6:
      talk(Ibeo({}), bytes, 8);
      break;
    default:
      talk(IbeoLux({}), bytes, piece);
      break;
  }
  return 0;
}
