// Playback of recordings (play:): all formats, what is left out of them, and what is refused.
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "os/clock.h"
#include "rack/devices/transport.h"
#include "tests/support/receive_until.h"

namespace rack::device {
namespace playback_test {

using namespace std::chrono_literals;

class PlaybackTest : public testing::Test {
 public:
  ~PlaybackTest() override { std::filesystem::remove(path_); }

 protected:
  std::unique_ptr<Transport> play(std::string_view content, const std::string& options = "") {
    std::ofstream(path_, std::ios::binary) << content;
    auto opened = open_transport(*DeviceAddress::parse("play:" + path_ + options), 9600);
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::move(*opened) : nullptr;
  }

  const std::string path_ = testing::TempDir() + "playback_" + std::to_string(::getpid());
  std::vector<Arrival> arrivals_;
  std::string text_;
};

TEST_F(PlaybackTest, ACaptureAtOnceIsComplete) {
  auto transport =
      play("# rack capture 1 x\n0.0 > 41\n1.0 < 4242\n2.0 ! gone\n90.0 < 43\n", "?speed=max");
  ASSERT_TRUE(receive_until(*transport, arrivals_, text_, [&] { return transport->is_over(); }));
  EXPECT_EQ(text_, "ABBC");
  ASSERT_EQ(arrivals_.size(), 3U);
  EXPECT_TRUE(arrivals_[0].is_sent);
  EXPECT_FALSE(arrivals_[1].is_sent);
}

TEST_F(PlaybackTest, ACaptureAtItsPace) {
  auto transport = play("5.0 < 41\n5.2 < 42\n", "?speed=2");
  const Time start = tims::os::now();
  ASSERT_TRUE(receive_until(*transport, arrivals_, text_, [&] { return transport->is_over(); }));
  EXPECT_EQ(text_, "AB");
  EXPECT_EQ(arrivals_[1].last - arrivals_[0].last, 100ms);
  EXPECT_GE(tims::os::now() - start, 100ms);
}

TEST_F(PlaybackTest, RawBytesComeAtTheRateOfTheLine) {
  auto transport = play("$GPGGA," + std::string(89, 'x'));  // 96 bytes: a tenth of a second at 9600
  ASSERT_TRUE(receive_until(*transport, arrivals_, text_, [&] { return transport->is_over(); }));
  EXPECT_EQ(text_.size(), 96U);
  EXPECT_NEAR(static_cast<double>((arrivals_.back().last - arrivals_.front().last).count()), 1e8,
              1e7);
}

TEST_F(PlaybackTest, UnreadableLinesAreLeftOutAndCounted) {
  auto transport = play("1.0 < 41\nnonsense\n1.1 < 42\n1.2 < 4", "?speed=max");
  ASSERT_TRUE(receive_until(*transport, arrivals_, text_, [&] { return transport->is_over(); }));
  EXPECT_EQ(text_, "AB");
  EXPECT_THAT(transport->take_event().value_or(""),
              testing::AllOf(testing::HasSubstr("left out: 2 unreadable lines"),
                             testing::HasSubstr("line 2: ")));
  EXPECT_FALSE(transport->take_event());
}

// Drivers of CAN devices and of the network have no baud rate.
TEST_F(PlaybackTest, WhatIsNoRecordingIsRefused) {
  const auto refused = [](const std::string& name, std::uint32_t baud) -> std::string {
    const auto opened =
        open_transport(*DeviceAddress::parse("play:" DEVICE_DATA "/play/" + name), baud);
    return opened ? "" : opened.error().message();
  };
  EXPECT_THAT(refused("not-a-recording.txt", 0), testing::HasSubstr("?baud="));
  for (const std::uint32_t baud : {0U, 4800U})
    for (const char* name : {"can-view.log", "can-view-stamped.log"})
      EXPECT_THAT(refused(name, baud), testing::HasSubstr("candump -L")) << name;
  std::ofstream(path_, std::ios::binary) << "";
  const auto empty = open_transport(*DeviceAddress::parse("play:" + path_), 4800);
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error().message(), testing::HasSubstr("is empty"));
  std::ofstream(path_, std::ios::binary) << "0280D602B0690100020080060014\n";
  const auto digits = open_transport(*DeviceAddress::parse("play:" + path_), 4800);
  ASSERT_FALSE(digits);
  EXPECT_THAT(digits.error().message(), testing::HasSubstr("xxd"));
  // With a rate, any bytes can be played.
  EXPECT_TRUE(open_transport(
      *DeviceAddress::parse("play:" DEVICE_DATA "/play/not-a-recording.txt?baud=9600"), 0));
}

TEST_F(PlaybackTest, ALogOfCandumpMayHaveFramesThatDriversCannotUse) {
  const auto played = [&](const std::string& name) {
    arrivals_.clear();
    const auto transport = open_transport(
        *DeviceAddress::parse("play:" DEVICE_DATA "/play/" + name + "?speed=max"), 0);
    EXPECT_TRUE(transport) << transport.error().message();
    EXPECT_TRUE(
        receive_until(**transport, arrivals_, text_, [&] { return (*transport)->is_over(); }));
    return (*transport)->take_event().value_or("");
  };
  EXPECT_EQ(played("can-plain.log"), "");
  EXPECT_EQ(arrivals_.size(), 4U);
  EXPECT_THAT(played("can-fd-mixed.log"), testing::HasSubstr("left out: 1 frame of CAN FD"));
  EXPECT_EQ(arrivals_.size(), 3U);
  EXPECT_THAT(played("can-direction.log"), testing::HasSubstr("left out: 1 error frame"));
  ASSERT_EQ(arrivals_.size(), 5U);
  EXPECT_FALSE(arrivals_[0].is_sent);
  EXPECT_TRUE(arrivals_[1].is_sent);
}

TEST_F(PlaybackTest, OneOfSeveralInterfacesCanBeChosen) {
  constexpr std::string_view kLog = "(1.0) can0 181#41\n(1.1) can1 181#42\n(1.2) can0 181#43\n";
  auto both = play(kLog, "?speed=max");
  ASSERT_TRUE(receive_until(*both, arrivals_, text_, [&] { return both->is_over(); }));
  EXPECT_EQ(text_, "ABC");
  EXPECT_THAT(both->take_event().value_or(""), testing::HasSubstr("?interface=can0"));
  text_.clear();
  auto one = play(kLog, "?speed=max&interface=can1");
  ASSERT_TRUE(receive_until(*one, arrivals_, text_, [&] { return one->is_over(); }));
  EXPECT_EQ(text_, "B");
  EXPECT_THAT(one->take_event().value_or(""), testing::HasSubstr("left out: 2 frames of can0"));
  auto none = play(kLog, "?speed=max&interface=can7");
  ASSERT_TRUE(receive_until(*none, arrivals_, text_, [&] { return none->is_over(); }));
  EXPECT_THAT(none->take_event().value_or(""), testing::HasSubstr("nothing to play"));
}

TEST_F(PlaybackTest, PacketsOfEveryLinkArePlayed) {
  for (const char* link : {"null", "raw", "sll", "sll2"}) {
    arrivals_.clear();
    const std::string path = DEVICE_DATA "/play/vlp16-" + std::string(link) + ".pcap";
    const auto transport =
        open_transport(*DeviceAddress::parse("play:" + path + "?speed=max&port=2368"), 0);
    ASSERT_TRUE(transport) << link << transport.error().message();
    ASSERT_TRUE(
        receive_until(**transport, arrivals_, text_, [&] { return (*transport)->is_over(); }));
    EXPECT_EQ(arrivals_.size(), 2U) << link;
    EXPECT_EQ(arrivals_.at(0).bytes.size(), 1206U) << link;
    EXPECT_FALSE((*transport)->take_event());
  }
}

TEST_F(PlaybackTest, WhyNoPacketIsPlayedIsStated) {
  const auto remarks = [&](const std::string& path, const std::string& options) {
    const auto transport =
        open_transport(*DeviceAddress::parse("play:" + path + "?speed=max" + options), 0);
    if (!transport) return transport.error().message();
    EXPECT_TRUE(
        receive_until(**transport, arrivals_, text_, [&] { return (*transport)->is_over(); }));
    return (*transport)->take_event().value_or("");
  };
  const std::string whole = DEVICE_DATA "/play/vlp16-raw.pcap";
  EXPECT_THAT(remarks(whole, "&port=7502"), testing::HasSubstr("but 2 of port 2368"));
  std::ifstream file(whole, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(file)), {});
  const auto rewritten = [&](std::string_view bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return path_;
  };
  EXPECT_THAT(remarks(rewritten(std::string_view(content).substr(0, content.size() - 5)), ""),
              testing::HasSubstr("the end of the file"));
  content[20] = 105;  // IEEE 802.11
  EXPECT_THAT(remarks(rewritten(content), ""), testing::HasSubstr("IEEE802_11 cannot be read"));
}

TEST_F(PlaybackTest, APacketCaptureGivesThePayloadsOfItsPort) {
  const auto transport = open_transport(*DeviceAddress::parse("play:" DEVICE_DATA "/vlp16.pcap"
                                                              "?speed=max&port=2368"),
                                        0);
  ASSERT_TRUE(transport) << transport.error().message();
  ASSERT_TRUE(
      receive_until(**transport, arrivals_, text_, [&] { return (*transport)->is_over(); }));
  ASSERT_EQ(arrivals_.size(), 1U);
  EXPECT_EQ(text_.size(), 1212U);  // length in the UDP header
}

}  // namespace playback_test
}  // namespace rack::device
