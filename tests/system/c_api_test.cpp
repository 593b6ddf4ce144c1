// tims.h, used as a C program would.
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/support/router_process.h"
#include "tims.h"

namespace tims::test {
namespace {

class CApiTest : public testing::Test {
 protected:
  explicit CApiTest(std::vector<std::string> settings = {}) : router_(std::move(settings)) {}
  void SetUp() override {
    ASSERT_TRUE(router_.start().ok());
    session_ = tims_connect(router_.socket_path().c_str(), "c-test", kPatience.count());
    ASSERT_NE(session_, nullptr) << tims_error_text();
  }
  void TearDown() override { tims_disconnect(session_); }

  tims_mailbox* open(std::uint32_t address, std::uint8_t event_fd = 0) {
    const tims_mailbox_options options{address, 4, 64, event_fd};
    tims_mailbox* mailbox = tims_open(session_, &options);
    EXPECT_NE(mailbox, nullptr) << tims_error_text();
    return mailbox;
  }

  RouterProcess router_;
  tims_session* session_ = nullptr;
};

TEST_F(CApiTest, RequestAndReply) {
  tims_mailbox* client = open(1);
  tims_mailbox* server = open(2);
  const tims_header request{2, 0, 0, TIMS_BODY_LITTLE_ENDIAN, 21, 7, 42};
  ASSERT_EQ(tims_send(client, &request, "ask", 3), 0) << tims_error_text();

  tims_header header{};
  char buffer[64];
  ASSERT_EQ(tims_receive(server, &header, buffer, sizeof buffer, TIMS_FOREVER), 3);
  EXPECT_EQ(std::string(buffer, 3), "ask");
  EXPECT_EQ(header.src, 1U);
  EXPECT_EQ(header.dest, 2U);
  EXPECT_EQ(header.type, 21);
  EXPECT_EQ(header.priority, 7);
  EXPECT_EQ(header.seq_nr, 42);
  EXPECT_EQ(header.length, 19U);

  ASSERT_EQ(tims_reply(server, &header, 0, "answer", 6), 0);
  const void* body = nullptr;
  tims_guard* guard = tims_peek(client, &header, &body, kPatience.count());
  ASSERT_NE(guard, nullptr) << tims_error_text();
  EXPECT_EQ(std::string(static_cast<const char*>(body), 6), "answer");
  EXPECT_EQ(header.seq_nr, 42);
  tims_release(guard);
  tims_close(client);
  tims_close(server);
}

TEST_F(CApiTest, Loans) {
  tims_mailbox* mailbox = open(1);
  const tims_header to_self{1, 0, 0, TIMS_STREAM, -6, 0, 0};
  tims_loaned* dropped = tims_loan(mailbox, &to_self, 4);
  tims_loan_drop(dropped);
  tims_loaned* loan = tims_loan(mailbox, &to_self, 4);
  ASSERT_NE(loan, nullptr) << tims_error_text();
  std::memcpy(tims_loan_body(loan), "abcd", 4);
  ASSERT_EQ(tims_loan_send(loan), 0);
  tims_header header{};
  char buffer[4];
  ASSERT_EQ(tims_receive(mailbox, &header, buffer, sizeof buffer, 0), 4);
  EXPECT_EQ(std::memcmp(buffer, "abcd", 4), 0);
  EXPECT_EQ(header.flags & TIMS_STREAM, TIMS_STREAM);
  EXPECT_EQ(tims_loan(mailbox, &to_self, 65), nullptr);
  tims_close(mailbox);
}

TEST_F(CApiTest, ErrorsHaveCodesAndSentences) {
  tims_mailbox* mailbox = open(0x00140000);
  const tims_mailbox_options same{0x00140000, 4, 64, 0};
  EXPECT_EQ(tims_open(session_, &same), nullptr);
  EXPECT_NE(std::string(tims_error_text()).find("Ladar(0/0)"), std::string::npos);
  const tims_mailbox_options impossible{5, 0, 64, 0};
  EXPECT_EQ(tims_open(session_, &impossible), nullptr);
  char buffer[4];
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), TIMS_EEMPTY);
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 1'000'000), TIMS_ETIMEOUT);
  const tims_header to_self{0x00140000, 0, 0, 0, -6, 0, 0};
  const char large[65] = {};
  EXPECT_EQ(tims_send(mailbox, &to_self, large, sizeof large), TIMS_ETOO_BIG);
  EXPECT_EQ(tims_send(mailbox, &to_self, large, 5), 0);
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, 4, 0), TIMS_EBUFFER_TOO_SMALL);
  EXPECT_EQ(tims_clean(mailbox), 1);
  tims_close(mailbox);
  EXPECT_EQ(tims_connect("/nowhere/router.sock", "late", 1'000'000), nullptr);
  EXPECT_NE(std::string(tims_error_text()).find("/nowhere/router.sock"), std::string::npos);
}

TEST_F(CApiTest, EventFd) {
  tims_mailbox* mailbox = open(1, 1);
  pollfd wait{tims_event_fd(mailbox), POLLIN, 0};
  char buffer[64];
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), TIMS_EEMPTY);
  EXPECT_EQ(::poll(&wait, 1, 0), 0);
  const tims_header to_self{1, 0, 0, 0, -6, 0, 0};
  ASSERT_EQ(tims_send(mailbox, &to_self, "x", 1), 0);
  EXPECT_EQ(::poll(&wait, 1, kPatienceMs), 1);
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), 1);
  tims_close(mailbox);
}

TEST_F(CApiTest, Addresses) {
  for (const tims_session* session : {session_, static_cast<tims_session*>(nullptr)}) {
    std::uint32_t address = 0;
    ASSERT_EQ(tims_parse_address(session, "Ladar(3/0)", &address), 0);
    EXPECT_EQ(address, 0x03140000U);
    EXPECT_EQ(tims_parse_address(session, "Ladar(3", &address), TIMS_EINVALID);
    EXPECT_EQ(tims_parse_address(session, "Ladar(3/500)", &address), TIMS_EINVALID);
    char text[8];
    EXPECT_EQ(tims_format_address(session, 0x03140000, text, sizeof text), 10U);
    EXPECT_STREQ(text, "Ladar(3");
    EXPECT_EQ(tims_format_address(session, 0x03140000, nullptr, 0), 10U);
  }
}

// A fleet with few robots and many components of a kind.
struct CApiWidthsTest : CApiTest {
  CApiWidthsTest() : CApiTest({"address.widths=6/8/10/8"}) {}
};

TEST_F(CApiWidthsTest, AddressesAreDividedAsTheFleetDividesThem) {
  std::uint32_t address = 0;
  ASSERT_EQ(tims_parse_address(session_, "Ladar(3/500):2", &address), 0) << tims_error_text();
  EXPECT_EQ(address, 3U << 26 | 0x14U << 18 | 500U << 8 | 2U);
  char text[32];
  tims_format_address(session_, address, text, sizeof text);
  EXPECT_STREQ(text, "Ladar(3/500):2");
  EXPECT_EQ(tims_parse_address(session_, "Ladar(64/0)", &address), TIMS_EINVALID);
}

}  // namespace
}  // namespace tims::test
