// The C API on top of Session and Mailbox: nothing else happens here.
#include <cstring>
#include <new>

#include "tims.h"
#include "tims/session.h"

using tims::Address;
using tims::Errc;
using tims::Error;
using tims::Header;

struct tims_session {
  tims::Session session;
};
struct tims_mailbox {
  tims::Mailbox mailbox;
};
struct tims_guard {
  tims::PeekGuard guard;
};
struct tims_loaned {
  tims::Loan loan;
};

static_assert(TIMS_EEMPTY == -1 - static_cast<int>(Errc::kEmpty));
static_assert(TIMS_EFULL == -1 - static_cast<int>(Errc::kFull));
static_assert(TIMS_EMALFORMED == -1 - static_cast<int>(Errc::kMalformed));
static_assert(TIMS_EDISKFULL == -1 - static_cast<int>(Errc::kDiskFull));
static_assert(TIMS_BODY_LITTLE_ENDIAN == tims::flag::kBodyLittleEndian);
static_assert(TIMS_STREAM == tims::flag::kStream);

namespace {

// The one thing per thread: C has nowhere else to put a text.
thread_local std::string last_error;

int fail(const Error& error) {
  last_error = error.message();
  return -1 - static_cast<int>(error.code());
}
std::nullptr_t fail_null(const Error& error) {
  fail(error);
  return nullptr;
}

tims::Duration wait_of(int64_t timeout_ns) { return tims::Duration(timeout_ns); }

std::span<const std::byte> bytes(const void* data, size_t size) {
  return {static_cast<const std::byte*>(data), size};
}

tims::Envelope envelope_of(const tims_header& h) {
  return {.dest = Address(h.dest),
          .type = h.type,
          .priority = h.priority,
          .seq_nr = h.seq_nr,
          .stream = (h.flags & TIMS_STREAM) != 0,
          .trace = (h.flags & TIMS_TRACE) != 0,
          .body_order = static_cast<std::uint8_t>(h.flags & TIMS_BODY_LITTLE_ENDIAN)};
}

tims::AddressWidths widths_of(const tims_session* session) {
  return session == nullptr ? tims::AddressWidths() : session->session.address_widths();
}

void give_header(const Header& from, tims_header* to) {
  if (to != nullptr)
    *to = {from.dest.raw(), from.src.raw(), from.length, from.flags,
           from.type,       from.priority,  from.seq_nr};
}

}  // namespace

const char* tims_error_text(void) { return last_error.c_str(); }

tims_session* tims_connect(const char* router, const char* name, int64_t timeout_ns) {
  tims::SessionOptions options;
  if (router != nullptr) options.router = router;
  if (name != nullptr) options.name = name;
  options.timeout = wait_of(timeout_ns);
  auto session = tims::Session::connect(std::move(options));
  if (!session) return fail_null(session.error());
  return new tims_session{std::move(*session)};
}

void tims_disconnect(tims_session* session) { delete session; }

tims_mailbox* tims_open(tims_session* session, const tims_mailbox_options* options) {
  auto mailbox = session->session.open({.address = Address(options->address),
                                        .slots = options->slots,
                                        .body_max = options->body_max,
                                        .event_fd = options->event_fd != 0});
  if (!mailbox) return fail_null(mailbox.error());
  return new tims_mailbox{std::move(*mailbox)};
}

void tims_close(tims_mailbox* mailbox) { delete mailbox; }

int tims_event_fd(const tims_mailbox* mailbox) { return mailbox->mailbox.event_fd(); }

int tims_send(tims_mailbox* mailbox, const tims_header* header, const void* body,
              size_t body_size) {
  const auto sent = mailbox->mailbox.send(envelope_of(*header), bytes(body, body_size));
  return sent ? 0 : fail(sent.error());
}

int tims_reply(tims_mailbox* mailbox, const tims_header* request, int8_t type, const void* body,
               size_t body_size) {
  const Header to{
      .priority = request->priority, .seq_nr = request->seq_nr, .src = Address(request->src)};
  const auto sent = mailbox->mailbox.reply(to, type, bytes(body, body_size));
  return sent ? 0 : fail(sent.error());
}

tims_loaned* tims_loan(tims_mailbox* mailbox, const tims_header* header, size_t body_size) {
  if (body_size > UINT32_MAX) return fail_null(Errc::kTooBig);
  auto loan = mailbox->mailbox.loan(envelope_of(*header), static_cast<std::uint32_t>(body_size));
  if (!loan) return fail_null(loan.error());
  return new tims_loaned{std::move(*loan)};
}

void* tims_loan_body(tims_loaned* loan) { return loan->loan.body().data(); }

int tims_loan_send(tims_loaned* loan) {
  const auto sent = loan->loan.send();
  delete loan;
  return sent ? 0 : fail(sent.error());
}

void tims_loan_drop(tims_loaned* loan) { delete loan; }

int64_t tims_receive(tims_mailbox* mailbox, tims_header* header, void* buffer, size_t buffer_size,
                     int64_t timeout_ns) {
  const std::span room(static_cast<std::byte*>(buffer), buffer_size);
  const auto received = timeout_ns == 0 ? mailbox->mailbox.try_receive(room)
                                        : mailbox->mailbox.receive_for(room, wait_of(timeout_ns));
  if (!received) return fail(received.error());
  give_header(received->header, header);
  return static_cast<int64_t>(received->body.size());
}

tims_guard* tims_peek(tims_mailbox* mailbox, tims_header* header, const void** body,
                      int64_t timeout_ns) {
  auto guard = timeout_ns == 0 ? mailbox->mailbox.try_peek()
                               : mailbox->mailbox.peek_for(wait_of(timeout_ns));
  if (!guard) return fail_null(guard.error());
  give_header(guard->header(), header);
  if (body != nullptr) *body = guard->body().data();
  return new tims_guard{std::move(*guard)};
}

void tims_release(tims_guard* guard) { delete guard; }

int64_t tims_clean(tims_mailbox* mailbox) { return static_cast<int64_t>(mailbox->mailbox.clean()); }

int tims_parse_address(const tims_session* session, const char* text, uint32_t* address) {
  const auto parsed = Address::parse(text, widths_of(session));
  if (!parsed) {
    std::string problem(text);
    problem += " is no address; write Ladar(3/0) or 0x03140000";
    return fail(Error(Errc::kInvalidArgument, std::move(problem)));
  }
  *address = parsed->raw();
  return 0;
}

size_t tims_format_address(const tims_session* session, uint32_t address, char* buffer,
                           size_t size) {
  const std::string text = Address(address).to_string(widths_of(session));
  if (size > 0) {
    const size_t n = std::min(size - 1, text.size());
    std::memcpy(buffer, text.data(), n);
    buffer[n] = 0;
  }
  return text.size();
}
