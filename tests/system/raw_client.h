// A client of the local protocol that can send arbitrary messages, and properties of processes.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <sys/resource.h>
#include <sys/socket.h>

#include "os/socket.h"
#include "tests/support/patience.h"
#include "wire/local_protocol.h"

namespace tims::test {

using namespace std::chrono_literals;

// Sends and receives single messages of the local protocol.
class RawClient {
 public:
  explicit RawClient(const std::string& path) : socket_(std::move(*os::connect_unix(path))) {
    const timeval limit{kPatience / 1s, 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  }
  bool send(const wire::Record& record, const std::vector<int>& files = {}) const {
    std::vector<std::byte> bytes;
    wire::encode({1, record}, bytes);
    return send_bytes(bytes, files);
  }
  bool send_bytes(std::span<const std::byte> bytes, const std::vector<int>& files = {}) const {
    return os::send_record(socket_.get(), bytes, files).ok();
  }
  std::optional<wire::Record> receive() {
    std::vector<std::byte> buffer(wire::kRecordBytesMax);
    auto received = os::receive_record(socket_.get(), buffer, true);
    if (!received || received->size == 0) return std::nullopt;
    files_ = std::move(received->files);
    auto decoded = wire::decode(std::span(buffer).first(received->size));
    if (!decoded.packet) return std::nullopt;
    return decoded.packet->record;
  }
  bool hello() {
    send(wire::Hello{.name = "hostile"});
    const auto answer = receive();
    return answer && std::holds_alternative<wire::Welcome>(*answer);
  }
  // Like hello(); files() are then the uplink's memory and its doorbell.
  bool hello_and_uplink() {
    return hello() && send(wire::UplinkRequest{}) && receive() && files_.size() == 2;
  }
  // Whether the router has closed the connection.
  bool thrown_out() {
    for (;;) {
      std::vector<std::byte> buffer(wire::kRecordBytesMax);
      const auto received = os::receive_record(socket_.get(), buffer, true);
      if (!received) return false;
      if (received->size == 0) return true;
    }
  }
  std::vector<os::File>& files() { return files_; }

 private:
  os::File socket_;
  std::vector<os::File> files_;
};

// Offers `memfd` and requests a mailbox at `offset` of it; returns the router's answer.
inline std::optional<wire::OpenStatus> try_open(RawClient& client, const os::File& memfd,
                                                std::uint64_t offset, const os::File& waker = {}) {
  client.send(wire::OfferSegment{1}, {memfd.get()});
  const auto files = waker ? std::vector{waker.get()} : std::vector<int>{};
  client.send(wire::Open{{{Address(5), {1, offset}, static_cast<bool>(waker)}}}, files);
  const auto answer = client.receive();
  if (!answer || !std::holds_alternative<wire::Opened>(*answer)) return std::nullopt;
  return std::get<wire::Opened>(*answer).entries.front().status;
}

// State of a process: 'R' running, 'S' sleeping.
inline char state_of(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::size_t name_end = text.rfind(')');
  return name_end + 2 < text.size() ? text[name_end + 2] : '?';
}

inline std::size_t descriptors_of(pid_t pid) {
  std::error_code gone;
  const std::filesystem::directory_iterator folder("/proc/" + std::to_string(pid) + "/fd", gone);
  return static_cast<std::size_t>(std::distance(begin(folder), end(folder)));
}
// The number of shared mappings of a process; private ones belong to its allocator or a sanitizer.
inline std::size_t mappings_of(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/maps");
  std::size_t count = 0;
  std::string range, rights, rest;
  while (file >> range >> rights && std::getline(file, rest))
    count += rights.ends_with('s') ? 1 : 0;
  return count;
}
// Limits the number of descriptors of a process; open ones are kept.
inline void limit_descriptors(pid_t pid, rlim_t count) {
  rlimit limit{};
  ::prlimit(pid, RLIMIT_NOFILE, nullptr, &limit);
  limit.rlim_cur = count;
  ::prlimit(pid, RLIMIT_NOFILE, &limit, nullptr);
}

}  // namespace tims::test
