// Sensor data are compressed on links: what arrives is what was sent, fewer bytes travel, and
// nothing of it touches other messages.
#include <array>
#include <map>
#include <random>

#include "router/compression/sample_bytes.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_compressed {

constexpr std::uint64_t kMbit = 125'000;

// Compression as configured on the links of all routers.
struct Compressed : Story {
  explicit Compressed(core::Compression all = core::Compression::kAuto) : Story(1, {}, all) {
    begin();
  }
  static const link::PackingCounters& counters(Node& node, const char* peer) {
    const link::PackingCounters* found = nullptr;
    node.links().for_each([&](const link::Link& link) {
      if (link.peer().name.view() == peer) found = &link.packing();
    });
    return *found;
  }
  static std::uint64_t bytes_to(Node& node, const char* peer) {
    std::uint64_t bytes = 0;
    node.links().for_each([&](const link::Link& link) {
      if (link.peer().name.view() == peer) bytes = link.session().counters().bytes_out;
    });
    return bytes;
  }
  static Header data(Address src, std::int8_t type = type::kData, std::uint8_t priority = 30) {
    return {
        .flags = flag::kNativeOrder, .type = type, .priority = priority, .dest = kGui, .src = src};
  }
  // What arrives at the GUI of a message of the camera, which is two links away.
  std::vector<std::byte> to_gui(const Header& header, std::span<const std::byte> body) {
    base->forget_arrivals(gui);
    host->send(now(), camera, header, body);
    EXPECT_TRUE(run_until([&] { return !base->arrivals(gui).empty(); }, 2s));
    if (base->arrivals(gui).empty()) return {};
    const Arrival& arrival = base->arrivals(gui).front();
    EXPECT_EQ(arrival.header.length, kHeaderSize + arrival.body.size());
    EXPECT_EQ(arrival.header.src, header.src);
    return arrival.body;
  }
};

