#include "tims/session.h"

#include "client/mailbox_core.h"
#include "client/session_core.h"

namespace tims {

Result<Session> Session::connect(SessionOptions options) {
  if (options.router.empty()) options.router = default_router();
  auto router = wire::parse_endpoint(options.router);
  if (!router) return router.error();
  constexpr std::uint32_t kMax = shm::kMessageMax;
  if (options.tcp_message_max < kHeaderSize || options.tcp_message_max > kMax)
    return Error(Errc::kInvalidArgument, "tcp_message_max is 16 bytes to 1 GiB");
  auto core = std::make_shared<SessionCore>(std::move(options), std::move(*router));
  if (auto connected = core->connect(); !connected) return connected.error();
  return Session(std::move(core));
}

Session::Session(std::shared_ptr<SessionCore> core) : core_(std::move(core)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Result<Mailbox> Session::open(const MailboxOptions& options) {
  auto mailboxes = open(std::span(&options, 1));
  if (!mailboxes) return mailboxes.error();
  return std::move(mailboxes->front());
}

Result<std::vector<Mailbox>> Session::open(std::span<const MailboxOptions> options) {
  auto segment = core_->open(options);
  if (!segment) return segment.error();
  std::vector<Mailbox> mailboxes;
  mailboxes.reserve(options.size());
  for (std::size_t i = 0; i < options.size(); ++i)
    mailboxes.push_back(Mailbox(std::make_shared<MailboxCore>(core_, *segment, i, options[i])));
  return mailboxes;
}

bool Session::connected() const { return core_->connected(); }
Address Session::router() const { return core_->welcome().router; }
AddressWidths Session::address_widths() const { return core_->welcome().widths; }

}  // namespace tims
