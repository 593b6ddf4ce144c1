// Uses tims.h as a C program would.
#include <csignal>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tims.h"

namespace tims::test {
namespace c_api_test {

class CApiTest : public testing::Test {
 protected:
  explicit CApiTest(std::vector<std::string> settings = {}) : router_(std::move(settings)) {}
  void SetUp() override {
    ASSERT_TRUE(router_.start().ok());
    session_ = tims_connect(router_.socket_path().c_str(), "c-test", kPatience.count());
    ASSERT_NE(session_, nullptr) << tims_error_text();
  }
  void TearDown() override { tims_disconnect(session_); }

  static tims_mailbox_options options_for(std::uint32_t address, std::uint32_t slots = 4,
                                          std::uint8_t event_fd = 0) {
    return {address, slots, 64, event_fd, {}, 0};
  }
  tims_mailbox* open(std::uint32_t address, std::uint8_t event_fd = 0) {
    const tims_mailbox_options options = options_for(address, 4, event_fd);
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

TEST_F(CApiTest, ErrorsHaveCodesAndTexts) {
  tims_mailbox* mailbox = open(0x00140000);
  const tims_mailbox_options same = options_for(0x00140000);
  EXPECT_EQ(tims_open(session_, &same), nullptr);
  EXPECT_NE(std::string(tims_error_text()).find("Ladar(0/0)"), std::string::npos);
  EXPECT_EQ(tims_error_code(), TIMS_EADDRESS_IN_USE);
  EXPECT_STREQ(tims_error_name(tims_error_code()), "address_in_use");
  EXPECT_STREQ(tims_error_name(0), "unknown");
  EXPECT_STREQ(tims_error_name(INT32_MIN), "unknown");
  const tims_mailbox_options impossible = options_for(5, 0);
  EXPECT_EQ(tims_open(session_, &impossible), nullptr);
  EXPECT_EQ(tims_error_code(), TIMS_EINVALID);
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
  EXPECT_EQ(tims_error_code(), TIMS_ETIMEOUT);
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

TEST_F(CApiTest, BodiesFromSeveralPieces) {
  tims_mailbox* mailbox = open(1);
  const tims_header to_self{1, 0, 0, TIMS_REPORT_IF_GONE | TIMS_REPORT_REASON, -6, 0, 0};
  std::vector<tims_piece> pieces{{"ab", 2}, {nullptr, 0}, {"c", 1}};
  ASSERT_EQ(tims_send_pieces(mailbox, &to_self, pieces.data(), pieces.size()), 0);
  tims_header header{};
  char buffer[200];
  ASSERT_EQ(tims_receive(mailbox, &header, buffer, sizeof buffer, 0), 3);
  EXPECT_EQ(std::string(buffer, 3), "abc");
  EXPECT_EQ(header.flags & to_self.flags, to_self.flags);
  pieces.assign(100, {"", 0});
  pieces.front() = {"many", 4};
  ASSERT_EQ(tims_send_pieces(mailbox, &to_self, pieces.data(), pieces.size()), 0);
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), 4);
  pieces.assign(65, {"x", 1});
  EXPECT_EQ(tims_send_pieces(mailbox, &to_self, pieces.data(), pieces.size()), TIMS_ETOO_BIG);
  tims_close(mailbox);
}

TEST_F(CApiTest, SendsOnlyWhatNeedNotWait) {
  tims_mailbox* mailbox = open(1);
  const tims_header to_self{1, 0, 0, 0, -6, 0, 0};
  EXPECT_EQ(tims_try_send(mailbox, &to_self, "new", 3),
            TIMS_ETIMEOUT);  // the router would be asked
  ASSERT_EQ(tims_send(mailbox, &to_self, "known", 5), 0) << tims_error_text();
  EXPECT_EQ(tims_try_send(mailbox, &to_self, "now", 3), 0) << tims_error_text();
  char buffer[64];
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), 5);
  EXPECT_EQ(tims_receive(mailbox, nullptr, buffer, sizeof buffer, 0), 3);
  EXPECT_EQ(std::string(buffer, 3), "now");
  EXPECT_EQ(tims_try_send(mailbox, &to_self, buffer, sizeof buffer + 1), TIMS_ETOO_BIG);
  tims_close(mailbox);
}

TEST_F(CApiTest, AnOpenThatIsEndedOpensNothing) {
  const tims_mailbox_options options = options_for(9);
  router_.process().signal(SIGSTOP);
  int asked = 0;
  const auto go_on = [](void* user) { return ++*static_cast<int*>(user) < 3 ? 1 : 0; };
  EXPECT_EQ(tims_open_while(session_, &options, go_on, &asked), nullptr);
  EXPECT_EQ(tims_error_code(), TIMS_ETIMEOUT);
  EXPECT_EQ(asked, 3);
  router_.process().signal(SIGCONT);
  tims_mailbox* mailbox = tims_open_while(
      session_, &options, [](void*) { return 1; }, nullptr);
  ASSERT_NE(mailbox, nullptr) << tims_error_text();
  tims_close(mailbox);
}

TEST_F(CApiTest, OpensSeveralMailboxesOrNone) {
  tims_mailbox* both[2] = {};
  const tims_mailbox_options options[] = {options_for(7), options_for(8)};
  ASSERT_EQ(tims_open_all(session_, options, 2, both), 0) << tims_error_text();
  EXPECT_EQ(tims_mailbox_address(both[1]), 8U);
  EXPECT_EQ(tims_mailbox_body_max(both[1]), 64U);
  tims_close(both[0]);
  tims_mailbox* again[2] = {};
  EXPECT_EQ(tims_open_all(session_, options, 2, again), TIMS_EADDRESS_IN_USE);
  EXPECT_EQ(again[0], nullptr);
  tims_close(both[1]);
}

TEST_F(CApiTest, CountersOfAMailbox) {
  tims_mailbox* mailbox = open(1);
  const tims_header to_self{1, 0, 0, 0, -6, 0, 0};
  for (int i = 0; i < 5; ++i) ASSERT_EQ(tims_send(mailbox, &to_self, nullptr, 0), 0);
  EXPECT_EQ(tims_receive(mailbox, nullptr, nullptr, 0, 0), 0);
  tims_counters counters{};
  tims_mailbox_counters(mailbox, &counters);
  EXPECT_EQ(counters.received, 1U);
  EXPECT_EQ(counters.waiting, 3U);
  EXPECT_EQ(counters.replaced, 1U);
  tims_close(mailbox);
}

TEST_F(CApiTest, PropertiesOfASession) {
  EXPECT_STREQ(tims_version(), TIMS_VERSION);
  EXPECT_EQ(tims_is_connected(session_), 1);
  EXPECT_NE(tims_router_address(session_), ~0U);
  char path[8];
  EXPECT_GT(tims_default_router(path, sizeof path), 0U);
  EXPECT_LT(std::strlen(path), sizeof path);
  router_.kill();
  EXPECT_TRUE(
      eventually([&] { return tims_is_connected(session_) == 0; }, "the session is disconnected"));
}

// A negative timeout does not wait, like 0.
TEST_F(CApiTest, NegativeTimeouts) {
  tims_mailbox* mailbox = open(1);
  EXPECT_EQ(tims_receive(mailbox, nullptr, nullptr, 0, -5), TIMS_EEMPTY);
  EXPECT_EQ(tims_peek(mailbox, nullptr, nullptr, INT64_MIN), nullptr);
  EXPECT_EQ(tims_error_code(), TIMS_EEMPTY);
  tims_close(mailbox);
}

// When the call returns, the router has accepted all messages to other clients.
TEST_F(CApiTest, CloseWaitsUntilTheRouterHasAcceptedEverything) {
  auto far = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(far.ok());
  ASSERT_TRUE(far->register_mailbox(Address(9)).ok());
  for (const std::string& endpoint : {router_.socket_path(), router_.tcp()}) {
    tims_session* session = tims_connect(endpoint.c_str(), "lingers", kPatience.count());
    ASSERT_NE(session, nullptr) << tims_error_text();
    const tims_mailbox_options options = options_for(3);
    tims_mailbox* mailbox = tims_open(session, &options);
    ASSERT_NE(mailbox, nullptr) << tims_error_text();
    EXPECT_EQ(tims_flush(session, 0), 0) << "nothing is in transit";
    const tims_header header{9, 0, 0, 0, -6, 0, 0};
    ASSERT_EQ(tims_send(mailbox, &header, "first", 5), 0) << tims_error_text();
    ASSERT_EQ(tims_flush(session, kPatience.count()), 0) << tims_error_text();
    EXPECT_TRUE(far->receive(kPatience).ok()) << endpoint;
    router_.process().signal(SIGSTOP);
    ASSERT_EQ(tims_send(mailbox, &header, "last", 4), 0) << tims_error_text();
    EXPECT_EQ(tims_flush(session, 20'000'000), TIMS_ETIMEOUT);
    router_.process().signal(SIGCONT);
    EXPECT_EQ(tims_close_linger(mailbox, kPatience.count()), 0) << tims_error_text();
    EXPECT_TRUE(far->receive().ok()) << endpoint;
    tims_disconnect(session);
  }
}

TEST(CApiExample, AsksAndAnswers) {
  RouterProcess router;
  ASSERT_TRUE(router.start().ok());
  auto example = ChildProcess::start({TIMS_C_EXAMPLE_PROGRAM, router.socket_path()});
  ASSERT_TRUE(example.ok());
  EXPECT_TRUE(example->wait_for_line("Test(1/2) answers \"what now?\", message 1").ok());
  EXPECT_TRUE(example->wait_for_line("connected 1 time(s)").ok());
  const auto ended = example->wait();
  ASSERT_TRUE(ended.ok());
  EXPECT_TRUE(ended->success()) << example->output();
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
    tims_address_fields fields{};
    tims_split_address(session, 0x03140002, &fields);
    EXPECT_EQ(fields.class_id, 0x14U);
    EXPECT_EQ(fields.local, 2U);
    EXPECT_EQ(tims_make_address(session, &fields), 0x03140002U);
  }
}

