// What a router that is restarted leaves to the next one, which goes on with its links: read by
// the next version of this program, on the same host and since the same boot, and by nobody else.
//
//      0 | "TIMSLNKS"                    |
//      8 | version       | size          |   size: of what follows the checksum
//     16 | checksum                      |
//     24 | when it was written, ns       |
//     32 | table number  | own identity ...
//        | addresses of the exported table, of the mailboxes of this host; links
//
// Integers are little-endian. Anything else than exactly this version is not read: the router then
// starts as after a crash, and the others end its sessions. It contains no keys. All of it is
// checked as what comes from a stranger is: a router must not fail to start because of it.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "router/link/datagram.h"
#include "tims/address.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::link {

// Appends integers, enumerations, times, and bytes preceded by their number.
class StateWriter {
 public:
  template <typename... T>
  void put(T... values) {
    (put_one(values), ...);
  }
  void put_bytes(std::span<const std::byte> bytes) {
    put(static_cast<std::uint32_t>(bytes.size()));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text))); }
  void put_address(const NetAddress& address);
  void put_identity(const Identity& identity);
  // Room for bytes preceded by their number, to be filled by the caller before the next put.
  std::span<std::byte> reserve(std::size_t size) {
    put(static_cast<std::uint32_t>(size));
    bytes_.resize(bytes_.size() + size);
    return std::span(bytes_).last(size);
  }
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }

 private:
  template <typename T>
  void put_one(T value) {
    if constexpr (std::same_as<T, Time>) {
      put_one(static_cast<std::int64_t>(value.time_since_epoch().count()));
    } else {
      static_assert(std::integral<T> || std::is_enum_v<T>);
      for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes_.push_back(
            static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF));
    }
  }

  std::vector<std::byte> bytes_;
};

// What StateWriter has written. A time is not after `now`.
class StateReader : public ByteReader {
 public:
  StateReader(Time now, std::span<const std::byte> bytes) : ByteReader(bytes), now_(now) {}
  Time time() {
    const Time time{Duration(get<std::int64_t>())};
    return std::min(time, now_);
  }
  std::span<const std::byte> bytes() { return take(get<std::uint32_t>()); }
  std::string text() {
    const auto size = get<std::uint32_t>();
    return std::string(ByteReader::text(size));
  }
  bool address(NetAddress& address);
  bool identity(Identity& identity);

 private:
  Time now_;
};

struct Handover {
  static constexpr std::uint32_t kVersion = 1;
  // Afterwards the others have ended the sessions, and messages are too old.
  static constexpr Duration kAgeMax = std::chrono::seconds(30);
  static constexpr std::size_t kBytesMax = std::size_t{1} << 30;

  Time at{};                       // when it was written
  std::uint32_t table_number = 0;  // of the exported table
  Identity self{};
  std::vector<Address> exported{};   // ascending
  std::vector<Address> mailboxes{};  // of programs of this host
  std::vector<std::byte> links{};    // of Links::save()

  [[nodiscard]] std::vector<std::byte> encode() const;
  // The error says why the router starts without it.
  static Result<Handover> decode(Time now, std::span<const std::byte> bytes);
};

}  // namespace tims::link
