// Emulates the windows of the original's GUI (specification, section 12): one connection and
// mailbox per window, big-endian requests with a sequence number that the answer must repeat, On
// buttons, and data that are polled and decoded field by field in the byte order of the message.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/tcp_client.h"
#include "tims/message.h"
#include "wire/tcp_protocol.h"

namespace tims::test {

// Decodes like Java's DataInput.
class Fields {
 public:
  explicit Fields(const OwnedMessage& message)
      : bytes_(message.body), order_(message.header.body_order()) {}

  template <typename T>
  T next() {
    std::array<std::byte, sizeof(T)> bytes{};
    EXPECT_GE(bytes_.size(), bytes.size()) << "the message is too short";
    if (bytes_.size() < bytes.size()) return {};
    std::ranges::copy(bytes_.first(bytes.size()), bytes.begin());
    bytes_ = bytes_.subspan(bytes.size());
    if (order_ != std::endian::native) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }
  template <typename T>
  void skip(int count) {
    for (int i = 0; i < count; ++i) next<T>();
  }
  std::string text(std::size_t size) {
    std::string text;
    while (text.size() < size) text += next<char>();
    return text;
  }
  [[nodiscard]] std::span<const std::byte> rest() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
  std::endian order_;
};

// Encodes like Java's DataOutput.
class Body {
 public:
  template <typename T>
  Body& add(T value) {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if (std::endian::native != std::endian::big) std::ranges::reverse(bytes);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  template <typename T, typename... More>
  Body& add(T value, More... more) {
    return add(value).add(more...);
  }
  // Padded with zeros to `size`.
  Body& text(std::string_view text, std::size_t size = 0) {
    for (const char letter : text) add(letter);
    for (std::size_t i = text.size(); i < size; ++i) add(char{0});
    return *this;
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

class Window {
 public:
  Window(TcpClient& router, std::uint32_t component, std::uint8_t number)
      : router_(&router), own_(0x00020100U + number), component_(component) {
    const auto registered = router.register_mailbox(own_);
    EXPECT_TRUE(registered) << registered.error().message();
  }

  // Accepts only an answer with the same sequence number.
  std::optional<OwnedMessage> ask(std::int8_t type, std::span<const std::byte> body = {}) {
    ++number_;
    const auto sent = router_->send(
        {.flags = 0, .type = type, .seq_nr = number_, .dest = component_, .src = own_}, body);
    EXPECT_TRUE(sent) << sent.error().message();
    for (;;) {
      auto message = router_->receive();
      EXPECT_TRUE(message) << component_.to_string() << " does not answer " << int{type};
      if (!message) return std::nullopt;
      if (message->header.src == component_ && message->header.seq_nr == number_) return *message;
    }
  }
  int answer_to(std::int8_t type, std::span<const std::byte> body = {}) {
    const auto message = ask(type, body);
    return message ? message->header.type : -128;
  }
  int answer_to(std::int8_t type, const Body& body) { return answer_to(type, body.bytes()); }
  void press_on() { EXPECT_EQ(answer_to(type::kOn), type::kOk); }
  // Requests the newest data (time 0). Nothing: the window shows no values.
  std::optional<OwnedMessage> poll() { return data(type::kGetData, Body().add(std::int32_t{0})); }
  // Some windows request the next data instead.
  std::optional<OwnedMessage> wait_for_next() { return data(type::kGetNextData, {}); }

 private:
  std::optional<OwnedMessage> data(std::int8_t type, const Body& body) {
    auto message = ask(type, body.bytes());
    if (message && message->header.type != type::kData) message.reset();
    return message;
  }

  TcpClient* router_;
  Address own_;
  Address component_;
  std::uint8_t number_ = 0;
};

class OriginalGui {
 public:
  explicit OriginalGui(const std::string& router) {
    auto client = TcpClient::connect(router);
    EXPECT_TRUE(client) << client.error().message();
    if (!client) return;
    client_.emplace(std::move(*client));
    client_->set_byte_order(std::endian::big);
    EXPECT_TRUE(client_->send({.type = wire::router_command::kDisableWatchdog}));
  }
  Window open_window(std::uint32_t component) { return {*client_, component, ++windows_}; }

 private:
  std::optional<TcpClient> client_;
  std::uint8_t windows_ = 0;
};

}  // namespace tims::test
