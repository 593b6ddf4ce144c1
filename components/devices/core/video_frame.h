// The data of a camera: a header that describes the layout of the frames, then one frame per
// arrival, whose id is the pixel format. A capture of a camera can therefore be played back without
// the camera.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace rack::device {

// Four-character code of a pixel format, as in V4L2.
constexpr std::uint32_t four_letters(std::string_view text) {
  std::uint32_t code = 0;
  for (std::size_t i = 4; i-- > 0;)
    code = code << 8 | static_cast<unsigned char>(i < text.size() ? text[i] : ' ');
  return code;
}

namespace video {
inline constexpr std::uint32_t kHead = four_letters("HEAD");     // id of VideoHead
inline constexpr std::uint32_t kControl = four_letters("CTRL");  // id of VideoControl
inline constexpr std::uint32_t kMjpeg = four_letters("MJPG");
inline constexpr std::uint32_t kJpeg = four_letters("JPEG");
inline constexpr std::uint32_t kYuyv = four_letters("YUYV");
inline constexpr std::uint32_t kUyvy = four_letters("UYVY");
inline constexpr std::uint32_t kRgb24 = four_letters("RGB3");
inline constexpr std::uint32_t kBgr24 = four_letters("BGR3");
inline constexpr std::uint32_t kGrey = four_letters("GREY");
inline constexpr std::uint32_t kGrey16 = four_letters("Y16 ");
inline constexpr std::uint32_t kDepth16 = four_letters("Z16 ");
// One colour per pixel (Bayer): the colours of the first two pixels of the first two lines.
inline constexpr std::uint32_t kRggb = four_letters("RGGB");
inline constexpr std::uint32_t kGbrg = four_letters("GBRG");
inline constexpr std::uint32_t kGrbg = four_letters("GRBG");
inline constexpr std::uint32_t kBggr = four_letters("BA81");
inline constexpr std::uint32_t kRggb16 = four_letters("RG16");
inline constexpr std::uint32_t kGbrg16 = four_letters("GB16");
inline constexpr std::uint32_t kGrbg16 = four_letters("GR16");
inline constexpr std::uint32_t kBggr16 = four_letters("BYR2");
// Formats of 16 bits are little-endian, with this flag big-endian, as IIDC cameras send them.
inline constexpr std::uint32_t kBigEndian = 1U << 31U;

// Controls, numbered as in V4L2.
inline constexpr std::uint32_t kBrightness = 0x00980900;
inline constexpr std::uint32_t kAutoWhiteBalance = 0x0098090C;  // 1: by the camera
inline constexpr std::uint32_t kRedBalance = 0x0098090E;
inline constexpr std::uint32_t kBlueBalance = 0x0098090F;
inline constexpr std::uint32_t kShutter = 0x00980911;
inline constexpr std::uint32_t kAutoGain = 0x00980912;  // 1: shutter and gain by the camera
inline constexpr std::uint32_t kGain = 0x00980913;
}  // namespace video

constexpr std::string letters_of(std::uint32_t format) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>((format & ~video::kBigEndian) >> shift & 0xFF);
    text += letter >= ' ' && letter <= '~' ? letter : '?';
  }
  if ((format & video::kBigEndian) != 0) text += "-BE";
  return text;
}

inline constexpr std::size_t kVideoFields = 4;
using VideoBytes = std::array<std::byte, 4 * kVideoFields>;  // numbers of 32 bits, little-endian

struct VideoHead {
  std::uint32_t format = 0;
  std::uint32_t width = 0;  // pixels
  std::uint32_t height = 0;
  std::uint32_t line_bytes = 0;  // 0 for compressed frames

  bool operator==(const VideoHead&) const = default;
};

// A control of the camera. To set it, send the new value with its id (i32, little-endian).
struct VideoControl {
  std::uint32_t id = 0;  // V4L2_CID_BRIGHTNESS, ...
  std::int32_t min = 0;
  std::int32_t max = 0;
  std::int32_t value = 0;

  bool operator==(const VideoControl&) const = default;
};

namespace detail {
constexpr VideoBytes video_bytes(const std::array<std::uint32_t, kVideoFields>& fields) {
  VideoBytes bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes.at(i) = static_cast<std::byte>(fields.at(i / 4) >> (i % 4 * 8));
  return bytes;
}
constexpr std::optional<std::array<std::uint32_t, kVideoFields>> video_fields(
    std::span<const std::byte> bytes) {
  if (bytes.size() != sizeof(VideoBytes)) return std::nullopt;
  std::array<std::uint32_t, kVideoFields> fields{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    fields.at(i / 4) |= std::to_integer<std::uint32_t>(bytes[i]) << (i % 4 * 8);
  return fields;
}
}  // namespace detail

// The bytes that set a control, and the value they have.
constexpr std::array<std::byte, 4> control_bytes(std::int32_t value) {
  std::array<std::byte, 4> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes.at(i) = static_cast<std::byte>(static_cast<std::uint32_t>(value) >> (8 * i));
  return bytes;
}
constexpr std::optional<std::int32_t> control_value(std::span<const std::byte> bytes) {
  if (bytes.size() != 4) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes[i]);
  return static_cast<std::int32_t>(value);
}

constexpr VideoBytes bytes_of(const VideoHead& head) {
  return detail::video_bytes({head.format, head.width, head.height, head.line_bytes});
}
constexpr VideoBytes bytes_of(const VideoControl& control) {
  return detail::video_bytes({control.id, static_cast<std::uint32_t>(control.min),
                              static_cast<std::uint32_t>(control.max),
                              static_cast<std::uint32_t>(control.value)});
}
constexpr std::optional<VideoHead> video_head(std::span<const std::byte> bytes) {
  const auto fields = detail::video_fields(bytes);
  if (!fields) return std::nullopt;
  return VideoHead{fields->at(0), fields->at(1), fields->at(2), fields->at(3)};
}
constexpr std::optional<VideoControl> video_control(std::span<const std::byte> bytes) {
  const auto fields = detail::video_fields(bytes);
  if (!fields) return std::nullopt;
  return VideoControl{fields->at(0), static_cast<std::int32_t>(fields->at(1)),
                      static_cast<std::int32_t>(fields->at(2)),
                      static_cast<std::int32_t>(fields->at(3))};
}

}  // namespace rack::device
