// Any bytes as a datagram of another router, and as the frames of a datagram.
#include <vector>

#include "router/link/datagram.h"
#include "router/link/frame.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;

void walk(std::span<std::byte> frames) {
  link::FrameReader reader(frames);
  std::size_t count = 0;
  const auto inside = [&](std::span<std::byte> bytes) {
    fuzz::require(bytes.data() >= frames.data() &&
                  bytes.data() + bytes.size() <= frames.data() + frames.size());
  };
  while (const auto frame = reader.next()) {
    fuzz::require(++count <= frames.size());
    if (const auto* stream = std::get_if<link::StreamFrame>(&*frame)) inside(stream->bytes);
    if (const auto* sample = std::get_if<link::SampleFrame>(&*frame)) inside(sample->bytes);
    if (const auto* ack = std::get_if<link::Ack>(&*frame))
      fuzz::require(ack->count > 0 && ack->count <= link::Ack::kRangesMax);
  }
}

// A decoded datagram is encoded in a form that decodes to the same values.
template <typename T>
void read_back(const T& value) {
  std::array<std::byte, link::kControlDatagramMax> bytes{};
  std::array<std::byte, link::kControlDatagramMax> again{};
  const std::size_t size = encode(value, bytes);
  const auto read = link::decode(std::span(bytes).first(size));
  fuzz::require(read.has_value() && std::holds_alternative<T>(*read));
  fuzz::require(encode(std::get<T>(*read), again) == size && bytes == again);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  if (const auto carried = link::decode_data(bytes)) walk(carried->frames);
  if (const auto datagram = link::decode(bytes)) {
    if (const auto* h = std::get_if<link::Hello>(&*datagram); h != nullptr && h->version_min == 1)
      if (h->identity.epoch != 0) read_back(*h);
    if (const auto* r = std::get_if<link::Retry>(&*datagram)) read_back(*r);
    if (const auto* w = std::get_if<link::Welcome>(&*datagram)) read_back(*w);
    if (const auto* r = std::get_if<link::Refuse>(&*datagram)) read_back(*r);
    if (const auto* r = std::get_if<link::Reset>(&*datagram)) read_back(*r);
    if (const auto* h = std::get_if<link::SealedHello>(&*datagram)) read_back(*h);
  }
  walk(bytes);
  return 0;
}
