#include "components/devices/camera/jpeg.h"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <string>

#include <jpeglib.h>

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::byte kMark{0xFF};
constexpr std::uint8_t kStart = 0xD8;
constexpr std::uint8_t kEnd = 0xD9;
constexpr std::uint8_t kHuffman = 0xC4;
constexpr std::uint8_t kScan = 0xDA;

struct Segment {
  std::uint8_t marker = 0;
  std::span<const std::byte> bytes{};  // including the marker
};

// Iterates over the segments up to and including the start of scan.
class Segments {
 public:
  explicit Segments(std::span<const std::byte> jpeg) : rest_(jpeg) {
    is_jpeg_ = rest_.size() > 2 && rest_[0] == kMark && rest_[1] == std::byte{kStart};
    if (is_jpeg_) rest_ = rest_.subspan(2);
  }
  std::optional<Segment> next() {
    if (!is_jpeg_) return std::nullopt;
    while (rest_.size() > 4 && rest_[0] == kMark && rest_[1] == kMark) rest_ = rest_.subspan(1);
    if (rest_.size() < 4 || rest_[0] != kMark) return std::nullopt;
    const std::size_t size =
        (std::to_integer<std::size_t>(rest_[2]) << 8 | std::to_integer<std::size_t>(rest_[3])) + 2;
    if (size < 4 || size > rest_.size()) return std::nullopt;
    const Segment segment{std::to_integer<std::uint8_t>(rest_[1]), rest_.first(size)};
    rest_ = rest_.subspan(size);
    if (segment.marker == kScan) is_jpeg_ = false;
    return segment;
  }

 private:
  std::span<const std::byte> rest_;
  bool is_jpeg_;
};

// Whether the marker is any kind of frame header; some markers in their range are not.
bool is_frame_header(std::uint8_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != kHuffman && marker != 0xC8 && marker != 0xCC;
}

J_COLOR_SPACE space_of(Pixels8 format) {
  if (format == Pixels8::kGrey) return JCS_GRAYSCALE;
  return format == Pixels8::kRgb ? JCS_RGB : JCS_YCbCr;
}
std::size_t bytes_of(Pixels8 format) { return format == Pixels8::kGrey ? 1 : 3; }

const JOCTET* octets(std::span<const std::byte> bytes) {
  return reinterpret_cast<const JOCTET*>(bytes.data());
}

}  // namespace

std::optional<PictureSize> jpeg_size(std::span<const std::byte> jpeg) {
  Segments segments(jpeg);
  while (const auto segment = segments.next()) {
    if (!is_frame_header(segment->marker) || segment->bytes.size() < 9) continue;
    const auto number = [&](std::size_t at) {
      return std::to_integer<std::uint32_t>(segment->bytes[at]) << 8 |
             std::to_integer<std::uint32_t>(segment->bytes[at + 1]);
    };
    const PictureSize size{.width = number(7), .height = number(5)};
    return size.width == 0 || size.height == 0 ? std::nullopt : std::optional(size);
  }
  return std::nullopt;
}

// libjpeg reports errors by longjmp: no object with a destructor may be created between setjmp and
// the calls of the library.
struct Jpeg::Library {
  // Progressive pictures have about ten scans. Each scan may take as long as a whole picture to
  // decode but needs only some bytes, so their number must be limited.
  static constexpr int kScansMax = 50;

  struct Errors {
    jpeg_error_mgr manager{};  // must be first: the library has a pointer to it
    std::jmp_buf back{};
    std::array<char, JMSG_LENGTH_MAX> text{};
  };
  struct Writer {
    jpeg_destination_mgr manager{};  // must be first
    std::byte* begin = nullptr;
    std::size_t size = 0;
  };

  Library() {
    decoder.err = encoder.err = ::jpeg_std_error(&errors.manager);
    errors.manager.error_exit = [](j_common_ptr library) {
      auto* const own = reinterpret_cast<Errors*>(library->err);
      own->manager.format_message(library, own->text.data());
      std::longjmp(own->back, 1);
    };
    errors.manager.emit_message = [](j_common_ptr library, int level) {
      if (level < 0) ++library->err->num_warnings;
    };
    ::jpeg_create_decompress(&decoder);
    ::jpeg_create_compress(&encoder);
    decoder.progress = &progress;
    progress.progress_monitor = [](j_common_ptr library) {
      if (reinterpret_cast<j_decompress_ptr>(library)->input_scan_number <= kScansMax) return;
      auto* const own = reinterpret_cast<Errors*>(library->err);
      std::ranges::copy("too many scans", own->text.begin());
      std::longjmp(own->back, 1);
    };
    // The buffer is complete from the start, so these callbacks have nothing to do.
    writer.manager.init_destination = [](j_compress_ptr) {};
    writer.manager.empty_output_buffer = [](j_compress_ptr library) -> boolean {
      library->err->msg_code = 0;
      library->err->error_exit(reinterpret_cast<j_common_ptr>(library));
      return FALSE;
    };
    writer.manager.term_destination = [](j_compress_ptr) {};
  }
  ~Library() {
    ::jpeg_destroy_decompress(&decoder);
    ::jpeg_destroy_compress(&encoder);
  }

