// What devices send, and what makes data of it: a stream for each decoder, as its emulator talks
// with its driver's dialogue over a line with its rate.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "tims/time.h"

namespace tims::bench {

// Bytes that came at once: some of a stream, a datagram, a frame.
struct Piece {
  std::size_t size = 0;
  std::uint32_t id = 0;
  Time first{};
  Time last{};
};

struct DeviceStream {
  std::vector<std::byte> bytes{};
  std::vector<Piece> pieces{};
};

class Decoder {
 public:
  virtual ~Decoder() = default;
  // The whole stream, `later` than it came. Returns how many data sets, as a driver would publish
  // them, it was.
  virtual std::size_t decode(const DeviceStream& stream, Duration later) = 0;
};

struct Prepared {
  DeviceStream stream{};
  std::unique_ptr<Decoder> decoder{};
};

struct DecoderCase {
  std::string_view name;
  double target;  // MB/s
  Prepared (*prepare)();
};

std::span<const DecoderCase> decoder_cases();

}  // namespace tims::bench
