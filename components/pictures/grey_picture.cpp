#include "components/pictures/grey_picture.h"

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/text.h"
#include "components/pictures/opencv_call.h"

namespace rack::pictures {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1A\n\0\0\0\rIHDR", 16);
constexpr std::string_view kPgmBlank = " \t\r\n\f\v";

tims::Error malformed(std::string what) { return {tims::Errc::kMalformed, std::move(what)}; }

struct GreyHeader {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t white = 0;  // 0: given by the depth of the decoded pixels
  bool is_text = false;
};

// The header of a PGM file: tokens, with comments between them.
class PgmHeader {
 public:
  explicit PgmHeader(std::string_view bytes) : left_(bytes) {}

  std::string_view token() {
    for (;;) {
      const auto first = left_.find_first_not_of(kPgmBlank);
      left_.remove_prefix(std::min(first, left_.size()));
      if (!left_.starts_with('#')) break;
      left_.remove_prefix(std::min(left_.find('\n'), left_.size()));
    }
    const std::string_view found = left_.substr(0, left_.find_first_of(kPgmBlank));
    left_.remove_prefix(found.size());
    return found;
  }
  std::int64_t number() { return tims::base::parse_number<std::int32_t>(token()).value_or(-1); }

 private:
  std::string_view left_;
};

std::int64_t big_endian(std::string_view bytes) {
  std::int64_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<unsigned char>(byte);
  return number;
}

tims::Result<GreyHeader> header_of(std::string_view bytes) {
  if (bytes.starts_with(kPngSignature)) {
    if (bytes.size() < 24) return malformed("the PNG picture ends in its header");
    return GreyHeader{.width = big_endian(bytes.substr(16, 4)),
                      .height = big_endian(bytes.substr(20, 4))};
  }
  PgmHeader reader(bytes);
  const std::string_view kind = reader.token();
  if (kind != "P5" && kind != "P2") return malformed("neither a PGM (P5, P2) nor a PNG picture");
  GreyHeader header{.is_text = kind == "P2"};
  header.width = reader.number();
  header.height = reader.number();
  header.white = reader.number();
  if (header.white <= 0 || header.white > 65535)
    return malformed("the maximum value of the PGM picture is not 1 to 65535");
  return header;
}

tims::Result<void> check_size(const GreyHeader& header, std::size_t bytes) {
  if (header.width <= 0 || header.height <= 0) return malformed("the picture has no valid size");
  constexpr std::int64_t kSideMax = 1 << 20;  // OpenCV's limit
  if (header.width > kSideMax || header.height > kSideMax ||
      header.width * header.height > kGreyPixelsMax)
    return malformed("the picture has more than " + std::to_string(kGreyPixelsMax) +
                     " pixels: crop it, or reduce its resolution");
  // A pixel of a PGM needs a byte or two, as text a digit and a blank.
  const auto pixels = static_cast<std::size_t>(header.width * header.height);
  const std::size_t of_pixel = header.is_text || header.white > 255 ? 2 : 1;
  if (header.white > 0 && bytes + 1 < pixels * of_pixel)
    return malformed("the picture ends before its last row");
  return {};
}

// OpenCV stretches the numbers of a text of up to 255 to 0 to 255, rounded down.
std::uint16_t unstretched(std::uint16_t value, std::uint16_t white) {
  return static_cast<std::uint16_t>((value * white + 254) / 255);
}

tims::Result<void> check_for_writing(const GreyPicture& picture) {
  const std::int64_t pixels = static_cast<std::int64_t>(picture.width) * picture.height;
  const auto invalid = [](const char* what) {
    return tims::Error(tims::Errc::kInvalidArgument, what);
  };
  if (picture.width <= 0 || picture.height <= 0) return invalid("the picture has no valid size");
  if (pixels > kGreyPixelsMax || std::max(picture.width, picture.height) > kGreySideMax)
    return tims::Error(tims::Errc::kTooBig, "the picture has more than " +
                                                std::to_string(kGreyPixelsMax) + " pixels, or " +
                                                std::to_string(kGreySideMax) +
                                                " on a side: use larger cells");
  if (picture.values.size() != static_cast<std::size_t>(pixels))
    return invalid("the picture does not have one value for each pixel");
  if (picture.white != 255 && picture.white != 65535)
    return invalid("white is not 255 or 65535, as in files");
  if (*std::ranges::max_element(picture.values) > picture.white)
    return invalid("a value of the picture is above white");
  return {};
}

}  // namespace

tims::Result<std::string> write_grey(const GreyPicture& picture, GreyFormat format) {
  if (auto good = check_for_writing(picture); !good) return good.error();
  std::vector<unsigned char> bytes;
  auto done = call_opencv("the picture cannot be encoded", [&] {
    const cv::Mat values(picture.height, picture.width, CV_16U,
                         const_cast<std::uint16_t*>(picture.values.data()));
    cv::Mat pixels;
    values.convertTo(pixels, picture.white == 255 ? CV_8U : CV_16U);
    if (!cv::imencode(format == GreyFormat::kPng ? ".png" : ".pgm", pixels, bytes)) bytes.clear();
  });
  if (!done) return done.error();
  if (bytes.empty()) return malformed("the picture cannot be encoded");
  return std::string(bytes.begin(), bytes.end());
}

tims::Result<GreyPicture> read_grey(std::string_view bytes) {
  const auto header = header_of(bytes);
  if (!header) return header.error();
  if (auto good = check_size(*header, bytes.size()); !good) return good.error();
  std::string text;
  if (header->is_text) {  // OpenCV expects a byte after the last number
    text.reserve(bytes.size() + 1);
    text.append(bytes).push_back('\n');
    bytes = text;
  }
  const cv::Mat source(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  GreyPicture picture{.width = static_cast<std::int32_t>(header->width),
                      .height = static_cast<std::int32_t>(header->height)};
  picture.values.resize(static_cast<std::size_t>(header->width * header->height));
  cv::Mat values(picture.height, picture.width, CV_16U, picture.values.data());
  bool is_decoded = false;
  auto done = call_opencv("the picture cannot be decoded", [&] {
    const cv::Mat decoded = cv::imdecode(source, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
    is_decoded = decoded.size() == values.size();
    if (!is_decoded) return;
    picture.white = decoded.depth() == CV_16U ? 65535 : 255;
    decoded.convertTo(values, CV_16U);
  });
  if (!done) return done.error();
  if (!is_decoded) return malformed("the picture is damaged, or ends before its last row");
  if (header->white > 0) {
    const bool is_stretched = header->is_text && header->white <= 255;
    picture.white = static_cast<std::uint16_t>(header->white);
    if (is_stretched)
      for (std::uint16_t& value : picture.values) value = unstretched(value, picture.white);
  }
  return picture;
}

}  // namespace rack::pictures

extern "C" [[gnu::visibility("default")]] void rack_read_grey(
    const std::string_view& bytes, tims::Result<rack::pictures::GreyPicture>& picture) {
  picture = rack::pictures::read_grey(bytes);
}

static_assert(std::is_same_v<decltype(&rack_read_grey), rack::pictures::ReadGrey>);
