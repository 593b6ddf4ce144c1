// The frames of JPEG: size, structure, and completion of motion JPEG frames to standalone pictures.
// Only markers are read: pixels stay compressed. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tims/result.h"

namespace rack::pictures {

struct PictureSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

// Reads the size from the frame header. Empty if the data are not JPEG, or truncated before it.
std::optional<PictureSize> jpeg_size(std::span<const std::byte> jpeg);

// The size of a picture that may be given to a decoder. Error kMalformed if it is truncated, has
// more than kJpegScansMax scans, fewer bytes than its size requires, or is neither baseline nor
// progressive. A decoder would take the time and the memory that the header asks for, and fill in
// what is missing.
tims::Result<PictureSize> check_jpeg(std::span<const std::byte> jpeg);

// Progressive pictures have about ten scans. Each scan may take as long as a whole picture to
// decode but needs only some bytes, so their number must be limited.
inline constexpr int kJpegScansMax = 50;

// The segments with Huffman tables of a picture.
std::vector<std::byte> huffman_tables(std::span<const std::byte> jpeg);

// Adds `tables` if the frame has none, and removes bytes after the end of the picture, which some
// cameras send. Returns false if the frame is not a picture.
bool complete_jpeg(std::span<const std::byte> frame, std::span<const std::byte> tables,
                   std::vector<std::byte>& jpeg);

}  // namespace rack::pictures
