// JPEG pictures by libjpeg (of libjpeg-turbo): into pixels, out of pixels, and what a frame of
// motion JPEG lacks to be a picture of its own.
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

// Of its frame header. Nothing: it is no JPEG, or cut off before.
std::optional<PictureSize> jpeg_size(std::span<const std::byte> jpeg);

enum class Pixels8 : std::uint8_t { kGrey, kRgb, kYuv444 };

// Whole lines, without gaps between them.
struct PixelView {
  Pixels8 format = Pixels8::kGrey;
  PictureSize size{};
  std::span<const std::byte> bytes{};
};

// Not for several threads. A broken picture gives an error, never more.
class Jpeg {
 public:
  Jpeg();
  Jpeg(const Jpeg&) = delete;
  Jpeg& operator=(const Jpeg&) = delete;
  ~Jpeg();

  // `pixels` becomes as long as is needed; no more than `bytes_max`.
  tims::Result<PictureSize> decode(std::span<const std::byte> jpeg, Pixels8 format,
                                   std::size_t bytes_max, std::vector<std::byte>& pixels);
  // quality: 1 to 100.
  tims::Result<void> encode(const PixelView& picture, int quality, std::size_t bytes_max,
                            std::vector<std::byte>& jpeg);
  // With the Huffman tables that motion JPEG leaves out, because they are always the same; without
  // what some cameras send behind the end of the picture. False: it is no picture.
  bool complete(std::span<const std::byte> frame, std::vector<std::byte>& jpeg) const;

 private:
  struct Library;

  std::unique_ptr<Library> library_;
  std::vector<std::byte> tables_;  // the usual Huffman tables, as segments
};

}  // namespace rack::device
