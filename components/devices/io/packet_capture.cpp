#include "components/devices/io/packet_capture.h"

#include <array>
#include <map>
#include <optional>

#include <pcap/pcap.h>

#include "components/devices/core/packet.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;

class PacketCapture final : public Recording {
 public:
  PacketCapture(std::string path, std::uint16_t port) : path_(std::move(path)), port_(port) {}
  ~PacketCapture() override { close(); }

  Result<void> open() {
    std::array<char, PCAP_ERRBUF_SIZE> error{};
    file_ = ::pcap_open_offline_with_tstamp_precision(path_.c_str(), PCAP_TSTAMP_PRECISION_NANO,
                                                      error.data());
    if (file_ == nullptr) return Error(Errc::kInvalidArgument, path_ + ": " + error.data());
    const int type = ::pcap_datalink(file_);
    const auto link = packet_link(type);
    if (!link) return Error(Errc::kInvalidArgument, path_ + ": " + unsupported(type));
    reader_.emplace(*link);
    return {};
  }

  Result<bool> next(CaptureRecord& record) override {
    pcap_pkthdr* header = nullptr;
    const unsigned char* data = nullptr;
    while (file_ != nullptr) {
      const int got = ::pcap_next_ex(file_, &header, &data);
      if (got == PCAP_ERROR_BREAK) break;
      if (got != 1) {
        if (packets_ == 0)
          return Error(Errc::kInvalidArgument, path_ + ": " + ::pcap_geterr(file_));
        end_ = ::pcap_geterr(file_);
        break;
      }
      ++packets_;
      const auto payload = reader_->take(std::as_bytes(std::span(data, header->caplen)));
      if (!payload || !is_wanted(*payload)) continue;
      const auto bytes = payload->is_tcp ? order_.take(*payload) : payload->bytes;
      if (bytes.empty()) continue;
      record.bytes.assign(bytes.begin(), bytes.end());
      record.id = payload->is_tcp ? 0 : payload->from_port;
      record.time = std::chrono::seconds(header->ts.tv_sec) + Duration(header->ts.tv_usec);
      return true;
    }
    return false;
  }
  void rewind() override {
    close();
    order_ = {};
    others_.clear();
    packets_ = wanted_ = 0;
    end_.clear();
    (void)open();
  }
  [[nodiscard]] std::string format() const override { return "packet capture"; }
  [[nodiscard]] std::string remarks() const override {
    std::string text;
    const auto append = [&](const std::string& part) {
      text += (text.empty() ? "left out: " : "; ") + part;
    };
    if (reader_ && reader_->truncated() > 0)
      append(std::to_string(reader_->truncated()) +
             " truncated packets (record whole ones, with tcpdump -s 0)");
    if (reader_ && reader_->incomplete() > 0)
      append(std::to_string(reader_->incomplete()) + " fragments of incomplete packets");
    if (wanted_ == 0 && packets_ > 0) append(nothing_found());
    if (!end_.empty()) append("the end of the file: " + end_);
    return text;
  }

 private:
  static constexpr std::size_t kPortsMax = 16;

  static std::string unsupported(int type) {
    const char* const name = ::pcap_datalink_val_to_name(type);
    return std::string("packets of type ") + (name != nullptr ? name : std::to_string(type)) +
           " cannot be read; record on an Ethernet interface, or with tcpdump -i any";
  }
  bool is_wanted(const Payload& payload) {
    const std::uint16_t port = payload.is_tcp ? payload.from_port : payload.to_port;
    const bool wanted = port_ == 0 || port_ == port;
    if (wanted)
      ++wanted_;
    else if (others_.size() < kPortsMax || others_.contains(port))
      ++others_[port];
    return wanted;
  }
  [[nodiscard]] std::string nothing_found() const {
    if (others_.empty())
      return "all packets: none of " + std::to_string(packets_) + " has a payload of UDP or TCP";
    std::string ports;
    for (const auto& [port, packets] : others_)
      ports += (ports.empty() ? "" : ", ") + std::to_string(packets) + " of port " +
               std::to_string(port);
    return "all packets: none is of port " + std::to_string(port_) + ", but " + ports;
  }
  void close() {
    if (file_ != nullptr) ::pcap_close(file_);
    file_ = nullptr;
  }

  std::string path_;
  std::uint16_t port_;
  pcap_t* file_ = nullptr;
  std::optional<PacketReader> reader_;
  StreamOrder order_;
  std::uint64_t packets_ = 0;
  std::uint64_t wanted_ = 0;
  std::map<std::uint16_t, std::uint64_t> others_;  // packets of other ports
  std::string end_;                                // why the file ends early
};

}  // namespace

Result<std::unique_ptr<Recording>> open_packet_capture(const std::string& path,
                                                       std::uint16_t port) {
  auto packets = std::make_unique<PacketCapture>(path, port);
  if (auto opened = packets->open(); !opened) return opened.error();
  return std::unique_ptr<Recording>(std::move(packets));
}

}  // namespace rack::device
