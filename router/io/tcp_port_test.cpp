// Over a pair of Unix stream sockets: they behave as TCP does towards a writer.
#include "router/io/tcp_port.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/file.h"
#include "wire/tcp_protocol.h"

namespace tims::io {
namespace tcp_port_test {

using core::Outcome;
using Bytes = std::vector<std::byte>;
using State = TcpOutput::State;

Bytes message(std::uint32_t length, std::uint8_t priority, std::uint32_t number = 0) {
  Bytes bytes(length, static_cast<std::byte>(number));
  wire::encode_header({.priority = priority, .src = Address(number), .length = length},
                      std::span(bytes).first<kHeaderSize>());
  return bytes;
}

class TcpOutputTest : public testing::Test {
 protected:
  TcpOutputTest() {
    int pair[2] = {-1, -1};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair), 0);
    ours_ = os::File(pair[0]);
    theirs_ = os::File(pair[1]);
    const int small = 4096;
    ::setsockopt(ours_.get(), SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    output_.emplace(ours_.get(), shares_, 100'000);
  }

  // Keeps the bytes as long as the test lasts.
  Outcome add(Bytes bytes, std::uint8_t priority) {
    sent_.push_back(std::move(bytes));
    return output_->add(sent_.back(), priority);
  }
  // The source addresses of the whole messages that have arrived, in order.
  std::vector<std::uint32_t> read_all() {
    std::vector<std::uint32_t> numbers;
    Bytes buffer(1 << 20);
    for (;;) {
      const ssize_t n = ::recv(theirs_.get(), buffer.data(), buffer.size(), 0);
      if (n <= 0) return numbers;
      std::span<std::byte> chunk = std::span(buffer).first(static_cast<std::size_t>(n));
      for (auto item = reader_.next(chunk); item.status == wire::StreamReader::Status::kMessage;
           item = reader_.next(chunk)) {
        for (const std::byte b : item.message.subspan(kHeaderSize)) {
          EXPECT_EQ(b, static_cast<std::byte>(item.header.src.raw())) << "torn";
        }
        numbers.push_back(item.header.src.raw());
      }
    }
  }
  std::vector<std::uint32_t> drain() {
    std::vector<std::uint32_t> numbers = read_all();
    while (output_->state() == State::kWaiting) {
      output_->write_queue();
      for (const std::uint32_t number : read_all()) numbers.push_back(number);
    }
    return numbers;
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(100 * core::BlockPool::kBlockSize);
  core::BlockPool pool_{memory_};
  core::QueueShares shares_{pool_};
  os::File ours_;
  os::File theirs_;
  std::optional<TcpOutput> output_;
  std::vector<Bytes> sent_;
  wire::StreamReader reader_{1 << 20};
};

TEST_F(TcpOutputTest, WritesABatchInOrder) {
  for (std::uint32_t i = 0; i < 10; ++i) {
    EXPECT_EQ(add(message(20 + i, static_cast<std::uint8_t>(i), i), 0), Outcome::kDelivered);
  }
  EXPECT_TRUE(read_all().empty());
  output_->write_batch();
  EXPECT_EQ(output_->state(), State::kIdle);
  EXPECT_EQ(read_all(), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST_F(TcpOutputTest, MoreThanOneCallCanTakeIsWrittenInBetween) {
  std::vector<std::uint32_t> expected;
  for (std::uint32_t i = 0; i < 300; ++i) {
    add(message(16, 0, i), 0);
    add(message(17, 0, i), 0);  // somewhere else in memory: a piece of its own
    expected.insert(expected.end(), {i, i});
    if (i % 20 == 0) output_->write_batch();
  }
  output_->write_batch();
  EXPECT_EQ(drain(), expected);
}

TEST_F(TcpOutputTest, WhatABatchHasNoRoomForIsCounted) {
  add(message(60'000, 200, 1), 200);
  add(message(30'000, 200, 2), 200);
  add(message(50'000, 0, 3), 0);
  output_->write_batch();
  const TcpOutput::Lost* lost = output_->lost();
  ASSERT_NE(lost, nullptr);
  EXPECT_EQ(lost->refused[1].messages, 1U);
  EXPECT_EQ(lost->refused[1].bytes, 50'000U);
  EXPECT_EQ(drain(), (std::vector<std::uint32_t>{1, 2}));
}

TEST_F(TcpOutputTest, MessagesSideBySideAreOnePiece) {
  Bytes both = message(20, 0, 1);
  const Bytes second = message(30, 0, 2);
  both.insert(both.end(), second.begin(), second.end());
  output_->add(std::span(both).first(20), 0);
  output_->add(std::span(both).subspan(20), 0);
  output_->write_batch();
  EXPECT_EQ(read_all(), (std::vector<std::uint32_t>{1, 2}));
}

TEST_F(TcpOutputTest, WhatTheSocketDoesNotTakeWaitsWhole) {
  for (std::uint32_t i = 0; i < 10; ++i) add(message(6000, 0, i), 0);
  output_->write_batch();
  ASSERT_EQ(output_->state(), State::kWaiting);
  EXPECT_GT(output_->queued_bytes(), 0U);
  sent_.clear();  // no longer needed
  EXPECT_EQ(drain(), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(TcpOutputTest, AnUrgentMessageOvertakesWhatWaitsButNotWhatHasBegun) {
  for (std::uint32_t i = 0; i < 10; ++i) add(message(6000, 1, i), 1);
  output_->write_batch();
  ASSERT_EQ(output_->state(), State::kWaiting);
  add(message(16, 200, 99), 200);
  const auto numbers = drain();
  const auto urgent = std::ranges::find(numbers, 99U);
  ASSERT_NE(urgent, numbers.end());
  EXPECT_LT(urgent - numbers.begin(), 9);
  EXPECT_EQ(numbers.size(), 11U);
}

TEST_F(TcpOutputTest, LossesAreReportedOnce) {
  for (std::uint32_t i = 0; i < 40; ++i) {
    add(message(6000, 1, i), 1);
    output_->write_batch();
  }
  EXPECT_EQ(add(message(6000, 0, 77), 0), Outcome::kQueueFull);
  ASSERT_NE(output_->lost(), nullptr);
  EXPECT_GT(output_->lost()->replaced[2].messages, 0U);
  output_->forget_lost();
  EXPECT_EQ(output_->lost(), nullptr);
  output_->abandon();
  ASSERT_NE(output_->lost(), nullptr);
  EXPECT_GT(output_->lost()->gone[2].messages, 10U);
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(TcpOutputTest, ABrokenConnectionLosesWhatWasToBeWritten) {
  theirs_.reset();
  add(message(100, 40, 1), 40);
  add(message(100, 40, 2), 40);
  output_->write_batch();
  EXPECT_EQ(output_->state(), State::kBroken);
  ASSERT_NE(output_->lost(), nullptr);
  EXPECT_EQ(output_->lost()->gone[5], (core::Count{2, 200}));
  EXPECT_EQ(add(message(100, 0), 0), Outcome::kClientGone);
}

TEST_F(TcpOutputTest, WithoutMemoryForTheRestAMessageIsNotBegun) {
  while (pool_.available() > 0) (void)pool_.allocate();
  for (std::uint32_t i = 0; i < 10; ++i) add(message(60'000, 0, i), 0);
  add(message(100, 0, 10), 0);
  output_->write_batch();
  EXPECT_EQ(output_->state(), State::kIdle);
  ASSERT_NE(output_->lost(), nullptr);
  EXPECT_EQ(output_->lost()->refused[1], (core::Count{10, 600'000}));
  EXPECT_EQ(drain(), (std::vector<std::uint32_t>{10})) << "there is room for it in the socket";
}

// A second client that reads needs memory: this one, which does not, is disconnected, and every
// message is counted.
TEST_F(TcpOutputTest, AStalledOneGivesItsMemoryToOneThatReads) {
  for (std::uint32_t i = 0; i < 3; ++i) add(message(90'000, 0, i), 0);
  output_->write_batch();
  ASSERT_EQ(output_->state(), State::kWaiting);
  shares_.set_now(shares_.now() + core::QueueShares::kPatience);
  int pair[2] = {-1, -1};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, pair), 0);
  const os::File one(pair[0]);
  const os::File other(pair[1]);
  TcpOutput reading(one.get(), shares_, 400'000);
  const Bytes large = message(380'000, 0, 9);
  reading.add(large, 0);
  reading.write_batch();
  EXPECT_EQ(reading.state(), State::kWaiting);
  EXPECT_EQ(reading.lost()->refused[1].messages, 0U);
  EXPECT_EQ(output_->state(), State::kOutOfMemory);
  const TcpOutput::Lost& lost = *output_->lost();
  EXPECT_EQ(lost.gone[1].messages + lost.replaced[1].messages + lost.refused[1].messages, 3U);
}

// Random sizes, priorities and moments of reading: no message is torn, lost or reported twice.
TEST_F(TcpOutputTest, EveryMessageArrivesWholeOrIsCounted) {
  std::mt19937 generator(11);
  const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
  std::vector<std::uint32_t> arrived;
  std::uint64_t refused = 0;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const auto priority = static_cast<std::uint8_t>(random() % 4 * 60);
    if (add(message(16 + random() % 9000, priority, i), priority) != Outcome::kDelivered) ++refused;
    if (random() % 3 == 0) {
      output_->write_batch();
      sent_.clear();
    }
    if (random() % 4 == 0) {
      for (const std::uint32_t number : read_all()) arrived.push_back(number);
      output_->write_queue();
    }
  }
  output_->write_batch();
  for (const std::uint32_t number : drain()) arrived.push_back(number);
  std::uint64_t lost = refused;
  for (std::size_t i = 0; i < core::kClasses; ++i) {
    lost += output_->lost()->replaced[i].messages + output_->lost()->refused[i].messages;
  }
  EXPECT_GT(refused, 0U);
  EXPECT_EQ(arrived.size() + lost, 3000U);
  std::ranges::sort(arrived);
  EXPECT_EQ(std::ranges::adjacent_find(arrived), arrived.end());
}

}  // namespace tcp_port_test
}  // namespace tims::io
