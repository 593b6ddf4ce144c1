// Streams of devices and their decoders: the bytes that each emulator sends in its dialogue with
// the driver over a line with its rate.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "tims/time.h"

namespace tims::bench {

// Bytes that arrived together: a part of a stream, a datagram, a frame.
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
  // Decodes the whole stream with times shifted by `later`. Returns the number of data sets, as a
  // driver would publish them.
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
