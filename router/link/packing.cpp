#include "router/link/packing.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "router/link/datagram.h"
#include "wire/header.h"

namespace tims::link {
namespace {

std::uint8_t bit_of(compression::Method method) {
  return static_cast<std::uint8_t>(1U << static_cast<unsigned>(method));
}

// The part of a compressed message between its header and the compressed bytes.
struct Head {
  compression::Recipe recipe{};
  std::uint32_t size = 0;
};

void put(std::span<std::byte> bytes, const Head& head) {
  compression::encode(head.recipe, bytes.first<compression::kRecipeSize>());
  ByteWriter out(bytes.subspan(compression::kRecipeSize));
  out.put(std::uint16_t{0}, head.size);
}

std::optional<Head> get_head(std::span<const std::byte> message) {
  if (message.size() <= Packing::kHeadSize) return std::nullopt;
  const auto bytes = message.subspan(kHeaderSize);
  const auto recipe = compression::decode_recipe(bytes.first<compression::kRecipeSize>());
  ByteReader in(bytes.subspan(compression::kRecipeSize));
  (void)in.get<std::uint16_t>();
  const auto size = in.get<std::uint32_t>();
  if (!recipe) return std::nullopt;
  return Head{*recipe, size};
}

}  // namespace

std::optional<compression::Method> method_for(core::Compression wanted, std::uint8_t codecs,
                                              std::uint64_t bytes_per_s) {
  using core::Compression;
  if (wanted == Compression::kAuto) {
    if (bytes_per_s >= kRateWithout) return std::nullopt;
    wanted = bytes_per_s >= kRateLz4 ? Compression::kLz4 : Compression::kZstd;
  }
  if (wanted == Compression::kOff) return std::nullopt;
  const auto method =
      wanted == Compression::kLz4 ? compression::Method::kLz4 : compression::Method::kZstd;
  return (codecs & bit_of(method)) != 0 ? std::optional(method) : std::nullopt;
}

Packing::Packing(const AddressWidths& widths, const core::PriorityClasses& classes, Clock clock)
    : widths_(widths),
      classes_(classes),
      clock_(clock),
      plain_(std::make_unique_for_overwrite<std::byte[]>(compression::kBlockMax)),
      packed_(std::make_unique_for_overwrite<std::byte[]>(kHeadSize + compression::kBlockMax)),
      streams_(kStreams) {}

bool Packing::may_pack(const Header& header) const {
  const bool data = header.type == type::kData || header.type == type::kContData;
  return data && header.dest != classes_.texts && classes_.of(header) <= kClassMax;
}

Packing::Stream& Packing::stream_of(const Header& header, compression::Method method,
                                    std::span<const std::byte> body) {
  const std::uint32_t key = header.src.raw() * 2 + (header.type == type::kData ? 1U : 0U);
  const std::size_t hash = (key * 0x9E3779B1U >> 16) * 2 + static_cast<std::size_t>(method);
  Stream& stream = streams_[hash % kStreams];
  if (stream.known && stream.src == header.src && stream.type == header.type &&
      stream.method == method)
    return stream;
  const std::uint32_t class_id = header.src.fields(widths_).class_id;
  stream = {.src = header.src,
            .type = header.type,
            .method = method,
            .known = true,
            .own_class = class_name(class_id).empty(),
            .stride = static_cast<std::uint8_t>(compression::find_stride(body)),
            .ratio = kRatioMin};
  return stream;
}

std::optional<core::Message> Packing::pack(const core::Message& message, compression::Method method,
                                           const PackingSettings& settings,
                                           PackingCounters& counters) {
  const auto body = message.body();
  if (message.bytes.size() < kMessageMin || body.size() > compression::kBlockMax ||
      !may_pack(message.header))
    return std::nullopt;
  Stream& stream = stream_of(message.header, method, body);
  if (stream.own_class && !settings.own_classes) return std::nullopt;
  if (stream.ratio < kRatioMin && ++stream.skipped < kTriedAgainAfter) return std::nullopt;
  const Time begin = now();
  const bool is_there = is_last(message, method);
  const bool gains = is_there || compress(message, stream);
  counters.spent += now() - begin;
  if (!gains) {
    ++counters.incompressible;
    return std::nullopt;
  }
  ++counters.packed;
  counters.reused += is_there ? 1 : 0;
  counters.bytes_before += message.bytes.size();
  counters.bytes_after += last_.total;
  core::Message packed = message;
  packed.packed = true;
  packed.header.length = static_cast<std::uint32_t>(last_.total);
  packed.bytes = std::span(packed_.get(), last_.total);
  wire::encode_header(packed.header, packed.bytes.first<kHeaderSize>());
  return packed;
}

bool Packing::is_last(const core::Message& message, compression::Method method) const {
  const auto body = message.body();
  return last_.plain == body.size() && last_.src == message.header.src &&
         last_.type == message.header.type && last_.method == method &&
         std::memcmp(plain_.get(), body.data(), body.size()) == 0;
}

// Returns false when nothing is gained. Otherwise it is in packed_, except for its header.
bool Packing::compress(const core::Message& message, Stream& stream) {
  const auto body = message.body();
  // A message that did not gain may have been the first one of something else.
  if (std::exchange(stream.skipped, 0) != 0)
    stream.stride = static_cast<std::uint8_t>(compression::find_stride(body));
  const compression::Recipe recipe = compression::recipe_for(stream.method, stream.stride);
  const std::span room = std::span(packed_.get() + kHeadSize, message.bytes.size() - kHeadSize);
  const std::size_t size = codec_.compress(recipe, body, room);
  const std::size_t total = size == 0 ? message.bytes.size() : kHeadSize + size;
  const auto ratio = static_cast<std::uint32_t>(message.bytes.size() * 1000 / total);
  stream.ratio = stream.ratio < kRatioMin ? ratio : (7 * stream.ratio + ratio) / 8;
  last_ = {};
  if (size == 0) return false;
  put(std::span(packed_.get(), kHeadSize).subspan(kHeaderSize),
      {.recipe = recipe, .size = static_cast<std::uint32_t>(message.bytes.size())});
  std::ranges::copy(body, plain_.get());
  last_ = {.src = message.header.src,
           .type = message.header.type,
           .method = stream.method,
           .plain = body.size(),
           .total = total};
  return true;
}

std::optional<std::uint32_t> Packing::unpacked_size(const core::Message& packed) const {
  const auto head = get_head(packed.bytes);
  if (!head || !may_pack(packed.header)) return std::nullopt;
  const std::size_t compressed = packed.bytes.size() - kHeadSize;
  if (head->size <= kHeaderSize || head->size - kHeaderSize > compression::kBlockMax ||
      head->size - kHeaderSize > compressed * compression::kRatioMax)
    return std::nullopt;
  return head->size;
}

std::uint8_t Packing::codec_of(const core::Message& packed) {
  const auto head = get_head(packed.bytes);
  return head ? bit_of(head->recipe.method) : std::uint8_t{0};
}

bool Packing::unpack(core::Message& message, std::span<std::byte> to, PackingCounters& counters) {
  const Time begin = now();
  const auto head = get_head(message.bytes);
  const bool good =
      head && to.size() == head->size && to.size() > kHeaderSize &&
      codec_.decompress(head->recipe, message.bytes.subspan(kHeadSize), to.subspan(kHeaderSize));
  counters.spent += now() - begin;
  if (!good) {
    ++counters.broken;
    return false;
  }
  ++counters.unpacked;
  counters.bytes_unpacked += to.size();
  message.packed = false;
  message.header.length = static_cast<std::uint32_t>(to.size());
  message.bytes = to;
  wire::encode_header(message.header, to.first<kHeaderSize>());
  return true;
}

}  // namespace tims::link
