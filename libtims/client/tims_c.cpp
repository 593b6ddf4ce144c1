// The C API: a thin layer on top of Session and Mailbox.
#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include "tims.h"
#include "tims/origin.h"
#include "tims/session.h"

using tims::Address;
using tims::Errc;
using tims::Error;
using tims::Header;
using tims::Result;
using Kind = tims::SessionEvent::Kind;

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
static_assert(TIMS_HEADER_SIZE == tims::kHeaderSize);
static_assert(TIMS_BODY_LITTLE_ENDIAN == tims::flag::kBodyLittleEndian);
static_assert(TIMS_STREAM == tims::flag::kStream);
static_assert(TIMS_TRACE == tims::flag::kTrace);
static_assert(TIMS_REPORT_IF_GONE == tims::flag::kReportIfGone);
static_assert(TIMS_REPORT_REASON == tims::flag::kReportReason);
static_assert(TIMS_FOREIGN == tims::flag::kForeign);
static_assert(TIMS_EVENT_WAITING == static_cast<int>(Kind::kWaiting));
static_assert(TIMS_EVENT_CONNECTED == static_cast<int>(Kind::kConnected));
static_assert(TIMS_EVENT_LOST == static_cast<int>(Kind::kLost));
static_assert(TIMS_EVENT_MAILBOX_LOST == static_cast<int>(Kind::kMailboxLost));
static_assert(TIMS_EVENT_MESSAGES_LOST == static_cast<int>(Kind::kMessagesLost));

namespace {

// Per thread, because a C function has no other place to return a text.
struct Failure {
  int code = 0;
  std::string text;
};
thread_local Failure last_failure;

int fail(const Error& error) {
  last_failure = {-1 - static_cast<int>(error.code()), error.message()};
  return last_failure.code;
}
std::nullptr_t fail_null(const Error& error) {
  fail(error);
  return nullptr;
}
int outcome(const Result<void>& result) { return result ? 0 : fail(result.error()); }

tims::Duration wait_of(int64_t timeout_ns) {
  return tims::Duration(std::max<int64_t>(timeout_ns, 0));
}

std::span<const std::byte> bytes(const void* data, size_t size) {
  return {static_cast<const std::byte*>(data), size};
}

// Copies as much of the text as fits, and a NUL. Returns the length of the whole text.
size_t give_text(const std::string& text, char* buffer, size_t size) {
  if (size > 0) {
    const size_t n = std::min(size - 1, text.size());
    std::memcpy(buffer, text.data(), n);
    buffer[n] = 0;
  }
  return text.size();
}

tims::Envelope envelope_of(const tims_header& h) {
  return {.dest = Address(h.dest),
          .type = h.type,
          .priority = h.priority,
          .seq_nr = h.seq_nr,
          .stream = (h.flags & TIMS_STREAM) != 0,
          .trace = (h.flags & TIMS_TRACE) != 0,
          .report_if_gone = (h.flags & TIMS_REPORT_IF_GONE) != 0,
          .report_reason = (h.flags & TIMS_REPORT_REASON) != 0,
          .body_order = static_cast<std::uint8_t>(h.flags & TIMS_BODY_LITTLE_ENDIAN)};
}

tims::MailboxOptions options_of(const tims_mailbox_options& o) {
  return {.address = Address(o.address),
          .slots = o.slots,
          .body_max = o.body_max,
          .event_fd = o.event_fd != 0,
          .spin = tims::Duration(o.spin_ns)};
}

tims::AddressWidths widths_of(const tims_session* session) {
  return session == nullptr ? tims::AddressWidths() : session->session.address_widths();
}

void give_header(const Header& from, tims_header* to) {
  if (to != nullptr)
    *to = {from.dest.raw(), from.src.raw(), from.length, from.flags,
           from.type,       from.priority,  from.seq_nr};
}

tims_session* connect(tims::SessionOptions options) {
  auto session = tims::Session::connect(std::move(options));
  if (!session) return fail_null(session.error());
  return new tims_session{std::move(*session)};
}

}  // namespace

// --- Version, errors

const char* tims_version() { return TIMS_VERSION; }

int tims_error_code() { return last_failure.code; }
const char* tims_error_text() { return last_failure.text.c_str(); }
const char* tims_error_name(int code) {
  constexpr int kUnknown = 255;
  return tims::name(static_cast<Errc>(code < 0 ? std::min(-1 - code, kUnknown) : kUnknown)).data();
}

// --- Sessions