  bool begin_decoding(std::span<const std::byte> jpeg, J_COLOR_SPACE space) {
    if (setjmp(errors.back) != 0) return false;
    ::jpeg_mem_src(&decoder, octets(jpeg), jpeg.size());
    ::jpeg_read_header(&decoder, TRUE);
    decoder.out_color_space = space;
    decoder.dct_method = JDCT_IFAST;
    ::jpeg_calc_output_dimensions(&decoder);
    return true;
  }
  bool decode_lines(std::byte* pixels, std::size_t line) {
    if (setjmp(errors.back) != 0) return false;
    errors.manager.num_warnings = 0;
    ::jpeg_start_decompress(&decoder);
    while (decoder.output_scanline < decoder.output_height) {
      auto* row = reinterpret_cast<JSAMPROW>(pixels + decoder.output_scanline * line);
      ::jpeg_read_scanlines(&decoder, &row, 1);
    }
    ::jpeg_finish_decompress(&decoder);
    return true;
  }
  bool encode(const PixelView& picture, int quality) {
    if (setjmp(errors.back) != 0) return false;
    writer.manager.next_output_byte = reinterpret_cast<JOCTET*>(writer.begin);
    writer.manager.free_in_buffer = writer.size;
    encoder.dest = &writer.manager;
    encoder.image_width = picture.size.width;
    encoder.image_height = picture.size.height;
    encoder.input_components = static_cast<int>(bytes_of(picture.format));
    encoder.in_color_space = space_of(picture.format);
    ::jpeg_set_defaults(&encoder);
    ::jpeg_set_quality(&encoder, quality, TRUE);
    encoder.dct_method = JDCT_IFAST;
    ::jpeg_start_compress(&encoder, TRUE);
    const std::size_t line = picture.size.width * bytes_of(picture.format);
    while (encoder.next_scanline < encoder.image_height) {
      // The library only reads the rows.
      auto* row = const_cast<JSAMPROW>(octets(picture.bytes.subspan(encoder.next_scanline * line)));
      ::jpeg_write_scanlines(&encoder, &row, 1);
    }
    ::jpeg_finish_compress(&encoder);
    return true;
  }

  Errors errors;
  Writer writer;
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct decoder{};
  jpeg_compress_struct encoder{};
};

Jpeg::Jpeg() : library_(std::make_unique<Library>()) {
  // Takes the tables of a picture that was encoded with the standard tables.
  const std::vector<std::byte> dot(3);
  std::vector<std::byte> picture;
  (void)encode({.format = Pixels8::kRgb, .size = {1, 1}, .bytes = dot}, 50, 4096, picture);
  Segments segments(picture);
  while (const auto segment = segments.next())
    if (segment->marker == kHuffman)
      tables_.insert(tables_.end(), segment->bytes.begin(), segment->bytes.end());
}

Jpeg::~Jpeg() = default;

Result<PictureSize> Jpeg::decode(std::span<const std::byte> jpeg, Pixels8 format,
                                 std::size_t bytes_max, std::vector<std::byte>& pixels) {
  const auto failed = [&] {
    ::jpeg_abort_decompress(&library_->decoder);
    return Error(Errc::kMalformed, std::string("invalid picture: ") + library_->errors.text.data());
  };
  // Checks the size before the library allocates memory for the pixels.
  const auto stated = jpeg_size(jpeg);
  if (!stated || std::size_t{stated->width} * stated->height * bytes_of(format) > bytes_max)
    return Error(stated ? Errc::kTooBig : Errc::kMalformed,
                 stated ? "a picture of " + std::to_string(stated->width) + "x" +
                              std::to_string(stated->height) + " pixels"
                        : "invalid picture: header missing");
  if (!library_->begin_decoding(jpeg, space_of(format))) return failed();
  const PictureSize size{library_->decoder.output_width, library_->decoder.output_height};
  const std::size_t line = size.width * bytes_of(format);
  if (line * size.height > bytes_max ||
      static_cast<std::size_t>(library_->decoder.output_components) != bytes_of(format))
    return failed();
  pixels.resize(line * size.height);
  if (!library_->decode_lines(pixels.data(), line)) return failed();
  if (library_->errors.manager.num_warnings > 0) return Error(Errc::kMalformed, "damaged picture");
  return size;
}

Result<void> Jpeg::encode(const PixelView& picture, int quality, std::size_t bytes_max,
                          std::vector<std::byte>& jpeg) {
  constexpr std::uint32_t kSideMax = 65500;  // limit of the format
  const std::size_t needed =
      std::size_t{picture.size.width} * picture.size.height * bytes_of(picture.format);
  if (needed == 0 || picture.size.width > kSideMax || picture.size.height > kSideMax ||
      picture.bytes.size() < needed)
    return Error(Errc::kInvalidArgument, "the picture has fewer pixels than its size requires");
  jpeg.resize(bytes_max);
  library_->writer.begin = jpeg.data();
  library_->writer.size = jpeg.size();
  if (!library_->encode(picture, std::clamp(quality, 1, 100))) {
    ::jpeg_abort_compress(&library_->encoder);
    jpeg.clear();
    return Error(Errc::kTooBig, "the picture exceeds the maximum size of a message");
  }
  jpeg.resize(bytes_max - library_->writer.manager.free_in_buffer);
  return {};
}

bool Jpeg::complete(std::span<const std::byte> frame, std::vector<std::byte>& jpeg) const {
  bool has_tables = false;
  bool has_scan = false;
  Segments segments(frame);
  while (const auto segment = segments.next()) {
    has_tables = has_tables || segment->marker == kHuffman;
    has_scan = has_scan || segment->marker == kScan;
  }
  if (!has_scan) return false;
  // Cameras pad their buffers.
  constexpr std::array kEndMark = {kMark, std::byte{kEnd}};
  const auto end = std::find_end(frame.begin(), frame.end(), kEndMark.begin(), kEndMark.end());
  if (end == frame.end()) return false;
  frame = frame.first(static_cast<std::size_t>(end - frame.begin()) + kEndMark.size());
  jpeg.assign(frame.begin(), frame.begin() + 2);
  if (!has_tables) jpeg.insert(jpeg.end(), tables_.begin(), tables_.end());
  jpeg.insert(jpeg.end(), frame.begin() + 2, frame.end());
  return true;
}

}  // namespace rack::device
