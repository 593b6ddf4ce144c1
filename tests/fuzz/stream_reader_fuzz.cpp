// The messages and the final refusal do not depend on how a stream is divided into chunks.
#include <vector>

#include "tests/fuzz/fuzz_input.h"
#include "wire/tcp_protocol.h"

namespace {

using tims::wire::StreamReader;
using Bytes = std::vector<std::byte>;

struct Story {
  std::vector<Bytes> messages;
  StreamReader::Status end = StreamReader::Status::kNeedMore;
  std::size_t pending = 0;
  bool operator==(const Story&) const = default;
};

// Takes every message from the reader; false: the stream is invalid.
bool drain(StreamReader& reader, std::span<std::byte> chunk, Story& story) {
  for (;;) {
    const StreamReader::Item item = reader.next(chunk);
    story.end = item.status;
    if (item.status != StreamReader::Status::kMessage)
      return item.status == StreamReader::Status::kNeedMore;
    tims::fuzz::require(item.message.size() == item.header.length);
    story.messages.emplace_back(item.message.begin(), item.message.end());
  }
}

// Like reading a socket: directly into the reader's buffer if it offers one, otherwise in chunks
// whose lengths are derived from `cut`.
Story read(Bytes stream, std::uint32_t length_max, std::size_t cut) {
  StreamReader reader(length_max);
  Story story;
  std::span<std::byte> left = stream;
  while (!left.empty()) {
    const auto room = reader.room();
    const std::size_t n = std::min(room.empty() ? cut : room.size(), left.size());
    Bytes chunk(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(n));
    left = left.subspan(n);
    if (!room.empty()) {
      std::ranges::copy(chunk, room.begin());
      reader.advance(n);
      chunk.clear();
    }
    if (!drain(reader, chunk, story)) break;
    cut = cut * 7 % 4093 + 1;
  }
  story.pending = reader.pending();
  return story;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tims::fuzz::Input input(data, size);
  const auto length_max = input.number<std::uint32_t>() % (1U << 17) + 16;
  const auto cut = input.number<std::uint16_t>() % std::size_t{4093} + 1;
  const auto bytes = input.rest();
  const Bytes stream(bytes.begin(), bytes.end());
  const Story whole = read(stream, length_max, stream.size() + 1);
  tims::fuzz::require(read(stream, length_max, cut) == whole);
  tims::fuzz::require(read(stream, length_max, 1) == whole);
  return 0;
}