tims_session* tims_connect(const char* router, const char* name, int64_t timeout_ns) {
  tims::SessionOptions options;
  if (router != nullptr) options.router = router;
  if (name != nullptr) options.name = name;
  options.timeout = wait_of(timeout_ns);
  return connect(std::move(options));
}

tims_session* tims_connect_with(const tims_session_options* wanted) {
  tims::SessionOptions options;
  if (wanted->router != nullptr) options.router = wanted->router;
  if (wanted->name != nullptr) options.name = wanted->name;
  if (wanted->timeout_ns != 0) options.timeout = wait_of(wanted->timeout_ns);
  if (wanted->tcp_message_max != 0) options.tcp_message_max = wanted->tcp_message_max;
  options.tcp_priority = wanted->tcp_priority;
  if (wanted->on_event != nullptr)
    options.on_event = [call = wanted->on_event,
                        user = wanted->user](const tims::SessionEvent& event) {
      call(user, static_cast<tims_event>(event.kind), event.text.c_str());
    };
  return connect(std::move(options));
}

void tims_disconnect(tims_session* session) { delete session; }

int tims_is_connected(const tims_session* session) { return session->session.connected() ? 1 : 0; }

uint32_t tims_router_address(const tims_session* session) {
  return session->session.router().raw();
}

int tims_flush(tims_session* session, int64_t timeout_ns) {
  return outcome(session->session.flush(wait_of(timeout_ns)));
}

size_t tims_default_router(char* buffer, size_t size) {
  return give_text(tims::default_router(), buffer, size);
}

// --- Mailboxes

tims_mailbox* tims_open(tims_session* session, const tims_mailbox_options* options) {
  tims_mailbox* mailbox = nullptr;
  return tims_open_all(session, options, 1, &mailbox) == 0 ? mailbox : nullptr;
}

int tims_open_all(tims_session* session, const tims_mailbox_options* options, size_t count,
                  tims_mailbox** mailboxes) {
  std::vector<tims::MailboxOptions> wanted;
  for (size_t i = 0; i < count; ++i) wanted.push_back(options_of(options[i]));
  auto opened = session->session.open(wanted);
  if (!opened) return fail(opened.error());
  for (size_t i = 0; i < count; ++i) mailboxes[i] = new tims_mailbox{std::move((*opened)[i])};
  return 0;
}

tims_mailbox* tims_open_while(tims_session* session, const tims_mailbox_options* options,
                              int (*go_on)(void* user), void* user) {
  const tims::MailboxOptions wanted = options_of(*options);
  auto opened =
      session->session.open(std::span(&wanted, 1), [go_on, user] { return go_on(user) != 0; });
  if (!opened) return fail_null(opened.error());
  return new tims_mailbox{std::move(opened->front())};
}

void tims_close(tims_mailbox* mailbox) { delete mailbox; }

int tims_close_linger(tims_mailbox* mailbox, int64_t linger_ns) {
  const int flushed = outcome(mailbox->mailbox.flush(wait_of(linger_ns)));
  delete mailbox;
  return flushed;
}

uint32_t tims_mailbox_address(const tims_mailbox* mailbox) {
  return mailbox->mailbox.address().raw();
}

uint32_t tims_mailbox_body_max(const tims_mailbox* mailbox) { return mailbox->mailbox.body_max(); }

int tims_event_fd(const tims_mailbox* mailbox) { return mailbox->mailbox.event_fd(); }

void tims_mailbox_counters(const tims_mailbox* mailbox, tims_counters* counters) {
  const tims::MailboxCounters c = mailbox->mailbox.counters();
  *counters = {c.received, c.waiting, c.replaced, c.refused, c.too_big, c.reclaimed};
}

// --- Sending

int tims_send(tims_mailbox* mailbox, const tims_header* header, const void* body,
              size_t body_size) {
  return outcome(mailbox->mailbox.send(envelope_of(*header), bytes(body, body_size)));
}

int tims_try_send(tims_mailbox* mailbox, const tims_header* header, const void* body,
                  size_t body_size) {
  return outcome(mailbox->mailbox.try_send(envelope_of(*header), bytes(body, body_size)));
}

int tims_send_pieces(tims_mailbox* mailbox, const tims_header* header, const tims_piece* pieces,
                     size_t count) {
  constexpr size_t kMany = 64;  // more than this number justify an allocation
  std::array<std::span<const std::byte>, kMany> few;
  std::vector<std::span<const std::byte>> many(count > kMany ? count : 0);
  const std::span<std::span<const std::byte>> spans =
      count > kMany ? std::span(many) : std::span(few).first(count);
  for (size_t i = 0; i < count; ++i) spans[i] = bytes(pieces[i].data, pieces[i].size);
  return outcome(mailbox->mailbox.send(envelope_of(*header), spans));
}

