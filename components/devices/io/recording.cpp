#include "rack/devices/recording.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "base/text.h"
#include "components/devices/core/video_frame.h"
#include "components/devices/io/packet_capture.h"
#include "components/devices/io/video_exchange.h"
#include "os/file.h"
#include "rack/devices/device_clock.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::os::system_error;

// CaptureFile writes no longer ones.
constexpr std::size_t kCaptureLineMax = 16 << 20;

// Unreadable lines and frames that drivers cannot use are left out and counted.
class CaptureLines final : public Recording {
 public:
  // `interface`: of a candump log; empty: all.
  explicit CaptureLines(std::ifstream file, std::string interface = {})
      : file_(std::move(file)), interface_(std::move(interface)) {}

  Result<bool> next(CaptureRecord& record) override {
    while (read_line()) {
      ++number_;
      if (line_.size() > kCaptureLineMax)
        return Error(Errc::kTooBig, "line " + std::to_string(number_) + ": longer than " +
                                        std::to_string(kCaptureLineMax >> 20) +
                                        " MB, so it is not a recording of a device");
      const auto parsed = parse_record(line_, record);
      if (!parsed)
        count_unreadable(parsed.error().detail());
      else if (*parsed && is_wanted(record))
        return true;
    }
    return false;
  }
  void rewind() override {
    file_.clear();
    file_.seekg(0);
    number_ = 0;
    unreadable_ = fd_ = errors_ = 0;
    buses_.clear();
  }
  [[nodiscard]] std::string format() const override {
    return buses_.empty() ? "RACK capture" : "candump log";
  }
  [[nodiscard]] std::string remarks() const override {
    std::string text;
    const auto append = [&text](std::uint64_t count, const std::string& what,
                                const std::string& more) {
      if (count == 0) return;
      text += (text.empty() ? "left out: " : ", ") + std::to_string(count) + " " + what;
      text += (count == 1 ? "" : "s") + more;
    };
    append(fd_, "frame", " of CAN FD");
    append(errors_, "error frame", "");
    for (const auto& [bus, frames] : buses_)
      if (!interface_.empty() && bus != interface_)
        append(frames, "frame", " of " + tims::base::printable(bus));
    append(unreadable_, "unreadable line", ", the first is " + first_unreadable_);
    if (interface_.empty() && buses_.size() > 1)
      text += (text.empty() ? "" : "; ") + several_buses();
    return text;
  }
  [[nodiscard]] std::uint64_t unreadable() const { return unreadable_; }

 private:
  static constexpr std::size_t kBusesMax = 16;

  // The next line; of one that is too long only the beginning, and the rest is skipped.
  bool read_line() {
    line_.clear();
    while (file_.getline(piece_.data(), std::ssize(piece_)), file_.gcount() > 0) {
      const auto size = static_cast<std::size_t>(file_.gcount());
      const bool is_whole = !file_.fail();
      if (line_.size() <= kCaptureLineMax)
        line_.append(piece_.data(), is_whole && !file_.eof() ? size - 1 : size);
      if (is_whole) return true;
      if (file_.eof()) return !line_.empty();
      file_.clear();
    }
    return !line_.empty();
  }

  void count_unreadable(const std::string& why) {
    if (unreadable_++ == 0) first_unreadable_ = "line " + std::to_string(number_) + ": " + why;
  }
  bool is_wanted(const CaptureRecord& record) {
    if (!record.bus.empty() && (buses_.size() < kBusesMax || buses_.contains(record.bus)))
      ++buses_[record.bus];
    const bool is_other = !record.bus.empty() && record.bus != interface_;
    if (!interface_.empty() && is_other) return false;
    if (record.frame == FrameKind::kFd) ++fd_;
    if (record.frame == FrameKind::kError) ++errors_;
    return record.frame == FrameKind::kData;
  }
  [[nodiscard]] std::string several_buses() const {
    std::string names;
    for (const auto& [bus, frames] : buses_)
      names += (names.empty() ? "" : ", ") + tims::base::printable(bus);
    return "the frames of several interfaces (" + names +
           ") are played as those of one bus; choose one, for example ?interface=" +
           tims::base::printable(buses_.begin()->first);
  }

  std::ifstream file_;
  std::array<char, 64 << 10> piece_{};
  std::string interface_;
  std::string line_;
  std::size_t number_ = 0;
  std::uint64_t unreadable_ = 0;
  std::uint64_t fd_ = 0;
  std::uint64_t errors_ = 0;
  std::string first_unreadable_;
  std::map<std::string, std::uint64_t> buses_;  // number of frames by interface
};

// Raw bytes with the timing of a line of that rate, in pieces of 1 ms.
class RawBytes final : public Recording {
 public:
  RawBytes(std::ifstream file, std::uint32_t baud)
      : file_(std::move(file)), baud_(baud), piece_(std::max(1U, baud / kPiecesOfSecond / 10)) {}

  Result<bool> next(CaptureRecord& record) override {
    record.id = 0;
    record.bytes.resize(piece_);
    file_.read(reinterpret_cast<char*>(record.bytes.data()), static_cast<std::streamsize>(piece_));
    record.bytes.resize(static_cast<std::size_t>(file_.gcount()));
    taken_ += record.bytes.size();
    record.time = line_time(taken_, baud_);
    return !record.bytes.empty();
  }
  void rewind() override {
    file_.clear();
    file_.seekg(0);
    taken_ = 0;
  }
  [[nodiscard]] std::string format() const override {
    return "raw bytes, at " + std::to_string(baud_) + " baud";
  }

