#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>

#include "objects.h"

namespace tims_python {

PyObject* raise_error(State* state, int code, const char* text) {
  if (state->error_of == nullptr) {  // the interpreter ends
    PyErr_SetString(PyExc_RuntimeError, text);
    return nullptr;
  }
  PyObject* error = PyObject_CallFunction(state->error_of, "is", code, text);
  if (error == nullptr) return nullptr;
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error)), error);
  Py_DECREF(error);
  return nullptr;
}

PyObject* raise_last(State* state) {
  return raise_error(state, tims_error_code(), tims_error_text());
}

bool is_usable(const Session* session) {
  if (session->generation != session->state->generation) {
    raise_error(session->state, TIMS_ECLOSED,
                "the session belongs to the parent process: after fork() open one of your own");
  } else if (session->is_closed) {
    raise_error(session->state, TIMS_ECLOSED, "the session was closed");
  } else {
    return true;
  }
  return false;
}

bool is_usable(const Mailbox* mailbox) {
  if (mailbox->session->generation != mailbox->state->generation) {
    raise_error(
        mailbox->state, TIMS_ECLOSED,
        "the mailbox belongs to the parent process: after fork() open a session of your own");
  } else if (mailbox->is_closed) {
    raise_error(mailbox->state, TIMS_ECLOSED, "the mailbox was closed");
  } else {
    return true;
  }
  return false;
}

namespace {

Py_ssize_t index_of(const Names& names, PyObject* keyword) {
  for (Py_ssize_t i = 0; i < names.count; ++i)
    if (PyUnicode_CompareWithASCIIString(keyword, names.names[i]) == 0) return i;
  return -1;
}

bool take_keyword(const Names& names, PyObject* keyword, PyObject* value, PyObject** values) {
  const Py_ssize_t at = index_of(names, keyword);
  if (at >= 0 && values[at] == nullptr) {
    values[at] = value;
    return true;
  }
  PyErr_Format(PyExc_TypeError, at < 0 ? "%s() has no argument %R" : "%s() got argument %R twice",
               names.function, keyword);
  return false;
}

}  // namespace

bool take_arguments(const Names& names, PyObject* const* given, Py_ssize_t count,
                    PyObject* keywords, PyObject** values) {
  if (count > names.positional) {
    PyErr_Format(PyExc_TypeError, "%s() takes at most %zd arguments without a name, not %zd",
                 names.function, names.positional, count);
    return false;
  }
  std::fill_n(values, names.count, nullptr);
  std::copy_n(given, count, values);
  const Py_ssize_t named = keywords == nullptr ? 0 : PyTuple_Size(keywords);
  for (Py_ssize_t i = 0; i < named; ++i)
    if (!take_keyword(names, PyTuple_GetItem(keywords, i), given[count + i], values)) return false;
  for (Py_ssize_t i = 0; i < names.required; ++i) {
    if (values[i] != nullptr) continue;
    PyErr_Format(PyExc_TypeError, "%s() needs the argument %s", names.function, names.names[i]);
    return false;
  }
  return true;
}

bool take_number(PyObject* value, const char* name, long long min, long long max,
                 long long& number) {
  if (value == nullptr) return true;
  number = PyLong_AsLongLong(value);
  if (number == -1 && PyErr_Occurred() != nullptr) {
    if (PyErr_ExceptionMatches(PyExc_OverflowError) == 0) return false;
    PyErr_Clear();
  } else if (number >= min && number <= max) {
    return true;
  }
  PyErr_Format(PyExc_ValueError, "%s is %S: expected %lld to %lld", name, value, min, max);
  return false;
}

bool take_timeout(PyObject* value, int64_t& timeout_ns) {
  if (value == nullptr || value == Py_None) return true;
  const double seconds = PyFloat_AsDouble(value);
  if (seconds == -1.0 && PyErr_Occurred() != nullptr) return false;
  if (std::isnan(seconds)) {
    PyErr_SetString(PyExc_ValueError, "the timeout is not a number of seconds");
    return false;
  }
  constexpr double kLongest = 9e9;  // s: beyond it, as without limit
  timeout_ns =
      seconds >= kLongest ? TIMS_FOREVER : static_cast<int64_t>(std::max(seconds, 0.0) * 1e9);
  return true;
}

bool take_address(const Session* session, PyObject* value, uint32_t& address) {
  if (PyUnicode_Check(value) == 0) {
    long long number = 0;
    if (!take_number(value, "address", 0, UINT32_MAX, number)) return false;
    address = static_cast<uint32_t>(number);
    return true;
  }
  Py_ssize_t size = 0;
  const char* text = PyUnicode_AsUTF8AndSize(value, &size);
  if (text == nullptr) return false;
  if (static_cast<size_t>(size) != std::strlen(text)) {
    PyErr_SetString(PyExc_ValueError, "the address has a NUL character");
    return false;
  }
  if (tims_parse_address(session->session, text, &address) == 0) return true;
  raise_last(session->state);
  return false;
}

int64_t now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

int64_t deadline_after(int64_t timeout_ns) {
  const int64_t now = now_ns();
  return timeout_ns > TIMS_FOREVER - now ? TIMS_FOREVER : now + timeout_ns;
}

int64_t slice_before(int64_t deadline, int64_t slice) {
  return deadline == TIMS_FOREVER ? slice : std::clamp<int64_t>(deadline - now_ns(), 0, slice);
}

void free_object(PyObject* object) {
  PyTypeObject* type = Py_TYPE(object);
  reinterpret_cast<freefunc>(PyType_GetSlot(type, Py_tp_free))(object);
  Py_DECREF(type);
}

}  // namespace tims_python
