// A folder of pictures as a video. JPEG is handed on as it is, others are decoded by OpenCV.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "components/devices/io/video_exchange.h"
#include "components/devices/video_reader/frame_source.h"
#include "components/pictures/opencv_call.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;

constexpr std::array<std::string_view, 6> kNames = {".jpg", ".jpeg", ".png",
                                                    ".pgm", ".ppm",  ".bmp"};
constexpr std::size_t kPicturesMax = 1'000'000;
constexpr double kFolderRate = 20;

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

class FolderSource final : public FrameSource {
 public:
  FolderSource(std::vector<std::filesystem::path> files, double rate)
      : files_(std::move(files)), rate_(rate) {}

  // A picture that cannot be read is left out, unless none can be read.
  Result<bool> next(SourceFrame& frame) override {
    while (next_ < files_.size()) {
      const auto& file = files_[next_];
      auto read = read_picture(file, frame);
      frame.media = tims::Duration(std::llround(1e9 * static_cast<double>(next_) / rate_));
      ++next_;
      if (read) {
        has_read_ = true;
        return true;
      }
      if (next_ == files_.size() && !has_read_)
        return Error(read.error().code(), file.filename().string() + ": " + read.error().detail());
    }
    return false;
  }

  [[nodiscard]] std::string description() const override {
    return std::to_string(files_.size()) + " pictures";
  }

 private:
  Result<void> read_picture(const std::filesystem::path& file, SourceFrame& frame) {
    auto content = tims::os::read_file(file.string(), kVideoFrameBytesMax);
    if (!content) return content.error();
    content_ = std::move(*content);
    const auto bytes = std::as_bytes(std::span(content_));
    if (content_.starts_with("\xFF\xD8")) {
      frame.head = {.format = video::kMjpeg};
      frame.bytes = bytes;
      return {};
    }
    const cv::Mat source(1, static_cast<int>(bytes.size()), CV_8U, content_.data());
    auto decoded = pictures::call_opencv("decoding a picture", [&] {
      picture_ = content_.empty() ? cv::Mat() : cv::imdecode(source, cv::IMREAD_COLOR);
    });
    if (!decoded) return decoded;
    const std::size_t size = picture_.total() * picture_.elemSize();
    if (picture_.empty()) return Error(Errc::kMalformed, "not a picture");
    if (size > kVideoFrameBytesMax || !picture_.isContinuous())
      return Error(Errc::kTooBig, "the picture has more than 37 MB");
    frame.head = {.format = video::kBgr24,
                  .width = static_cast<std::uint32_t>(picture_.cols),
                  .height = static_cast<std::uint32_t>(picture_.rows),
                  .line_bytes = static_cast<std::uint32_t>(3 * picture_.cols)};
    frame.bytes = std::as_bytes(std::span(picture_.data, size));
    return {};
  }

  std::vector<std::filesystem::path> files_;
  double rate_;
  std::size_t next_ = 0;
  bool has_read_ = false;
  std::string content_;
  cv::Mat picture_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_folder(const DeviceAddress& address) {
  std::vector<std::filesystem::path> files;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(address.place, unreadable))
    if (std::ranges::find(kNames, ending_of(entry.path())) != kNames.end() &&
        files.size() < kPicturesMax && entry.is_regular_file(unreadable))
      files.push_back(entry.path());
  if (unreadable) return Error(Errc::kSystem, unreadable.message());
  if (files.empty())
    return Error(Errc::kInvalidArgument,
                 "a folder without pictures (.jpg, .png, .pgm, .ppm or .bmp)");
  std::ranges::sort(files);
  const double rate = address.rate() > 0 ? address.rate() : kFolderRate;
  return std::unique_ptr<FrameSource>(std::make_unique<FolderSource>(std::move(files), rate));
}

}  // namespace rack::device
