#include "tims/mailbox.h"

#include <cstring>
#include <utility>

#include "client/mailbox_core.h"
#include "os/clock.h"

namespace tims {

// --- what is handed out ---

PeekGuard& PeekGuard::operator=(PeekGuard&& other) noexcept {
  std::swap(core_, other.core_);
  std::swap(slot_, other.slot_);
  std::swap(header_, other.header_);
  std::swap(body_, other.body_);
  return *this;
}

void PeekGuard::release() {
  if (core_ == nullptr) return;
  core_->release(shm::Hint::unpack(slot_));
  core_ = nullptr;
}

Loan::Loan(Loan&& other) noexcept
    : core_(std::exchange(other.core_, nullptr)),
      target_(other.target_),
      word_(other.word_),
      index_(other.index_),
      header_(other.header_),
      body_(other.body_) {}

Loan& Loan::operator=(Loan&& other) noexcept {
  std::swap(core_, other.core_);
  std::swap(target_, other.target_);
  std::swap(word_, other.word_);
  std::swap(index_, other.index_);
  std::swap(header_, other.header_);
  std::swap(body_, other.body_);
  return *this;
}

Loan::~Loan() {
  if (core_ != nullptr)
    target_->sender.give_up({.index = index_, .word = shm::SlotWord::unpack(word_)});
}

Result<void> Loan::send() {
  if (core_ == nullptr) return Error(Errc::kInvalidArgument, "the loan was sent already");
  const shm::Claim claim{.index = index_,
                         .word = shm::SlotWord::unpack(word_),
                         .header = target_->sender.view().message_header(index_)};
  body_ = {};
  return std::exchange(core_, nullptr)->commit({target_, claim, header_});
}

// --- the mailbox ---

Mailbox::Mailbox(std::shared_ptr<MailboxCore> core) : core_(std::move(core)) {}
Mailbox::Mailbox(Mailbox&&) noexcept = default;

Mailbox& Mailbox::operator=(Mailbox&& other) noexcept {
  std::swap(core_, other.core_);
  return *this;
}

Mailbox::~Mailbox() {
  if (core_ != nullptr) core_->close();
}

Address Mailbox::address() const { return core_->address(); }
std::uint32_t Mailbox::body_max() const { return core_->body_max(); }
AddressWidths Mailbox::address_widths() const { return core_->address_widths(); }
MailboxCounters Mailbox::counters() const { return core_->counters(); }
int Mailbox::event_fd() const { return core_->event_fd(); }
std::size_t Mailbox::clean() { return core_->clean(); }

Result<void> Mailbox::send(const Envelope& envelope, std::span<const std::byte> body) {
  return send(envelope, std::span(&body, 1));
}

Result<void> Mailbox::send(const Envelope& envelope,
                           std::span<const std::span<const std::byte>> pieces) {
  std::size_t size = 0;
  for (const auto& piece : pieces) size += piece.size();
  MailboxCore::Draft draft;
  if (auto claimed = core_->claim(envelope, size, draft); !claimed) return claimed;
  std::byte* to = draft.claim.body;
  for (const auto& piece : pieces) {
    if (!piece.empty()) std::memcpy(to, piece.data(), piece.size());
    to += piece.size();
  }
  return core_->commit(draft);
}

Result<void> Mailbox::reply(const Header& request, std::int8_t type,
                            std::span<const std::byte> body) {
  return send(
      {.dest = request.src, .type = type, .priority = request.priority, .seq_nr = request.seq_nr},
      body);
}

Result<Loan> Mailbox::loan(const Envelope& envelope, std::uint32_t body_size) {
  MailboxCore::Draft draft;
  if (auto claimed = core_->claim(envelope, body_size, draft); !claimed) return claimed.error();
  Loan loan;
  loan.core_ = core_.get();
  loan.target_ = draft.target;
  loan.word_ = draft.claim.word.pack();
  loan.index_ = draft.claim.index;
  loan.header_ = draft.header;
  loan.body_ = {draft.claim.body, body_size};
  return loan;
}

namespace {

Result<MessageView> copy_out(MailboxCore& core, Result<shm::Taken> taken,
                             std::span<std::byte> buffer) {
  if (!taken) return taken.error();
  if (taken->body.size() > buffer.size()) {
    core.put_back(*taken);
    return Errc::kBufferTooSmall;
  }
  const auto to = buffer.first(taken->body.size());
  if (!to.empty()) std::memcpy(to.data(), taken->body.data(), to.size());
  core.release(taken->hint);
  return MessageView{taken->header, to};
}

}  // namespace

Result<MessageView> Mailbox::receive(std::span<std::byte> buffer) {
  return copy_out(*core_, core_->take_before(kNever), buffer);
}
Result<MessageView> Mailbox::receive_for(std::span<std::byte> buffer, Duration timeout) {
  return copy_out(*core_, core_->take_before(os::deadline_after(timeout)), buffer);
}
Result<MessageView> Mailbox::try_receive(std::span<std::byte> buffer) {
  return copy_out(*core_, core_->try_take(), buffer);
}

Result<PeekGuard> Mailbox::guard(Result<shm::Taken> taken) {
  if (!taken) return taken.error();
  PeekGuard guard;
  guard.core_ = core_.get();
  guard.slot_ = taken->hint.pack();
  guard.header_ = taken->header;
  guard.body_ = taken->body;
  return guard;
}

Result<PeekGuard> Mailbox::peek() { return guard(core_->take_before(kNever)); }
Result<PeekGuard> Mailbox::peek_for(Duration timeout) {
  return guard(core_->take_before(os::deadline_after(timeout)));
}
Result<PeekGuard> Mailbox::try_peek() { return guard(core_->try_take()); }

}  // namespace tims
