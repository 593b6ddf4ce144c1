// A camera of a simulated robot as clients see it: pictures by HTTP, at its rate, of a world that
// goes on whatever its clients do.
#include <array>
#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "components/pictures/jpeg.h"
#include "os/clock.h"
#include "rack/proxies/world.h"
#include "tests/support/tcp_socket.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace world_camera_test {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::string_view kWorldFile = R"(
ceiling = 2500
[[plan]]
file = "PLAN"
[[people.walk]]
places = [[6800, 0], [3500, 0]]
pause = "0s"
[[robot]]
name = "scout"
at = [0, 0, 0]
[[robot.sensor]]
name = "camera"
kind = "camera"
at = [160, 0, 0]
height = 600
size = [320, 240]
rate = 20
device = "ip-camera"
line = "tcp:ENDPOINT"
)";

class WorldCameraTest : public RobotTest {
 protected:
  void SetUp() override {
    RobotTest::SetUp();
    const auto listener = listen_tcp();
    ASSERT_TRUE(listener) << listener.error().message();
    endpoint_ = listener->endpoint();
    std::string text(kWorldFile);
    for (const auto& [what, with] :
         {std::pair<std::string, std::string>{"PLAN", FLOOR_PLAN}, {"ENDPOINT", endpoint_}})
      text.replace(text.find(what), what.size(), with);
    std::ofstream(folder_.path() / "world.toml") << text;
  }
  void start_world() {
    start("World", {"--file=" + (folder_.path() / "world.toml").string(), "--period=20"});
    ASSERT_TRUE(turned_on("World(0/0)"));
  }

  // A client that has asked for this.
  os::File asking(const std::string& path) {
    auto socket = connect_tcp(endpoint_, kPatience);
    EXPECT_TRUE(socket) << socket.error().message();
    if (!socket) return {};
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: robot\r\n\r\n";
    EXPECT_EQ(::send(socket->get(), request.data(), request.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(request.size()));
    return std::move(*socket);
  }
  // What comes until the text is in it this often.
  static std::string received(const os::File& socket, std::string_view text, int times) {
    std::string all;
    const auto count = [&] {
      int found = 0;
      for (auto at = all.find(text); at != std::string::npos; at = all.find(text, at + 1)) ++found;
      return found;
    };
    for (const Time end = os::now() + kPatience; count() < times && os::now() < end;) {
      pollfd wait{.fd = socket.get(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 100);
      std::array<char, 65536> bytes{};
      const ssize_t size = ::recv(socket.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
      if (size == 0) break;
      if (size > 0) all.append(bytes.data(), static_cast<std::size_t>(size));
    }
    EXPECT_EQ(count(), times) << all.substr(0, 200);
    return all;
  }
  rack::WorldProxy world() { return proxy<rack::WorldProxy>("World(0/0)"); }

  TemporaryFolder folder_;
  std::string endpoint_;
};

constexpr std::string_view kPart = "--rack-picture\r\n";

TEST_F(WorldCameraTest, SendsPicturesOfAWorldThatMoves) {
  start_world();
  const os::File client = asking("/");
  const std::string stream = received(client, kPart, 12);
  EXPECT_THAT(stream, StartsWith("HTTP/1.1 200 OK\r\n"));
  rack::pictures::Jpeg decoder;
  std::vector<std::byte> pixels;
  std::set<std::vector<std::byte>> pictures;
  constexpr std::string_view kEndOfHead = "\r\n\r\n";
  for (auto at = stream.find(kPart); at != std::string::npos;) {
    const auto next = stream.find(kPart, at + 1);
    if (next == std::string::npos) break;
    const auto begin = stream.find(kEndOfHead, at) + kEndOfHead.size();
    const auto jpeg = std::as_bytes(std::span(stream).subspan(begin, next - 2 - begin));
    const auto size = decoder.decode(jpeg, rack::pictures::PixelLayout::kBgr, 1 << 20, pixels);
    ASSERT_TRUE(size) << size.error().message();
    EXPECT_EQ(size->width, 320U);
    EXPECT_EQ(size->height, 240U);
    pictures.insert(pixels);
    at = next;
  }
  EXPECT_GT(pictures.size(), 8U) << "somebody walks";
}

TEST_F(WorldCameraTest, AClientThatDoesNotReadStopsNothing) {
  start_world();
  const os::File lazy = asking("/");
  received(lazy, kPart, 1);
  for (int i = 0; i < 40; ++i) {
    const auto truth = world().get_next_data();
    ASSERT_TRUE(truth) << truth.error().message();
  }
  const os::File next = asking("/picture.jpg");
  EXPECT_THAT(received(next, "\xFF\xD9", 1), StartsWith("HTTP/1.1 200 OK\r\nContent-Type: image"));
  const os::File wrong = asking("/other");
  EXPECT_THAT(received(wrong, "\r\n\r\n", 1), HasSubstr("404"));
}

TEST_F(WorldCameraTest, CanBeUnplugged) {
  start_world();
  const os::File client = asking("/");
  received(client, kPart, 1);
  ASSERT_TRUE(world().plug("scout", "camera", false).ok());
  EXPECT_FALSE(connect_tcp(endpoint_, 1s));
  ASSERT_TRUE(world().plug("scout", "camera", true).ok());
  const os::File again = asking("/");
  received(again, kPart, 2);
}

}  // namespace world_camera_test
}  // namespace tims::test
