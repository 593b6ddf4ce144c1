#include "components/devices/io/recording.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <vector>

#include <pcap/pcap.h>

#include "components/devices/core/device_clock.h"
#include "components/devices/core/packet.h"
#include "components/devices/core/video_frame.h"
#include "components/devices/io/video_exchange.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::os::system_error;

// CaptureFile writes no longer ones.
constexpr std::size_t kCaptureLineMax = 16 << 20;

class CaptureLines final : public Recording {
 public:
  explicit CaptureLines(std::ifstream file) : file_(std::move(file)) {}

  Result<bool> next(CaptureRecord& record) override {
    while (read_line()) {
      ++number_;
      if (line_.size() > kCaptureLineMax)
        return Error(Errc::kTooBig, "line " + std::to_string(number_) + ": longer than " +
                                        std::to_string(kCaptureLineMax >> 20) +
                                        " MB, so it is not a recording of a device");
      const auto parsed = parse_record(line_, record);
      if (!parsed)
        return Error(Errc::kMalformed,
                     "line " + std::to_string(number_) + ": " + parsed.error().detail());
      if (*parsed) return true;
    }
    return false;
  }
  void rewind() override {
    file_.clear();
    file_.seekg(0);
    number_ = 0;
  }

 private:
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

  std::ifstream file_;
  std::array<char, 64 << 10> piece_{};
  std::string line_;
  std::size_t number_ = 0;
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

 private:
  static constexpr std::uint32_t kPiecesOfSecond = 1000;

  std::ifstream file_;
  std::uint32_t baud_;
  std::size_t piece_;
  std::size_t taken_ = 0;
};

// `port`: for TCP the port of the device, for UDP that of the receiver; 0: all ports.
class PacketCapture final : public Recording {
 public:
  PacketCapture(std::string path, std::uint16_t port) : path_(std::move(path)), port_(port) {}
  ~PacketCapture() override { close(); }

  Result<void> open() {
    std::array<char, PCAP_ERRBUF_SIZE> error{};
    file_ = ::pcap_open_offline_with_tstamp_precision(path_.c_str(), PCAP_TSTAMP_PRECISION_NANO,
                                                      error.data());
    if (file_ == nullptr) return Error(Errc::kMalformed, error.data());
    link_ = static_cast<PacketLink>(::pcap_datalink(file_));
    return {};
  }

  Result<bool> next(CaptureRecord& record) override {
    pcap_pkthdr* header = nullptr;
    const unsigned char* data = nullptr;
    for (;;) {
      const int got = file_ == nullptr ? PCAP_ERROR_BREAK : ::pcap_next_ex(file_, &header, &data);
      if (got == PCAP_ERROR_BREAK) return false;
      if (got != 1) return Error(Errc::kMalformed, ::pcap_geterr(file_));
      const auto payload = payload_of(link_, std::as_bytes(std::span(data, header->caplen)));
      if (!payload || !is_wanted(*payload)) continue;
      const auto bytes = payload->is_tcp ? order_.take(*payload) : payload->bytes;
      if (bytes.empty()) continue;
      record.bytes.assign(bytes.begin(), bytes.end());
      record.id = payload->is_tcp ? 0 : payload->from_port;
      record.time = std::chrono::seconds(header->ts.tv_sec) + Duration(header->ts.tv_usec);
      return true;
    }
  }
  void rewind() override {
    close();
    order_ = {};
    (void)open();
  }

 private:
  [[nodiscard]] bool is_wanted(const Payload& payload) const {
    return port_ == 0 || port_ == (payload.is_tcp ? payload.from_port : payload.to_port);
  }
  void close() {
    if (file_ != nullptr) ::pcap_close(file_);
    file_ = nullptr;
  }

  std::string path_;
  std::uint16_t port_;
  pcap_t* file_ = nullptr;
  PacketLink link_{};
  StreamOrder order_;
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

 private:
  static constexpr Duration kBetween = std::chrono::milliseconds(50);

  std::vector<std::filesystem::path> files_;
  std::size_t next_ = 0;
};

RecordingFormat format_of_file(std::ifstream& file) {
  std::array<std::byte, 512> beginning{};
  file.read(reinterpret_cast<char*>(beginning.data()), beginning.size());
  const auto size = static_cast<std::size_t>(file.gcount());
  file.clear();
  file.seekg(0);
  return format_of(std::span(beginning).first(size));
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
  switch (format_of_file(file)) {
    case RecordingFormat::kCapture:
      return std::unique_ptr<Recording>(std::make_unique<CaptureLines>(std::move(file)));
    case RecordingFormat::kRaw:
      return std::unique_ptr<Recording>(
          std::make_unique<RawBytes>(std::move(file), address.baud(baud)));
    case RecordingFormat::kPcap:
      break;
  }
  const auto port = address.options.find("port");
  auto packets = std::make_unique<PacketCapture>(
      address.place, port == address.options.end()
                         ? std::uint16_t{0}
                         : static_cast<std::uint16_t>(std::stoul(port->second)));
  if (auto opened = packets->open(); !opened)
    return Error(Errc::kMalformed, address.place + ": " + opened.error().detail());
  return std::unique_ptr<Recording>(std::move(packets));
}

// Reads all lines and skips unreadable ones.
Result<std::uint64_t> read_recording(
    const std::string& path, const std::function<Result<void>(const CaptureRecord&)>& take) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return system_error(path);
  if (format_of_file(file) != RecordingFormat::kCapture)
    return Error(Errc::kMalformed, path + " is not a RACK recording");
  CaptureLines lines(std::move(file));
  std::uint64_t unreadable = 0;
  CaptureRecord record;
  for (;;) {
    const auto got = lines.next(record);
    if (got && !*got) return unreadable;
    if (!got) {
      ++unreadable;
      continue;
    }
    if (auto good = take(record); !good) {
      const auto at = std::chrono::duration_cast<std::chrono::milliseconds>(record.time);
      return Error(good.error().code(),
                   path + ", at " + std::to_string(at.count()) + " ms: " + good.error().detail());
    }
  }
}

}  // namespace rack::device