 private:
  static constexpr std::uint32_t kPiecesOfSecond = 1000;

  std::ifstream file_;
  std::uint32_t baud_;
  std::size_t piece_;
  std::size_t taken_ = 0;
};

// A folder of pictures as the frames of a camera, sorted by name, 20 per second.
class Pictures final : public Recording {
 public:
  explicit Pictures(const std::string& folder) {
    std::error_code unreadable;
    for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable))
      if ((entry.path().extension() == ".jpg" || entry.path().extension() == ".jpeg") &&
          entry.is_regular_file(unreadable))
        files_.push_back(entry.path());
    std::ranges::sort(files_);
  }
  [[nodiscard]] bool is_empty() const { return files_.empty(); }

  Result<bool> next(CaptureRecord& record) override {
    if (next_ == files_.size()) return false;
    const auto content = tims::os::read_file(files_[next_].string(), kVideoFrameBytesMax);
    if (!content) return content.error();
    const auto bytes = std::as_bytes(std::span(*content));
    record.bytes.assign(bytes.begin(), bytes.end());
    record.id = video::kMjpeg;
    record.time = kBetween * static_cast<std::int64_t>(next_++);
    return true;
  }
  void rewind() override { next_ = 0; }
  [[nodiscard]] std::string format() const override { return "pictures"; }

 private:
  static constexpr Duration kBetween = std::chrono::milliseconds(50);

  std::vector<std::filesystem::path> files_;
  std::size_t next_ = 0;
};

RecordingFormat format_of_file(std::ifstream& file) {
  std::vector<std::byte> beginning(std::size_t{64} << 10);
  file.read(reinterpret_cast<char*>(beginning.data()),
            static_cast<std::streamsize>(beginning.size()));
  const auto size = static_cast<std::size_t>(file.gcount());
  file.clear();
  file.seekg(0);
  return format_of(std::span(beginning).first(size));
}

std::string option(const DeviceAddress& address, std::string_view name) {
  const auto found = address.options.find(name);
  return found == address.options.end() ? std::string() : found->second;
}

Error not_a_recording(const std::string& path, RecordingFormat format) {
  switch (format) {
    case RecordingFormat::kCandumpView:
      return {Errc::kInvalidArgument,
              path + " is the text that candump displays, not its log; record " +
                  "with candump -L can0 > can.log"};
    case RecordingFormat::kHexText:
      return {Errc::kInvalidArgument,
              path + " has bytes as hex digits without times; convert them with " +
                  "xxd -r -p, and give the rate of the line, for example ?baud=9600"};
    default:
      return {Errc::kInvalidArgument,
              path + " is not a recording: neither a RACK capture nor a log of candump -L nor a " +
                  "packet capture; if it has the raw bytes of a line, give their rate, for " +
                  "example ?baud=115200"};
  }
}

}  // namespace

Result<std::unique_ptr<Recording>> open_recording(const DeviceAddress& address,
                                                  std::uint32_t baud) {
  if (std::error_code none; std::filesystem::is_directory(address.place, none)) {
    auto pictures = std::make_unique<Pictures>(address.place);
    if (pictures->is_empty())
      return Error(Errc::kInvalidArgument, address.place + " is a folder without pictures (.jpg)");
    return std::unique_ptr<Recording>(std::move(pictures));
  }
  std::ifstream file(address.place, std::ios::binary);
  if (!file) return system_error(address.place);
  if (file.peek() == std::ifstream::traits_type::eof())
    return Error(Errc::kInvalidArgument, address.place + " is empty");
  const RecordingFormat format = format_of_file(file);
  switch (format) {
    case RecordingFormat::kCapture:
      return std::unique_ptr<Recording>(
          std::make_unique<CaptureLines>(std::move(file), option(address, "interface")));
    case RecordingFormat::kRaw:
      if (address.baud(baud) == 0) break;
      return std::unique_ptr<Recording>(
          std::make_unique<RawBytes>(std::move(file), address.baud(baud)));
    case RecordingFormat::kPcap: {
      const auto port = tims::base::parse_number<std::uint16_t>(option(address, "port"));
      return open_packet_capture(address.place, port.value_or(0));
    }
    case RecordingFormat::kCandumpView:
    case RecordingFormat::kHexText:
      break;
  }
  return not_a_recording(address.place, format);
}

// Reads all lines and skips unreadable ones.
Result<std::uint64_t> read_recording(
    const std::string& path, const std::function<Result<void>(const CaptureRecord&)>& take) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return system_error(path);
  if (format_of_file(file) != RecordingFormat::kCapture)
    return Error(Errc::kMalformed, path + " is not a RACK recording");
  CaptureLines lines(std::move(file));
  CaptureRecord record;
  for (;;) {
    const auto got = lines.next(record);
    if (!got) return got.error();
    if (!*got) return lines.unreadable();
    if (auto good = take(record); !good) {
      const auto at = std::chrono::duration_cast<std::chrono::milliseconds>(record.time);
      return Error(good.error().code(),
                   path + ", at " + std::to_string(at.count()) + " ms: " + good.error().detail());
    }
  }
}

}  // namespace rack::device
