// Any bytes as a datagram of another router, as the frames of a datagram, and as a stream of
// datagrams.
#include <vector>

#include "router/link/datagram.h"
#include "router/link/datagram_stream.h"
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

// What arrived, with the sizes, and whether more is understood.
std::vector<std::byte> read_stream(std::vector<std::byte> bytes, std::size_t step) {
  link::DatagramStream stream;
  std::vector<std::byte> arrived;
  const auto keep = [&](std::span<std::byte> datagram) {
    fuzz::require(!datagram.empty() && datagram.size() <= link::kDatagramMax);
    link::DatagramStream::put(datagram, arrived);
  };
  bool goes_on = true;
  for (std::span<std::byte> rest = bytes; !rest.empty() && goes_on;) {
    const auto part = rest.first(std::min(step, rest.size()));
    rest = rest.subspan(part.size());
    goes_on = stream.feed(part, keep);
  }
  arrived.push_back(std::byte{goes_on});
  return arrived;
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
  const auto whole = read_stream(bytes, bytes.size());
  fuzz::require(std::equal(whole.begin(), whole.end() - 1, bytes.begin()));
  for (const std::size_t step : {1, 3, 1000}) fuzz::require(read_stream(bytes, step) == whole);
  return 0;
}