int tims_reply(tims_mailbox* mailbox, const tims_header* request, int8_t type, const void* body,
               size_t body_size) {
  const Header to{
      .priority = request->priority, .seq_nr = request->seq_nr, .src = Address(request->src)};
  return outcome(mailbox->mailbox.reply(to, type, bytes(body, body_size)));
}

tims_loaned* tims_loan(tims_mailbox* mailbox, const tims_header* header, size_t body_size) {
  if (body_size > UINT32_MAX) return fail_null(Errc::kTooBig);
  auto loan = mailbox->mailbox.loan(envelope_of(*header), static_cast<std::uint32_t>(body_size));
  if (!loan) return fail_null(loan.error());
  return new tims_loaned{std::move(*loan)};
}

void* tims_loan_body(tims_loaned* loan) { return loan->loan.body().data(); }

int tims_loan_send(tims_loaned* loan) {
  const int sent = outcome(loan->loan.send());
  delete loan;
  return sent;
}

void tims_loan_drop(tims_loaned* loan) { delete loan; }

// --- Receiving

int64_t tims_receive(tims_mailbox* mailbox, tims_header* header, void* buffer, size_t buffer_size,
                     int64_t timeout_ns) {
  const std::span room(static_cast<std::byte*>(buffer), buffer_size);
  const auto received = timeout_ns <= 0 ? mailbox->mailbox.try_receive(room)
                                        : mailbox->mailbox.receive_for(room, wait_of(timeout_ns));
  if (!received) return fail(received.error());
  give_header(received->header, header);
  return static_cast<int64_t>(received->body.size());
}

tims_guard* tims_peek(tims_mailbox* mailbox, tims_header* header, const void** body,
                      int64_t timeout_ns) {
  auto guard = timeout_ns <= 0 ? mailbox->mailbox.try_peek()
                               : mailbox->mailbox.peek_for(wait_of(timeout_ns));
  if (!guard) return fail_null(guard.error());
  give_header(guard->header(), header);
  if (body != nullptr) *body = guard->body().data();
  return new tims_guard{std::move(*guard)};
}

void tims_release(tims_guard* guard) { delete guard; }

int64_t tims_clean(tims_mailbox* mailbox) { return static_cast<int64_t>(mailbox->mailbox.clean()); }

// --- Addresses

uint32_t tims_make_address(const tims_session* session, const tims_address_fields* fields) {
  return Address::of({fields->system, fields->class_id, fields->instance, fields->local},
                     widths_of(session))
      .raw();
}

void tims_split_address(const tims_session* session, uint32_t address,
                        tims_address_fields* fields) {
  const Address::Fields f = Address(address).fields(widths_of(session));
  *fields = {f.system, f.class_id, f.instance, f.local};
}

int tims_name_class(uint32_t class_id, const char* name) {
  static std::deque<std::string> names;  // tims::name_class() keeps a reference
  const std::string_view wanted = name == nullptr ? "" : name;
  if (tims::class_name(class_id) == wanted && !wanted.empty()) return 0;
  const auto good = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
  };
  if (wanted.empty() || (wanted.front() >= '0' && wanted.front() <= '9') ||
      !std::ranges::all_of(wanted, good))
    return fail(Error(Errc::kInvalidArgument, "the name of a class has letters, digits and _"));
  if (tims::name_class(class_id, names.emplace_back(wanted))) return 0;
  names.pop_back();
  return fail(Error(Errc::kInvalidArgument,
                    "the number or the name of this class belongs to another class, or 64 classes "
                    "have names: " +
                        std::to_string(class_id) + ", " + std::string(wanted)));
}

int tims_parse_address(const tims_session* session, const char* text, uint32_t* address) {
  const auto parsed = Address::parse(text, widths_of(session));
  if (!parsed) {
    std::string problem = std::string(text) + " is not an address";
    const std::string why = Address::problem(text, widths_of(session));
    problem += why.empty() ? "; write Ladar(3/0) or 0x03140000" : ": " + why;
    if (why.starts_with("no class"))
      problem += "; tims_name_class() registers names of your own classes";
    return fail(Error(Errc::kInvalidArgument, std::move(problem)));
  }
  *address = parsed->raw();
  return 0;
}

size_t tims_format_address(const tims_session* session, uint32_t address, char* buffer,
                           size_t size) {
  return give_text(Address(address).to_string(widths_of(session)), buffer, size);
}
