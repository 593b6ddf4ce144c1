#include "components/pictures/jpeg_frame.h"

#include <algorithm>
#include <array>
#include <string>

namespace rack::pictures {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::byte kMark{0xFF};
constexpr std::uint8_t kStart = 0xD8;
constexpr std::uint8_t kEnd = 0xD9;
constexpr std::uint8_t kHuffman = 0xC4;
constexpr std::uint8_t kScan = 0xDA;
constexpr std::uint8_t kBaseline = 0xC0;
constexpr std::uint8_t kExtended = 0xC1;
constexpr std::uint8_t kProgressive = 0xC2;

struct Segment {
  std::uint8_t marker = 0;
  std::span<const std::byte> bytes{};  // including the marker
};

// Iterates over the segments up to and including the start of scan. A marker without a length ends
// them: a decoder would go on behind it, and find another size than ours.
class Segments {
 public:
  explicit Segments(std::span<const std::byte> jpeg) : rest_(jpeg) {
    is_jpeg_ = rest_.size() > 2 && rest_[0] == kMark && rest_[1] == std::byte{kStart};
    if (is_jpeg_) rest_ = rest_.subspan(2);
  }
  std::optional<Segment> next() {
    if (!is_jpeg_) return std::nullopt;
    while (rest_.size() > 4 && rest_[0] == kMark && rest_[1] == kMark) rest_ = rest_.subspan(1);
    if (rest_.size() < 4 || rest_[0] != kMark || !has_length(rest_[1])) return std::nullopt;
    const std::size_t size =
        (std::to_integer<std::size_t>(rest_[2]) << 8 | std::to_integer<std::size_t>(rest_[3])) + 2;
    if (size < 4 || size > rest_.size()) return std::nullopt;
    const Segment segment{std::to_integer<std::uint8_t>(rest_[1]), rest_.first(size)};
    rest_ = rest_.subspan(size);
    if (segment.marker == kScan) is_jpeg_ = false;
    return segment;
  }

 private:
  static bool has_length(std::byte marker) {
    const auto number = std::to_integer<std::uint8_t>(marker);
    return number > 0x01 && (number < 0xD0 || number > kEnd);
  }

  std::span<const std::byte> rest_;
  bool is_jpeg_;
};

// Whether the marker is any kind of frame header; some markers in their range are not.
bool is_frame_header(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != kHuffman && marker != 0xC8 && marker != 0xCC;
}

std::optional<Segment> frame_header(std::span<const std::byte> jpeg) {
  Segments segments(jpeg);
  while (const auto segment = segments.next())
    if (is_frame_header(segment->marker) && segment->bytes.size() >= 10) return segment;
  return std::nullopt;
}

std::optional<PictureSize> size_in(const Segment& header) {
  const auto number = [&](std::size_t at) {
    return std::to_integer<std::uint32_t>(header.bytes[at]) << 8 |
           std::to_integer<std::uint32_t>(header.bytes[at + 1]);
  };
  const PictureSize size{.width = number(7), .height = number(5)};
  return size.width == 0 || size.height == 0 ? std::nullopt : std::optional(size);
}

// The number of blocks of 8 x 8 values; colours have fewer than the luma.
std::size_t blocks_of(const Segment& header, PictureSize size) {
  const auto count = std::to_integer<std::size_t>(header.bytes[9]);
  if (header.bytes.size() < 10 + 3 * count) return 0;
  const auto sampling = [&](std::size_t i) { return header.bytes[10 + 3 * i + 1]; };
  const auto across = [](std::byte both) { return std::to_integer<std::size_t>(both >> 4); };
  const auto down = [](std::byte both) {
    return std::to_integer<std::size_t>(both & std::byte{15});
  };
  std::size_t across_max = 1;
  std::size_t down_max = 1;
  for (std::size_t i = 0; i < count; ++i) {
    across_max = std::max(across_max, across(sampling(i)));
    down_max = std::max(down_max, down(sampling(i)));
  }
  std::size_t blocks = 0;
  for (std::size_t i = 0; i < count; ++i)
    blocks += (size.width * across(sampling(i)) / across_max + 7) / 8 *
              ((size.height * down(sampling(i)) / down_max + 7) / 8);
  return blocks;
}

// The scans of the whole picture. Between markers there are compressed pixels, in which kMark is
// followed by 0 or by a restart marker.
int scans_of(std::span<const std::byte> jpeg) {
  int scans = 0;
  auto at = jpeg.begin();
  while ((at = std::find(at, jpeg.end(), kMark)) != jpeg.end()) {
    ++at;
    if (at != jpeg.end() && *at == std::byte{kScan}) ++scans;
  }
  return scans;
}

std::span<const std::byte>::iterator end_mark(std::span<const std::byte> frame) {
  constexpr std::array kEndMark = {kMark, std::byte{kEnd}};
  return std::find_end(frame.begin(), frame.end(), kEndMark.begin(), kEndMark.end());
}

}  // namespace