TEST_F(CApiTest, ClassesOfOnesOwn) {
  std::uint32_t address = 0;
  EXPECT_EQ(tims_parse_address(session_, "Barometer(0/0)", &address), TIMS_EINVALID);
  EXPECT_EQ(std::string(tims_error_text()),
            "invalid argument: Barometer(0/0) is not an address: no class is called Barometer; "
            "tims_name_class() registers names of your own classes");
  {
    std::string name = "Barometer";
    ASSERT_EQ(tims_name_class(0x90, name.c_str()), 0) << tims_error_text();
    name = "gone";
  }
  EXPECT_EQ(tims_name_class(0x90, "Barometer"), 0) << "again";
  ASSERT_EQ(tims_parse_address(session_, "barometer(2/1)", &address), 0) << tims_error_text();
  EXPECT_EQ(address, 0x02900100U);
  char text[32];
  tims_format_address(session_, address, text, sizeof text);
  EXPECT_STREQ(text, "Barometer(2/1)");
  EXPECT_EQ(tims_name_class(0x14, "Radar"), TIMS_EINVALID) << "that is Ladar's number";
  EXPECT_EQ(tims_name_class(0x91, "ladar"), TIMS_EINVALID) << "that is Ladar's name";
  for (const char* bad : {"", "7up", "a b", "a(b", static_cast<const char*>(nullptr)})
    EXPECT_EQ(tims_name_class(0x91, bad), TIMS_EINVALID);
}

// A fleet with few robots and many components of each class.
struct CApiWidthsTest : CApiTest {
  CApiWidthsTest() : CApiTest({"address.widths=6/8/10/8"}) {}
};

TEST_F(CApiWidthsTest, AddressesUseTheWidthsOfTheFleet) {
  std::uint32_t address = 0;
  ASSERT_EQ(tims_parse_address(session_, "Ladar(3/500):2", &address), 0) << tims_error_text();
  EXPECT_EQ(address, 3U << 26 | 0x14U << 18 | 500U << 8 | 2U);
  char text[32];
  tims_format_address(session_, address, text, sizeof text);
  EXPECT_STREQ(text, "Ladar(3/500):2");
  EXPECT_EQ(tims_parse_address(session_, "Ladar(64/0)", &address), TIMS_EINVALID);
}

}  // namespace c_api_test
}  // namespace tims::test