TEST(Compression, TravelsOverTwoLinksAndIsUndoneWhereItIsDelivered) {
  Compressed story;
  for (const std::size_t size : {600U, 5784U, 43'248U, 1U << 20}) {
    for (const std::uint8_t flags : {std::uint8_t{0}, flag::kStream, flag::kTrace}) {
      Header header = Compressed::data(kCamera);
      header.flags |= flags;
      const auto body = compression::scan_like(size, flags);
      EXPECT_EQ(story.to_gui(header, body), body) << size;
    }
  }
  EXPECT_EQ(Compressed::counters(*story.host, "robot").packed, 12U);
  EXPECT_EQ(Compressed::counters(*story.robot, "host").passed, 12U)
      << "not decompressed on its way";
  EXPECT_EQ(Compressed::counters(*story.robot, "base").packed, 0U) << "nor compressed again";
  EXPECT_EQ(Compressed::counters(*story.base, "robot").unpacked, 12U);
  EXPECT_LT(Compressed::bytes_to(*story.host, "robot"), 4'000'000U / 3);
}

// Between the robot and the base it is switched off: the robot decompresses.
TEST(Compression, EndsWhereTheNextLinkDoesNotWantIt) {
  Compressed story;
  std::vector<link::LinkSettings> plain = story.robot->setup().links;
  for (link::LinkSettings& settings : plain) settings.packing.compress = core::Compression::kOff;
  story.robot->links().configure(story.now(), plain);
  const auto body = compression::scan_like(6000, 1);
  EXPECT_EQ(story.to_gui(Compressed::data(kCamera), body), body);
  EXPECT_EQ(Compressed::counters(*story.host, "robot").packed, 1U);
  EXPECT_EQ(Compressed::counters(*story.robot, "host").unpacked, 1U);
  EXPECT_EQ(Compressed::counters(*story.base, "robot").unpacked, 0U);
}

TEST(Compression, NeverMakesAMessageLarger) {
  Compressed story;
  const auto body = compression::noise(8000);
  EXPECT_EQ(story.to_gui(Compressed::data(kCamera), body), body);
  EXPECT_EQ(Compressed::counters(*story.host, "robot").packed, 0U);
  EXPECT_EQ(Compressed::counters(*story.host, "robot").incompressible, 1U);
}

// One datagram holds dozens of them, and all are read until the turn ends.
TEST(Compression, ManySmallMessagesThatCompressWellAllArrive) {
  Compressed story(core::Compression::kLz4);
  constexpr std::size_t kMany = 2000;
  const std::vector<std::byte> body(1000);
  for (std::size_t i = 0; i < kMany; ++i)
    ASSERT_EQ(story.host->send(story.now(), story.camera, Compressed::data(kCamera), body),
              core::Outcome::kDelivered);
  EXPECT_TRUE(story.run_until([&] { return story.base->arrivals(story.gui).size() == kMany; }, 2s))
      << story.base->arrivals(story.gui).size();
  EXPECT_GT(Compressed::counters(*story.host, "robot").packed, kMany - 100);
}

// An attacker who can put text into a message and sees the sizes of encrypted datagrams guesses a
// secret beside it, letter by letter (CRIME). For excluded kinds there is nothing to see.
TEST(Compression, SizesTellNothingAboutExcludedKinds) {
  Compressed story(core::Compression::kZstd);
  const std::string secret = "password=correct horse battery staple;";
  const auto body_with = [&](const std::string& guess) {
    std::string text = secret + std::string(1000, 'x') + guess;
    text.resize(2000, 'y');
    const auto bytes = std::as_bytes(std::span(text));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  // Without keep-alives and acknowledgements, which come by the clock.
  const auto wire_bytes = [&](Header header, const std::string& guess) {
    header.flags |= flag::kStream;  // sent once
    const std::uint64_t before = Compressed::bytes_to(*story.host, "robot");
    story.host->send(story.now(), story.camera, header, body_with(guess));
    story.host->end_turn(story.now());
    const std::uint64_t bytes = Compressed::bytes_to(*story.host, "robot") - before;
    story.run_for(100ms);
    return bytes;
  };
  const std::string wrong = "password=incorrect horses from a stable;";
  const auto shows = [&](const Header& header) {
    const std::uint64_t right_bytes = wire_bytes(header, secret);
    return right_bytes != wire_bytes(header, wrong);
  };
  Header text = Compressed::data(kCamera, type::kData, 0);
  text.dest = text_sink();
  EXPECT_FALSE(shows(text));
  EXPECT_FALSE(shows(Compressed::data(kCamera, type::kAdminReply)));
  EXPECT_FALSE(shows(Compressed::data(kCamera, type::kParam)));
  EXPECT_FALSE(shows(Compressed::data(kCamera, 20))) << "a command";
  EXPECT_FALSE(shows(Compressed::data(kCamera, type::kData, 50))) << "urgent";
  EXPECT_TRUE(shows(Compressed::data(kCamera))) << "the test sees what there is to see";
}

// A robot with a key that sends what no honest router does.
TEST(Compression, BombsAndDamagedMessagesCostNothing) {
  Compressed story;
  const std::size_t memory = story.base->memory_in_use();
  const auto forge = [&](std::uint8_t method, std::uint8_t stride, std::uint32_t size,
                         std::size_t compressed) {
    std::vector<std::byte> body(8 + compressed, std::byte{0x5A});
    body[0] = static_cast<std::byte>(method);
    body[1] = static_cast<std::byte>(stride);
    for (std::size_t i = 0; i < 4; ++i) body[4 + i] = static_cast<std::byte>(size >> 8 * i);
    std::vector<std::byte> bytes(kHeaderSize + body.size());
    std::ranges::copy(body, bytes.begin() + kHeaderSize);
    Header header = Compressed::data(kLadar);
    header.length = static_cast<std::uint32_t>(bytes.size());
    core::Message message{.header = header, .bytes = bytes, .packed = true};
    story.robot->router().on_message(story.now(), story.ladar, message);
    story.robot->end_turn(story.now());
    story.run_for(50ms);
  };
  forge(1, 0, 0xFFFFFFFF, 600);
  forge(1, 0, 1U << 20, 600);
  forge(0, 48, 100'000, 600);
  forge(0x80, 0, 3000, 600);
  forge(2, 1, 3000, 600);
  forge(0, 49, 3000, 600);
  forge(1, 16, 16, 600);
  forge(1, 16, 3000, 0);
  EXPECT_EQ(Compressed::counters(*story.base, "robot").broken, 8U);
  EXPECT_TRUE(story.base->arrivals(story.gui).empty());
  EXPECT_LE(story.base->memory_in_use(), memory);
  EXPECT_TRUE(story.links_up(*story.base) == 2U);
  const auto body = compression::scan_like(5000, 1);
  EXPECT_EQ(story.to_gui(Compressed::data(kCamera), body), body);
}

// Ladar scans over a slow line: more of them arrive, and urgent messages do not wait for them.
TEST(Compression, AScannerNeedsLessOfASlowLink) {
  const auto scans = [](core::Compression how) {
    Compressed story(how);
    story.set_faults({.delay = 1ms, .rate = 10 * kMbit});
    story.run_for(2s);
    story.base->forget_arrivals(story.gui);
    for (unsigned i = 0; i < 2000; ++i) {  // 5.8 kB every millisecond: 46 Mbit/s
      Header header = Compressed::data(kCamera);
      header.flags |= flag::kStream;
      story.host->send(story.now(), story.camera, header, compression::scan_like(5784, i));
      story.run_for(1ms);
    }
    return story.base->arrivals(story.gui).size();
  };
  const std::size_t plain = scans(core::Compression::kOff);
  EXPECT_GT(plain, 200U);
  EXPECT_GE(scans(core::Compression::kAuto), 3 * plain);
}

}  // namespace stories_compressed
}  // namespace tims::sim
