// Errors are values: a code from a closed list and a detail that states what failed and what to do.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "tims/export.h"

namespace tims {

enum class Errc : std::uint8_t {
  kEmpty,            // no message is waiting
  kTimeout,          // the given time has passed
  kClosed,           // this mailbox or session was closed
  kNoRouter,         // no router at the socket
  kRefused,          // the router refused the request; the detail states the reason
  kAddressInUse,     // another program owns the address; the detail names the owner
  kNoMailbox,        // no such mailbox on this host
  kFull,             // the receiver is full of messages more important than this one
  kTooBig,           // larger than the receiver's slot or the configured maximum
  kBufferTooSmall,   // the caller's buffer is too small; the message stays in the mailbox
  kReclaimed,        // the router had declared this writer dead and reclaimed the slot
  kBadLayout,        // shared memory whose content is not a valid mailbox
  kVersion,          // client and router have no protocol version in common
  kInvalidArgument,  // the call itself is wrong
  kSystem,           // the operating system refused; the detail has its message
  kAnsweredError,    // the component answered ERROR; its text messages state the reason
  kMalformed,        // bytes that do not form the expected message; the detail names the field
  kDiskFull,         // no space for a file; the detail names it
};

// An identifier for scripts and JSON ("address_in_use"), and a sentence for people.
TIMS_API std::string_view name(Errc code);
TIMS_API std::string_view sentence(Errc code);

class TIMS_API Error {
 public:
  Error(Errc code) : code_(code) {}  // NOLINT(google-explicit-constructor): `return Errc::kFull;`
  Error(Errc code, std::string detail) : code_(code), detail_(std::move(detail)) {}

  [[nodiscard]] Errc code() const { return code_; }
  [[nodiscard]] const std::string& detail() const { return detail_; }
  // "address in use: Ladar(0/0) belongs to pid 4711 (laser)"
  [[nodiscard]] std::string message() const;
  bool operator==(Errc code) const { return code_ == code; }

 private:
  Errc code_;
  std::string detail_;
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T&& value) : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT
  Result(const T& value)
    requires std::copy_constructible<T>
      : state_(std::in_place_index<0>, value) {}                             // NOLINT
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT
  Result(Errc code) : state_(std::in_place_index<1>, code) {}                // NOLINT

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] T& value() & { return *std::get_if<0>(&state_); }
  [[nodiscard]] const T& value() const& { return *std::get_if<0>(&state_); }
  [[nodiscard]] T&& value() && { return std::move(*std::get_if<0>(&state_)); }
  [[nodiscard]] const Error& error() const { return *std::get_if<1>(&state_); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  // The value, or in case of an error the other one.
  [[nodiscard]] T value_or(T other) && {
    return ok() ? std::move(*this).value() : std::move(other);
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT
  Result(Errc code) : error_(code) {}                // NOLINT
  [[nodiscard]] bool ok() const { return !error_; }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace tims
