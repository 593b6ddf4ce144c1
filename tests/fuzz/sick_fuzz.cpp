// The telegrams of a SICK scanner do not depend on how the stream is divided; every scan has no
// more points than can be sent, and a decoded CoLa scan is unchanged after encoding and decoding.
#include <vector>

#include "components/devices/scanners/cola_scan.h"
#include "components/devices/scanners/lms200.h"
#include "components/devices/scanners/sick_compact.h"
#include "components/devices/scanners/sick_s.h"
#include "tests/fuzz/finite.h"

namespace {

using namespace rack::device;
using Bytes = std::vector<std::byte>;
using Story = std::vector<Bytes>;

void check(const rack::LadarData& scan) {
  constexpr std::size_t kPointsMax = 2160;
  tims::fuzz::require(!scan.points.empty() && scan.points.size() <= kPointsMax);
  tims::fuzz::require_finite(scan);
}

// Decodes all waiting telegrams.
void drain(ColaTelegrams& telegrams, Story& story) {
  for (ColaTelegram telegram; telegrams.next(telegram);) {
    story.emplace_back(telegram.body.begin(), telegram.body.end());
    ColaScan scan;
    rack::LadarData data;
    if (!decode_cola_scan(telegram, scan)) continue;
    if (scan_of_cola(scan, {.reflector_remission = 1}, data)) check(data);
    Bytes body;
    append_cola_scan(body, telegram.dialect, scan);
    ColaScan again;
    tims::fuzz::require(decode_cola_scan({.dialect = telegram.dialect, .body = body}, again));
    tims::fuzz::require(again.channel_count == scan.channel_count);
    for (std::size_t i = 0; i < scan.channel_count; ++i)
      tims::fuzz::require(again.channels[i].values == scan.channels[i].values);
  }
}

void drain(Lms200Telegrams& telegrams, Story& story) {
  using What = Lms200Telegrams::What;
  Lms200Telegram telegram;
  for (What what = telegrams.next(telegram); what != What::kNothing;
       what = telegrams.next(telegram)) {
    story.push_back({static_cast<std::byte>(what)});
    if (what != What::kTelegram) continue;
    story.emplace_back(telegram.body.begin(), telegram.body.end());
    rack::LadarData data;
    if (decode_lms200_scan(telegram.body, data)) check(data);
  }
}

void drain(SickSTelegrams& telegrams, Story& story) {
  for (SickSTelegram telegram; telegrams.next(telegram);) {
    story.emplace_back(telegram.blocks.begin(), telegram.blocks.end());
    rack::LadarData data;
    for (const SickSDevice device : {SickSDevice::kS300, SickSDevice::kS3000})
      if (decode_sick_s_scan(telegram, device, data)) check(data);
  }
}

template <class Telegrams>
Story read(std::span<const std::byte> stream, std::size_t piece) {
  Telegrams telegrams;
  Story story;
  while (!stream.empty()) {
    const auto next = stream.first(std::min(piece, stream.size()));
    stream = stream.subspan(next.size());
    telegrams.add({.bytes = next});
    drain(telegrams, story);
  }
  return story;
}

template <class Telegrams>
void run(std::span<const std::byte> stream, std::size_t piece) {
  constexpr std::size_t kAtOnce = 1 << 11;  // the capacity of each buffer
  const Story whole = read<Telegrams>(stream, kAtOnce);
  tims::fuzz::require(read<Telegrams>(stream, piece) == whole);
  tims::fuzz::require(read<Telegrams>(stream, 1) == whole);
}

// As a datagram with a correct checksum.
void run_compact(std::span<const std::byte> stream) {
  constexpr std::size_t kCrc = 4;
  if (stream.size() < kCrc) return;
  Bytes datagram(stream.begin(), stream.end());
  const std::size_t counted = datagram.size() - kCrc;
  const std::uint32_t crc = crc32(std::span(datagram).first(counted));
  for (std::size_t i = 0; i < kCrc; ++i)
    datagram[counted + i] = static_cast<std::byte>(crc >> 8 * i);
  CompactSegment segment;
  if (decode_compact(datagram, segment) != CompactKind::kSegment) return;
  for (const CompactBeam& beam : segment.beams) tims::fuzz::require(std::isfinite(beam.azimuth));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const auto which = input.number<std::uint8_t>();
  const std::size_t piece = std::size_t{input.number<std::uint8_t>()} + 1;
  const auto stream = input.rest();
  run<ColaTelegrams>(stream, piece);
  if (which % 2 == 0) run<Lms200Telegrams>(stream, piece);
  if (which % 3 == 0) run<SickSTelegrams>(stream, piece);
  run_compact(stream);
  return 0;
}
