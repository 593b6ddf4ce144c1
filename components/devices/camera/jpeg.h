// JPEG by libjpeg (libjpeg-turbo): decoding, encoding, and completion of motion JPEG frames to
// standalone pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tims/result.h"

namespace rack::device {

struct PictureSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

// Reads the size from the frame header. Empty if the data are not JPEG, or truncated before it.
std::optional<PictureSize> jpeg_size(std::span<const std::byte> jpeg);

enum class Pixels8 : std::uint8_t { kGrey, kRgb, kYuv444 };

// Contiguous lines without padding.
struct PixelView {
  Pixels8 format = Pixels8::kGrey;
  PictureSize size{};
  std::span<const std::byte> bytes{};
};

// Not thread-safe. Invalid pictures cause an error only.
class Jpeg {
 public:
  Jpeg();
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;
  ~Jpeg();

  // Resizes `pixels` as required; fails if that exceeds `bytes_max`.
  tims::Result<PictureSize> decode(std::span<const std::byte> jpeg, Pixels8 format,
                                   std::size_t bytes_max, std::vector<std::byte>& pixels);
  // quality: 1 to 100.
  tims::Result<void> encode(const PixelView& picture, int quality, std::size_t bytes_max,
                            std::vector<std::byte>& jpeg);
  // Adds the standard Huffman tables, which motion JPEG omits, and removes bytes after the end of
  // the picture, which some cameras send. Returns false if the frame is not a picture.
  bool complete(std::span<const std::byte> frame, std::vector<std::byte>& jpeg) const;

 private:
  struct Library;

  std::unique_ptr<Library> library_;
  std::vector<std::byte> tables_;  // segments with the standard Huffman tables
};

}  // namespace rack::device
