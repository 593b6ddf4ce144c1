// The types of tims._tims: Session, Mailbox and Message over tims.h, in the stable ABI of
// Python 3.11, so that one file serves every later Python.
//
// Everything here is touched with the GIL held, so counters need no lock. A call that waits gives
// the GIL up and counts itself in `calls`: close() then only marks the object, and whoever is the
// last closes it.
#pragma once

#define PY_SSIZE_T_CLEAN
#include <cstdint>
#include <utility>

#include <Python.h>
#include <structmember.h>  // behind Python.h, without which it cannot be read

#include "tims.h"

namespace tims_python {

// A message that is read in place has a guard; a copy has its bytes.
struct Message;
struct Mailbox;
struct Session;

// Of the module: no globals, so that several interpreters may load it.
struct State {
  PyTypeObject* session_type = nullptr;
  PyTypeObject* mailbox_type = nullptr;
  PyTypeObject* message_type = nullptr;
  PyObject* error_of = nullptr;  // tims.errors.error_of(code, text): the exception to raise
  // Changed in a child process: there the threads of its parent's sessions do not exist, and a slot
  // that it released would be the parent's.
  unsigned generation = 0;
};

State* state_of(PyObject* module);

struct Events;  // of a session

struct Session {
  PyObject_HEAD tims_session* session;
  Events* events;
  State* state;
  PyObject* module;  // owns the state
  unsigned generation;
  unsigned users;  // mailboxes that are open, and calls that wait now
  bool is_closed;
};

struct Mailbox {
  PyObject_HEAD tims_mailbox* mailbox;
  Session* session;
  State* state;
  uint32_t address;
  uint32_t body_max;  // bytes
  uint32_t held_max;
  uint32_t held;   // messages in place
  uint32_t calls;  // that wait now
  bool is_closed;
};

struct Message {
  PyObject_HEAD tims_guard* guard;  // in place
  PyObject* copy;                   // bytes, if it is a copy
  Mailbox* mailbox;                 // in place: where its slot is
  const void* body;
  Py_ssize_t size;
  Py_ssize_t exports;  // views of it that live
  tims_header header;
};

PyTypeObject* make_session_type(PyObject* module);
PyTypeObject* make_mailbox_type(PyObject* module);
PyTypeObject* make_message_type(PyObject* module);

// A message in place; takes the guard over, also on failure. `copied`: makes a copy and releases
// the slot.
PyObject* make_message(Mailbox* mailbox, tims_guard* guard, const tims_header& header,
                       const void* body, bool copied);
// The mailbox lost a call or a message in place, the session a user: closes it if it was waiting
// for that.
void close_when_unused(Mailbox* mailbox);
void close_when_unused(Session* session);

// --- helpers

// Raises the library's last failure. Returns null, as all functions that raise.
PyObject* raise_last(State* state);
PyObject* raise_error(State* state, int code, const char* text);
// False: it is closed, or another process's; raises.
bool is_usable(const Session* session);
bool is_usable(const Mailbox* mailbox);

// Arguments by position or name into `values`, which are borrowed; null where none is given. The
// first `required` must be given, the first `positional` may be given without their name. False:
// raises.
struct Names {
  const char* function;
  const char* const* names;
  Py_ssize_t count;
  Py_ssize_t required;
  Py_ssize_t positional;
};
bool take_arguments(const Names& names, PyObject* const* given, Py_ssize_t count,
                    PyObject* keywords, PyObject** values);
// A number within its range. False: raises.
bool take_number(PyObject* value, const char* name, long long min, long long max,
                 long long& number);
// Seconds as nanoseconds; no value or None: TIMS_FOREVER.
bool take_timeout(PyObject* value, int64_t& timeout_ns);
// A number, or a text as Ladar(0/0).
bool take_address(const Session* session, PyObject* value, uint32_t& address);

// Waiting in slices: between two of them Python handles signals, and a close() is noticed.
constexpr int64_t kSlice = 50'000'000;
int64_t now_ns();
// The time until which `timeout_ns` lasts, and what is left of it.
int64_t deadline_after(int64_t timeout_ns);
int64_t slice_before(int64_t deadline, int64_t slice);

template <typename Function>
PyCFunction as_method(Function* function) {
  return reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(function));
}
template <typename Function>
void* as_slot(Function* function) {
  return reinterpret_cast<void*>(function);
}
void free_object(PyObject* object);

// A reference more, a reference less: of any of our types.
template <typename Object>
Object* referred(Object* object) {
  Py_XINCREF(reinterpret_cast<PyObject*>(object));
  return object;
}
template <typename Object>
void drop(Object*& object) {
  Py_XDECREF(reinterpret_cast<PyObject*>(std::exchange(object, nullptr)));
}

}  // namespace tims_python