std::optional<PictureSize> jpeg_size(std::span<const std::byte> jpeg) {
  const auto header = frame_header(jpeg);
  return header ? size_in(*header) : std::nullopt;
}

Result<PictureSize> check_jpeg(std::span<const std::byte> jpeg) {
  const auto header = frame_header(jpeg);
  const auto size = header ? size_in(*header) : std::nullopt;
  if (!size) return Error(Errc::kMalformed, "invalid picture: header missing");
  const bool is_baseline = header->marker == kBaseline || header->marker == kExtended;
  if (!is_baseline && header->marker != kProgressive)
    return Error(Errc::kMalformed, "invalid picture: neither baseline nor progressive JPEG");
  const int scans = scans_of(jpeg);
  if (scans == 0 || scans > kJpegScansMax)
    return Error(Errc::kMalformed, "invalid picture: " + std::to_string(scans) +
                                       " scans, not 1 to " + std::to_string(kJpegScansMax));
  if (end_mark(jpeg) == jpeg.end())
    return Error(Errc::kMalformed, "damaged picture: its end is missing");
  // Each Huffman code has one bit at least. A block has two codes in a baseline picture, one in the
  // first scan of a progressive one.
  const std::size_t blocks = blocks_of(*header, *size);
  if (blocks == 0 || jpeg.size() * 8 < blocks * (is_baseline ? 2 : 1))
    return Error(Errc::kMalformed, "damaged picture: " + std::to_string(jpeg.size()) +
                                       " bytes cannot be " + std::to_string(size->width) + "x" +
                                       std::to_string(size->height) + " pixels");
  return *size;
}

std::vector<std::byte> huffman_tables(std::span<const std::byte> jpeg) {
  std::vector<std::byte> tables;
  Segments segments(jpeg);
  while (const auto segment = segments.next())
    if (segment->marker == kHuffman)
      tables.insert(tables.end(), segment->bytes.begin(), segment->bytes.end());
  return tables;
}

bool complete_jpeg(std::span<const std::byte> frame, std::span<const std::byte> tables,
                   std::vector<std::byte>& jpeg) {
  bool has_tables = false;
  bool has_scan = false;
  Segments segments(frame);
  while (const auto segment = segments.next()) {
    has_tables = has_tables || segment->marker == kHuffman;
    has_scan = has_scan || segment->marker == kScan;
  }
  if (!has_scan) return false;
  const auto end = end_mark(frame);  // cameras pad their buffers
  if (end == frame.end()) return false;
  frame = frame.first(static_cast<std::size_t>(end - frame.begin()) + 2);
  jpeg.assign(frame.begin(), frame.begin() + 2);
  if (!has_tables) jpeg.insert(jpeg.end(), tables.begin(), tables.end());
  jpeg.insert(jpeg.end(), frame.begin() + 2, frame.end());
  return true;
}

}  // namespace rack::pictures
