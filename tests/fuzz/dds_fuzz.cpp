// Any bytes as the announcement of another DDS participant, and as a sample it wrote.
#include <vector>

#include "router/link/datagram.h"
#include "router/link/transport.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;

// A decoded announcement is encoded in a form that decodes to the same values.
void announce(std::span<const std::byte> bytes) {
  const auto announcement = link::decode_announcement(bytes);
  if (!announcement) return;
  fuzz::require(link::encode(*announcement).size() <= link::kAnnouncementBytesMax);
  fuzz::require(link::decode_announcement(link::encode(*announcement)) == announcement);
}

// The datagrams are contiguous and cover the sample except its padding.
void unpack(std::span<std::byte> bytes) {
  const link::Batch batch(bytes);
  if (!batch.valid()) return;
  const std::byte* end = bytes.data();
  batch.for_each([&](std::span<std::byte> datagram) {
    fuzz::require(!datagram.empty() && datagram.data() == end + link::kBatchSizeBytes);
    end = datagram.data() + datagram.size();
  });
  fuzz::require(end + 3 >= bytes.data() + bytes.size() && end > bytes.data());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  std::vector<std::byte> bytes(input.begin(), input.end());
  announce(bytes);
  unpack(bytes);
  return 0;
}
