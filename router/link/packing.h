// Compression of sensor data on links. Each message by itself, at the first link that gains by it;
// it travels on compressed over further links whose other router can decompress, and is
// decompressed where it leaves them. Its header stays in the clear; the body is
//
//   0 recipe u8, stride u8 | 2 0 u16 | 4 size of the message without compression u32 | 8 bytes ...
//
// Which messages: data (types DATA and CONT_DATA) of RACK's classes, of priority classes 0 to 5 and
// of 512 B to 1 MiB, whose compression has been worth it lately. Sizes show through encryption, so
// whatever may hold a secret beside something that an attacker has chosen is left alone: texts,
// commands, questions to routers and their answers, the routers' own lane.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "router/compression/codec.h"
#include "router/core/types.h"
#include "tims/time.h"

namespace tims::link {

// What a router can decompress, stated in HELLO and WELCOME: one bit for each method.
inline constexpr std::uint8_t kCodecs = 1U << static_cast<unsigned>(compression::Method::kLz4) |
                                        1U << static_cast<unsigned>(compression::Method::kZstd);

struct PackingSettings {
  core::Compression compress = core::Compression::kOff;
  bool own_classes = false;  // also data of classes that RACK does not know
  bool operator==(const PackingSettings&) const = default;
};

// What to compress with on a link to a router with these codecs, which takes so many bytes per
// second. Empty: nothing is gained.
std::optional<compression::Method> method_for(core::Compression wanted, std::uint8_t codecs,
                                              std::uint64_t bytes_per_s);
// Automatic: no compression from the first rate on, LZ4 from the second one on, zstd below. Time
// saved on the line is then more than both ends compute, even if they are slow.
inline constexpr std::uint64_t kRateWithout = 125'000'000;
inline constexpr std::uint64_t kRateLz4 = 6'250'000;

// Of one link.
struct PackingCounters {
  std::uint64_t packed = 0;  // messages sent compressed, and their sizes before and after
  std::uint64_t bytes_before = 0;
  std::uint64_t bytes_after = 0;
  std::uint64_t reused = 0;          // of these, compressed for another receiver or link before
  std::uint64_t incompressible = 0;  // tried, and sent as they are
  std::uint64_t unpacked = 0;        // messages decompressed here
  std::uint64_t bytes_unpacked = 0;  // their sizes afterwards
  std::uint64_t passed = 0;          // arrived compressed, and were sent on like that
  std::uint64_t broken = 0;          // not decompressible, or not allowed to be compressed
  Duration spent{};                  // computing time of all of these
};

class Packing {
 public:
  using Clock = Time (*)();
  static constexpr std::size_t kMessageMin = 512;
  static constexpr std::size_t kHeadSize = kHeaderSize + 8;
  static constexpr std::size_t kClassMax = 5;
  // Data of a source that gain less than kRatioMin are tried again after so many messages.
  static constexpr std::uint32_t kTriedAgainAfter = 64;
  static constexpr std::uint32_t kRatioMin = 1150;  // in 1/1000

  // `clock`: to measure computing time; null: it is not measured.
  Packing(const AddressWidths& widths, const core::PriorityClasses& classes, Clock clock = nullptr);

  // The message compressed; empty when it is to be sent as it is. The result is valid until the
  // next call. Data for several receivers come one after the other, each with its own header: they
  // are compressed once.
  std::optional<core::Message> pack(const core::Message& message, compression::Method method,
                                    const PackingSettings& settings, PackingCounters& counters);

  // The size of a compressed message without compression; empty when it is not acceptable.
  [[nodiscard]] std::optional<std::uint32_t> unpacked_size(const core::Message& packed) const;
  // The bit of kCodecs that a compressed message needs; 0 when it is damaged.
  [[nodiscard]] static std::uint8_t codec_of(const core::Message& packed);
  // `to`: unpacked_size() bytes, which become the message. Returns false when the bytes are
  // damaged.
  [[nodiscard]] bool unpack(core::Message& message, std::span<std::byte> to,
                            PackingCounters& counters);

 private:
  // What is known of the data of one source: a cell of a cache, which another source may take over.
  struct Stream {
    Address src{};
    std::int8_t type = 0;
    compression::Method method{};
    bool known = false;
    bool own_class = false;
    std::uint8_t stride = 1;
    std::uint32_t ratio = 0;    // moving average, in 1/1000
    std::uint32_t skipped = 0;  // since the last attempt
  };
  static constexpr std::size_t kStreams = 512;

  // What is in packed_, of the bytes in plain_.
  struct Last {
    Address src{};
    std::int8_t type = 0;
    compression::Method method{};
    std::size_t plain = 0;  // bytes of the body; 0: nothing
    std::size_t total = 0;  // bytes of the compressed message
  };

  Stream& stream_of(const Header& header, compression::Method method,
                    std::span<const std::byte> body);
  [[nodiscard]] bool may_pack(const Header& header) const;
  [[nodiscard]] bool is_last(const core::Message& message, compression::Method method) const;
  bool compress(const core::Message& message, Stream& stream);
  [[nodiscard]] Time now() const { return clock_ == nullptr ? Time{} : clock_(); }

  AddressWidths widths_;
  core::PriorityClasses classes_;
  Clock clock_;
  compression::Codec codec_;
  std::unique_ptr<std::byte[]> plain_;
  std::unique_ptr<std::byte[]> packed_;
  Last last_;
  std::vector<Stream> streams_;
};

}  // namespace tims::link
