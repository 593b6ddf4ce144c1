// Session: the connection to a router.
#include <cstdio>
#include <ctime>
#include <deque>
#include <mutex>
#include <string>
#include <utility>

#include "objects.h"

namespace tims_python {

// What happened to the connection. Told by threads of the session, which never take the GIL: they
// would have to wait for it while the interpreter ends.
struct Events {
  static constexpr size_t kMax = 64;  // older ones are forgotten

  std::mutex mutex;
  std::deque<std::pair<int, std::string>> kept;
  bool is_collected = false;
  bool is_waiting = false;  // and was told so

  void take(int kind, const char* text) {
    const std::lock_guard lock(mutex);
    const bool again =
        kind == TIMS_EVENT_WAITING && std::exchange(is_waiting, kind == TIMS_EVENT_WAITING);
    if (kind != TIMS_EVENT_WAITING) is_waiting = false;
    if (again) return;
    if (!is_collected) {
      if (kind != TIMS_EVENT_CONNECTED) std::fprintf(stderr, "tims: %s\n", text);
      return;
    }
    if (kept.size() == kMax) kept.pop_front();
    kept.emplace_back(kind, text);
  }
};

namespace {

constexpr int64_t kConnectSlice = 1'000'000'000;

Session* self_of(PyObject* object) { return reinterpret_cast<Session*>(object); }

void on_event(void* user, tims_event kind, const char* text) {
  static_cast<Events*>(user)->take(kind, text);
}

void dealloc(PyObject* object) {
  Session* session = self_of(object);
  if (session->state != nullptr) {
    session->is_closed = true;
    const bool is_own = session->generation == session->state->generation;
    close_when_unused(session);
    if (is_own) delete session->events;
  }
  drop(session->module);
  free_object(object);
}

// False: raises.
bool connect(Session* session, tims_session_options& options, int64_t timeout_ns) {
  const int64_t deadline = deadline_after(timeout_ns);
  for (;;) {
    const int64_t slice = slice_before(deadline, kConnectSlice);
    options.timeout_ns = slice > 0 ? slice : 1;
    int code = 0;
    Py_BEGIN_ALLOW_THREADS session->session = tims_connect_with(&options);
    code = session->session == nullptr ? tims_error_code() : 0;
    Py_END_ALLOW_THREADS if (code == 0) return true;
    if (code != TIMS_ETIMEOUT || slice_before(deadline, kConnectSlice) == 0) {
      raise_last(session->state);
      return false;
    }
    if (PyErr_CheckSignals() != 0) return false;
  }
}

PyObject* make(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
  static const char* names[] = {"router", "name", "timeout", "collect_events", nullptr};
  const char* router = nullptr;
  const char* name = nullptr;
  PyObject* timeout = nullptr;
  int is_collected = 0;
  if (PyArg_ParseTupleAndKeywords(arguments, keywords, "|zzO$p:Session", const_cast<char**>(names),
                                  &router, &name, &timeout, &is_collected) == 0)
    return nullptr;
  int64_t timeout_ns = TIMS_FOREVER;
  if (!take_timeout(timeout, timeout_ns)) return nullptr;
  Session* session = self_of(PyType_GenericAlloc(type, 0));
  if (session == nullptr) return nullptr;
  session->module = referred(PyType_GetModule(type));
  session->state = state_of(session->module);
  session->generation = session->state->generation;
  session->events = new Events;
  session->events->is_collected = is_collected != 0;
  tims_session_options options{};
  options.router = router;
  options.name = name;
  options.on_event = on_event;
  options.user = session->events;
  if (!connect(session, options, timeout_ns)) drop(session);
  return reinterpret_cast<PyObject*>(session);
}

PyObject* close(PyObject* object, PyObject* /*unused*/) {
  Session* session = self_of(object);
  session->is_closed = true;
  close_when_unused(session);
  Py_RETURN_NONE;
}

PyObject* enter(PyObject* object, PyObject* /*unused*/) { return referred(object); }
PyObject* exit(PyObject* object, PyObject* /*unused*/) { return close(object, nullptr); }

// --- mailboxes

// A call that waits without the GIL.
struct Opening {
  Session* session;
  PyThreadState* thread;
};

// Takes the GIL while the library waits for a router. 0: raised.
int shall_go_on(void* user) {
  auto* opening = static_cast<Opening*>(user);
  PyEval_RestoreThread(opening->thread);
  const bool goes_on = PyErr_CheckSignals() == 0 && is_usable(opening->session);
  opening->thread = PyEval_SaveThread();
  return goes_on ? 1 : 0;
}

PyObject* open_with(Session* session, const tims_mailbox_options& options, uint32_t held_max) {
  State* state = session->state;
  ++session->users;
  Opening opening{session, PyEval_SaveThread()};
  tims_mailbox* opened = tims_open_while(session->session, &options, shall_go_on, &opening);
  PyEval_RestoreThread(opening.thread);
  if (opened == nullptr) {
    --session->users;
    if (PyErr_Occurred() == nullptr) raise_last(state);
    close_when_unused(session);
    return nullptr;
  }
  Mailbox* mailbox = reinterpret_cast<Mailbox*>(PyType_GenericAlloc(state->mailbox_type, 0));
  if (mailbox == nullptr) {
    Py_BEGIN_ALLOW_THREADS tims_close(opened);
    Py_END_ALLOW_THREADS-- session->users;
    return nullptr;
  }
  mailbox->mailbox = opened;
  mailbox->session = referred(session);  // whose user it stays
  mailbox->state = state;
  mailbox->address = options.address;
  mailbox->body_max = options.body_max;
  mailbox->held_max = held_max;
  return reinterpret_cast<PyObject*>(mailbox);
}

constexpr const char* kOpenNames[] = {"address",  "slots",    "body_max",
                                      "held_max", "event_fd", "spin"};

PyObject* open(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  Session* session = self_of(object);
  PyObject* values[6];
  if (!take_arguments({"open", kOpenNames, 6, 1, 3}, given, count, keywords, values))
    return nullptr;
  if (!is_usable(session)) return nullptr;
  tims_mailbox_options options{};
  long long slots = 16;
  long long body_max = 4096;
  int64_t spin_ns = 0;
  if (!take_address(session, values[0], options.address) ||
      !take_number(values[1], "slots", 1, 65535, slots) ||
      !take_number(values[2], "body_max", 0, (1LL << 30) - TIMS_HEADER_SIZE, body_max))
    return nullptr;
  long long held_max = slots / 2 > 0 ? slots / 2 : 1;
  if (!take_number(values[3], "held_max", 1, slots, held_max)) return nullptr;
  if (values[5] != nullptr && values[5] != Py_None && !take_timeout(values[5], spin_ns))
    return nullptr;
  options.slots = static_cast<uint32_t>(slots);
  options.body_max = static_cast<uint32_t>(body_max);
  const int event_fd = values[4] == nullptr ? 0 : PyObject_IsTrue(values[4]);
  if (event_fd < 0) return nullptr;
  options.event_fd = event_fd == 1;
  options.spin_ns = spin_ns;
  return open_with(session, options, static_cast<uint32_t>(held_max));
}

// --- the rest

PyObject* flush(PyObject* object, PyObject* const* given, Py_ssize_t count, PyObject* keywords) {
  static constexpr const char* kNames[] = {"timeout"};
  Session* session = self_of(object);
  PyObject* timeout = nullptr;
  int64_t timeout_ns = TIMS_FOREVER;
  if (!take_arguments({"flush", kNames, 1, 0, 1}, given, count, keywords, &timeout) ||
      !is_usable(session) || !take_timeout(timeout, timeout_ns))
    return nullptr;
  const int64_t deadline = deadline_after(timeout_ns);
  for (;;) {
    int result = 0;
    ++session->users;
    Py_BEGIN_ALLOW_THREADS result = tims_flush(session->session, slice_before(deadline, kSlice));
    Py_END_ALLOW_THREADS-- session->users;
    const bool is_over = result != TIMS_ETIMEOUT || slice_before(deadline, kSlice) == 0;
    if (result != 0 && is_over) raise_last(session->state);
    close_when_unused(session);
    if (result == 0) Py_RETURN_NONE;
    if (is_over || PyErr_CheckSignals() != 0 || !is_usable(session)) return nullptr;
  }
}

PyObject* address(PyObject* object, PyObject* text) {
  Session* session = self_of(object);
  uint32_t address = 0;
  if (!is_usable(session) || !take_address(session, text, address)) return nullptr;
  return PyLong_FromUnsignedLong(address);
}

PyObject* format(PyObject* object, PyObject* number) {
  Session* session = self_of(object);
  long long address = 0;
  if (!is_usable(session) || !take_number(number, "address", 0, UINT32_MAX, address))
    return nullptr;
  char text[160];
  tims_format_address(session->session, static_cast<uint32_t>(address), text, sizeof text);
  return PyUnicode_FromString(text);
}

PyObject* make_address(PyObject* object, PyObject* arguments) {
  Session* session = self_of(object);
  PyObject* given[4] = {};
  long long system = 0;
  long long class_id = 0;
  long long instance = 0;
  long long local = 0;
  if (PyArg_ParseTuple(arguments, "OOO|O:make_address", &given[0], &given[1], &given[2],
                       &given[3]) == 0 ||
      !is_usable(session) || !take_number(given[0], "system", 0, UINT32_MAX, system) ||
      !take_number(given[1], "class_id", 0, UINT32_MAX, class_id) ||
      !take_number(given[2], "instance", 0, UINT32_MAX, instance) ||
      !take_number(given[3], "local", 0, UINT32_MAX, local))
    return nullptr;
  const tims_address_fields fields{static_cast<uint32_t>(system), static_cast<uint32_t>(class_id),
                                   static_cast<uint32_t>(instance), static_cast<uint32_t>(local)};
  return PyLong_FromUnsignedLong(tims_make_address(session->session, &fields));
}

PyObject* split_address(PyObject* object, PyObject* number) {
  Session* session = self_of(object);
  long long address = 0;
  if (!is_usable(session) || !take_number(number, "address", 0, UINT32_MAX, address))
    return nullptr;
  tims_address_fields fields{};
  tims_split_address(session->session, static_cast<uint32_t>(address), &fields);
  return Py_BuildValue("(IIII)", fields.system, fields.class_id, fields.instance, fields.local);
}

PyObject* take_events(PyObject* object, PyObject* /*unused*/) {
  Session* session = self_of(object);
  if (!is_usable(session)) return nullptr;
  std::deque<std::pair<int, std::string>> events;
  {
    const std::lock_guard lock(session->events->mutex);  // not held while Python's code may run
    events.swap(session->events->kept);
  }
  PyObject* list = PyList_New(0);
  for (const auto& [kind, text] : events) {
    if (list == nullptr) break;
    PyObject* event = Py_BuildValue("(is)", kind, text.c_str());
    if (event == nullptr || PyList_Append(list, event) != 0) drop(list);
    Py_XDECREF(event);
  }
  return list;
}

PyObject* connected(PyObject* object, void* /*unused*/) {
  const Session* session = self_of(object);
  if (!is_usable(session)) return nullptr;
  return PyBool_FromLong(tims_is_connected(session->session));
}
PyObject* router_address(PyObject* object, void* /*unused*/) {
  const Session* session = self_of(object);
  if (!is_usable(session)) return nullptr;
  return PyLong_FromUnsignedLong(tims_router_address(session->session));
}
PyObject* closed(PyObject* object, void* /*unused*/) {
  return PyBool_FromLong(self_of(object)->is_closed);
}

PyMethodDef methods[] = {
    {"open", as_method(open), METH_FASTCALL | METH_KEYWORDS,
     "open(address, slots=16, body_max=4096, *, held_max=slots // 2, event_fd=False, spin=0): a "
     "Mailbox"},
    {"flush", as_method(flush), METH_FASTCALL | METH_KEYWORDS,
     "flush(timeout=None): waits until the router has accepted what was sent"},
    {"address", address, METH_O,
     "The number of an address: 'Ladar(3/0)', 'Ladar(3/0):2', '0x03140002'."},
    {"format", format, METH_O, "The text of an address."},
    {"make_address", make_address, METH_VARARGS,
     "make_address(system, class_id, instance, local=0)"},
    {"split_address", split_address, METH_O, "(system, class_id, instance, local)"},
    {"take_events", take_events, METH_NOARGS,
     "What happened since the last call: [(tims.Event, text)]."},
    {"close", close, METH_NOARGS,
     "No mailbox can be opened any more; the connection ends with the last mailbox."},
    {"__enter__", enter, METH_NOARGS, nullptr},
    {"__exit__", exit, METH_VARARGS, nullptr},
    {nullptr, nullptr, 0, nullptr}};
PyGetSetDef properties[] = {
    {"connected", connected, nullptr, "whether there is a router", nullptr},
    {"router_address", router_address, nullptr, "the router's address; over TCP 0", nullptr},
    {"closed", closed, nullptr, "whether it was closed", nullptr},
    {nullptr, nullptr, nullptr, nullptr, nullptr}};

}  // namespace

void close_when_unused(Session* session) {
  if (!session->is_closed || session->users > 0 || session->session == nullptr) return;
  // In a child process the session's threads cannot be ended: they do not exist.
  if (session->generation == session->state->generation) {
    Py_BEGIN_ALLOW_THREADS tims_disconnect(std::exchange(session->session, nullptr));
    Py_END_ALLOW_THREADS
  }
  session->session = nullptr;
}

PyTypeObject* make_session_type(PyObject* module) {
  PyType_Slot slots[] = {
      {Py_tp_new, as_slot(make)},
      {Py_tp_dealloc, as_slot(dealloc)},
      {Py_tp_methods, methods},
      {Py_tp_getset, properties},
      {Py_tp_doc, const_cast<char*>("Session(router=None, name=None, timeout=None, *, "
                                    "collect_events=False): a connection to a router")},
      {0, nullptr}};
  PyType_Spec spec = {"tims.Session", sizeof(Session), 0, Py_TPFLAGS_DEFAULT, slots};
  return reinterpret_cast<PyTypeObject*>(PyType_FromModuleAndSpec(module, &spec, nullptr));
}

}  // namespace tims_python
