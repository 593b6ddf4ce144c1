// Mailbox: sends and receives. A message to a mailbox of this host that is known costs no system
// call and keeps the GIL; what may wait, or copies much, gives it up.
#include <algorithm>
#include <utility>

#include "objects.h"

namespace tims_python {
namespace {

constexpr Py_ssize_t kLargeBody =
    4096;  // bytes: copying them takes longer than handing the GIL over

Mailbox* self_of(PyObject* object) { return reinterpret_cast<Mailbox*>(object); }

void dealloc(PyObject* object) {
  Mailbox* mailbox = self_of(object);
  mailbox->is_closed = true;
  close_when_unused(mailbox);
  drop(mailbox->session);
  free_object(object);
}

PyObject* close(PyObject* object, PyObject* /*unused*/) {
  Mailbox* mailbox = self_of(object);
  mailbox->is_closed = true;
  close_when_unused(mailbox);
  Py_RETURN_NONE;
}

PyObject* enter(PyObject* object, PyObject* /*unused*/) { return referred(object); }
PyObject* exit(PyObject* object, PyObject* /*unused*/) { return close(object, nullptr); }

// --- sending

int send_now(Mailbox* mailbox, const tims_header& header, const Py_buffer& body) {
  const auto size = static_cast<size_t>(body.len);
  int result = TIMS_ETIMEOUT;
  if (body.len <= kLargeBody) result = tims_try_send(mailbox->mailbox, &header, body.buf, size);
  if (result != TIMS_ETIMEOUT) return result;
  ++mailbox->calls;
  Py_BEGIN_ALLOW_THREADS result = tims_send(mailbox->mailbox, &header, body.buf, size);
  Py_END_ALLOW_THREADS-- mailbox->calls;
  return result;
}

PyObject* send_body(Mailbox* mailbox, const tims_header& header, PyObject* body) {
  Py_buffer view{};
  if (body != nullptr && body != Py_None && PyObject_GetBuffer(body, &view, PyBUF_SIMPLE) != 0)
    return nullptr;
  const int result = send_now(mailbox, header, view);
  PyObject* good = result == 0 ? Py_None : raise_last(mailbox->state);
  if (view.obj != nullptr) PyBuffer_Release(&view);
  close_when_unused(mailbox);
  Py_XINCREF(good);
  return good;
}

constexpr const char* kSendNames[] = {"dest", "type", "body", "priority", "seq_nr", "flags"};

PyObject* send(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  Mailbox* mailbox = self_of(object);
  PyObject* values[6];
  if (!take_arguments({"send", kSendNames, 6, 2, 3}, given, count, keywords, values))
    return nullptr;
  if (!is_usable(mailbox)) return nullptr;
  tims_header header{};
  long long type = 0;
  long long priority = 0;
  long long seq_nr = 0;
  long long flags = PY_LITTLE_ENDIAN ? TIMS_BODY_LITTLE_ENDIAN : 0;
  if (!take_address(mailbox->session, values[0], header.dest) ||
      !take_number(values[1], "type", -128, 127, type) ||
      !take_number(values[3], "priority", 0, 255, priority) ||
      !take_number(values[4], "seq_nr", 0, 255, seq_nr) ||
      !take_number(values[5], "flags", 0, 255, flags))
    return nullptr;
  header.type = static_cast<int8_t>(type);
  header.priority = static_cast<uint8_t>(priority);
  header.seq_nr = static_cast<uint8_t>(seq_nr);
  header.flags = static_cast<uint8_t>(flags);
  return send_body(mailbox, header, values[2]);
}

constexpr const char* kReplyNames[] = {"request", "type", "body", "flags"};

PyObject* reply(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  Mailbox* mailbox = self_of(object);
  PyObject* values[4];
  if (!take_arguments({"reply", kReplyNames, 4, 2, 3}, given, count, keywords, values))
    return nullptr;
  if (!is_usable(mailbox)) return nullptr;
  if (Py_TYPE(values[0]) != mailbox->state->message_type) {
    PyErr_SetString(PyExc_TypeError, "the request is not a tims.Message");
    return nullptr;
  }
  const tims_header& request = reinterpret_cast<Message*>(values[0])->header;
  long long type = 0;
  long long flags = PY_LITTLE_ENDIAN ? TIMS_BODY_LITTLE_ENDIAN : 0;
  if (!take_number(values[1], "type", -128, 127, type) ||
      !take_number(values[3], "flags", 0, 255, flags))
    return nullptr;
  const tims_header header{.dest = request.src,
                           .src = 0,
                           .length = 0,
                           .flags = static_cast<uint8_t>(flags),
                           .type = static_cast<int8_t>(type),
                           .priority = request.priority,
                           .seq_nr = request.seq_nr};
  return send_body(mailbox, header, values[2]);
}

// --- receiving

// A message or null; `code` states why. Gives the GIL up.
tims_guard* wait_slice(Mailbox* mailbox, tims_header& header, const void*& body, int64_t slice,
                       int& code) {
  tims_guard* guard = nullptr;
  ++mailbox->calls;
  Py_BEGIN_ALLOW_THREADS guard = tims_peek(mailbox->mailbox, &header, &body, slice);
  code = guard == nullptr ? tims_error_code() : 0;
  Py_END_ALLOW_THREADS-- mailbox->calls;
  return guard;
}

// Null: raised, also when the time is over.
tims_guard* wait_for_message(Mailbox* mailbox, tims_header& header, const void*& body,
                             int64_t timeout_ns) {
  const int64_t deadline = deadline_after(timeout_ns);
  for (;;) {
    int code = 0;
    const int64_t slice = slice_before(deadline, kSlice);
    tims_guard* guard = wait_slice(mailbox, header, body, slice, code);
    if (mailbox->is_closed) {
      if (guard != nullptr) tims_release(guard);
      close_when_unused(mailbox);
      raise_error(mailbox->state, TIMS_ECLOSED,
                  "the mailbox was closed while it waited for a message");
      return nullptr;
    }
    if (guard != nullptr) return guard;
    const bool is_over = code == TIMS_EEMPTY || code == TIMS_ETIMEOUT;
    if (!is_over || slice_before(deadline, kSlice) == 0) {
      raise_error(mailbox->state, is_over ? TIMS_ETIMEOUT : code,
                  is_over ? "no message came in time" : tims_error_text());
      return nullptr;
    }
    if (PyErr_CheckSignals() != 0) return nullptr;
  }
}

bool may_hold_another(const Mailbox* mailbox) {
  if (mailbox->held < mailbox->held_max) return true;
  char name[80];
  char text[240];
  tims_format_address(mailbox->session->session, mailbox->address, name, sizeof name);
  PyOS_snprintf(text, sizeof text,
                "%u messages of the mailbox %s are held: release them (with, release()), copy them "
                "(receive()), or "
                "open the mailbox with a larger held_max",
                mailbox->held, name);
  raise_error(mailbox->state, TIMS_EINVALID, text);
  return false;
}

enum class Wait : uint8_t { kNo, kYes };

PyObject* take(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords,
               bool copied, Wait wait) {
  static constexpr const char* kNames[] = {"timeout"};
  Mailbox* mailbox = self_of(object);
  PyObject* timeout = nullptr;
  int64_t timeout_ns = TIMS_FOREVER;
  if (wait == Wait::kYes) {
    if (!take_arguments({"receive", kNames, 1, 0, 1}, given, count, keywords, &timeout))
      return nullptr;
    if (!take_timeout(timeout, timeout_ns)) return nullptr;
  }
  if (!is_usable(mailbox) || (!copied && !may_hold_another(mailbox))) return nullptr;
  tims_header header{};
  const void* body = nullptr;
  tims_guard* guard = tims_peek(mailbox->mailbox, &header, &body, 0);
  if (guard == nullptr && tims_error_code() != TIMS_EEMPTY) return raise_last(mailbox->state);
  if (guard == nullptr && wait == Wait::kNo) Py_RETURN_NONE;
  if (guard == nullptr) guard = wait_for_message(mailbox, header, body, timeout_ns);
  if (guard == nullptr) return nullptr;
  // While this call waited, those of other threads may have taken all that may be held.
  const bool may_hold = mailbox->held < mailbox->held_max;
  return make_message(mailbox, guard, header, body, copied || !may_hold);
}

PyObject* peek(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  return take(object, given, count, keywords, false, Wait::kYes);
}
PyObject* receive(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  return take(object, given, count, keywords, true, Wait::kYes);
}
PyObject* try_peek(PyObject* object, PyObject* /*unused*/) {
  return take(object, nullptr, 0, nullptr, false, Wait::kNo);
}
PyObject* try_receive(PyObject* object, PyObject* /*unused*/) {
  return take(object, nullptr, 0, nullptr, true, Wait::kNo);
}

PyObject* clean(PyObject* object, PyObject* /*unused*/) {
  Mailbox* mailbox = self_of(object);
  if (!is_usable(mailbox)) return nullptr;
  return PyLong_FromLongLong(tims_clean(mailbox->mailbox));
}

// --- what it is

PyObject* fileno(PyObject* object, PyObject* /*unused*/) {
  Mailbox* mailbox = self_of(object);
  if (!is_usable(mailbox)) return nullptr;
  const int descriptor = tims_event_fd(mailbox->mailbox);
  if (descriptor < 0)
    return raise_error(mailbox->state, TIMS_EINVALID,
                       "the mailbox has no descriptor: open it with event_fd=True");
  return PyLong_FromLong(descriptor);
}

PyObject* counters(PyObject* object, PyObject* /*unused*/) {
  Mailbox* mailbox = self_of(object);
  if (!is_usable(mailbox)) return nullptr;
  tims_counters c{};
  tims_mailbox_counters(mailbox->mailbox, &c);
  return Py_BuildValue("{sKsKsKsKsKsK}", "received", static_cast<unsigned long long>(c.received),
                       "waiting", static_cast<unsigned long long>(c.waiting), "replaced",
                       static_cast<unsigned long long>(c.replaced), "refused",
                       static_cast<unsigned long long>(c.refused), "too_big",
                       static_cast<unsigned long long>(c.too_big), "reclaimed",
                       static_cast<unsigned long long>(c.reclaimed));
}

PyObject* address(PyObject* object, void* /*unused*/) {
  return PyLong_FromUnsignedLong(self_of(object)->address);
}
PyObject* body_max(PyObject* object, void* /*unused*/) {
  return PyLong_FromUnsignedLong(self_of(object)->body_max);
}
PyObject* held(PyObject* object, void* /*unused*/) {
  return PyLong_FromUnsignedLong(self_of(object)->held);
}
PyObject* closed(PyObject* object, void* /*unused*/) {
  return PyBool_FromLong(self_of(object)->is_closed);
}
PyObject* session(PyObject* object, void* /*unused*/) {
  return reinterpret_cast<PyObject*>(referred(self_of(object)->session));
}

PyMethodDef methods[] = {
    {"send", as_method(send), METH_FASTCALL | METH_KEYWORDS,
     "send(dest, type, body=b'', *, priority=0, seq_nr=0, flags=byte order of this host)"},
    {"reply", as_method(reply), METH_FASTCALL | METH_KEYWORDS,
     "reply(request, type, body=b'', *, flags): to its sender, with its priority and sequence "
     "number"},
    {"peek", as_method(peek), METH_FASTCALL | METH_KEYWORDS,
     "peek(timeout=None): the next message in place, which holds its slot until it is released; a "
     "copy if other threads came to hold held_max messages while it waited"},
    {"receive", as_method(receive), METH_FASTCALL | METH_KEYWORDS,
     "receive(timeout=None): a copy of the next message"},
    {"try_peek", try_peek, METH_NOARGS, "The same without waiting; None: there is no message."},
    {"try_receive", try_receive, METH_NOARGS,
     "The same without waiting; None: there is no message."},
    {"clean", clean, METH_NOARGS, "Discards all messages; returns their number."},
    {"counters", counters, METH_NOARGS, "What happened to its messages, by name."},
    {"fileno", fileno, METH_NOARGS,
     "For event loops: armed by receiving until there is no message."},
    {"close", close, METH_NOARGS,
     "Ends it as soon as no message in place is held and no call waits. A router that does not "
     "answer is waited for, at most 5 s."},
    {"__enter__", enter, METH_NOARGS, nullptr},
    {"__exit__", exit, METH_VARARGS, nullptr},
    {nullptr, nullptr, 0, nullptr}};
PyGetSetDef properties[] = {
    {"address", address, nullptr, "its address", nullptr},
    {"body_max", body_max, nullptr, "largest body it accepts, bytes", nullptr},
    {"held", held, nullptr, "messages in place that are not released", nullptr},
    {"closed", closed, nullptr, "whether it was closed", nullptr},
    {"session", session, nullptr, "its session", nullptr},
    {nullptr, nullptr, nullptr, nullptr, nullptr}};

}  // namespace

void close_when_unused(Mailbox* mailbox) {
  if (!mailbox->is_closed || mailbox->held > 0 || mailbox->calls > 0 || mailbox->mailbox == nullptr)
    return;
  tims_mailbox* closed = std::exchange(mailbox->mailbox, nullptr);
  if (mailbox->session->generation == mailbox->state->generation) {
    Py_BEGIN_ALLOW_THREADS tims_close(closed);
    Py_END_ALLOW_THREADS
  }
  --mailbox->session->users;
  close_when_unused(mailbox->session);
}

PyTypeObject* make_mailbox_type(PyObject* module) {
  PyType_Slot slots[] = {
      {Py_tp_dealloc, as_slot(dealloc)},
      {Py_tp_methods, methods},
      {Py_tp_getset, properties},
      {Py_tp_doc, const_cast<char*>("Where messages are sent from and received.")},
      {0, nullptr}};
  PyType_Spec spec = {"tims.Mailbox", sizeof(Mailbox), 0,
                      Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};
  return reinterpret_cast<PyTypeObject*>(PyType_FromModuleAndSpec(module, &spec, nullptr));
}

}  // namespace tims_python
