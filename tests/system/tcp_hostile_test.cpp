// Guests at the TCP port who do not mean well, or are broken: nobody else notices.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/system/tcp_fixture.h"
#include "wire/header.h"

namespace tims::test {
namespace {

using namespace std::chrono_literals;

constexpr Address kPilot(0x02180000);
constexpr Address kLadar(0x02140000);

class HostileGuestTest : public TcpTest {
 protected:
  // "VmHWM" of the router: the most memory it has ever had.
  std::size_t peak_bytes() {
    std::ifstream status("/proc/" + std::to_string(router_->process().pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("VmHWM:")) return std::stoul(line.substr(6)) * 1024;
    }
    return 0;
  }
  std::size_t descriptors() {
    const std::filesystem::path folder =
        "/proc/" + std::to_string(router_->process().pid()) + "/fd";
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
  }

  static void append_message(std::vector<std::byte>& bytes, Header header, std::string_view body) {
    header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
    bytes.resize(bytes.size() + kHeaderSize);
    wire::encode_header(header, std::span(bytes).last<kHeaderSize>());
    const auto text = bytes_of(body);
    bytes.insert(bytes.end(), text.begin(), text.end());
  }
};

// It once had 572 MB of answers made in one turn of 14 s.
TEST_F(HostileGuestTest, ThousandsOfQuestionsAtOnceAreAnsweredInTurns) {
  constexpr int kQuestions = 8'000;
  start();
  TcpClient guest = connect();
  for (std::uint32_t i = 0; i < 1'000; ++i) {
    ASSERT_TRUE(guest.register_mailbox(Address(0x02100000 + i)).ok());
  }
  TcpClient bystander = connect_with(kPilot);
  const std::size_t before = peak_bytes();

  std::vector<std::byte> questions;
  for (int i = 0; i < kQuestions; ++i)
    append_message(questions, {.type = type::kAdminRequest}, R"({"ask":"routes"})");
  ASSERT_TRUE(guest.send_bytes(questions).ok());
  EXPECT_TRUE(reaches(bystander, kPilot, bystander, kPilot));

  int answers = 0;
  int busy = 0;
  while (answers + busy < kQuestions) {
    const auto answer = guest.receive();
    ASSERT_TRUE(answer.ok()) << answers << " " << busy << " " << answer.error().message();
    const std::string_view text(reinterpret_cast<const char*>(answer->body.data()),
                                answer->body.size());
    ++(text.find(R"("busy")") != std::string_view::npos ? busy : answers);
  }
  EXPECT_GE(answers, 64);
  EXPECT_LT(peak_bytes() - before, std::size_t{64} << 20);
}

}  // namespace
}  // namespace tims::test
