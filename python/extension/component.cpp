// rack._rack: run() a component, whose callbacks are one method of a Python object, and what they
// may call.
//
// The runtime's tasks are threads that Python does not know: each callback takes the GIL, which
// run() gives up. A callback is component._call(name, *arguments); it returns None, or (code, text)
// of what failed.
#define PY_SSIZE_T_CLEAN
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include <Python.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "rack.h"

namespace {

// Signals that end a component are for its main thread, which has them blocked and waits for them.
// Threads of others (numpy's) may get them instead.
constexpr std::array kEndSignals = {SIGTERM, SIGINT, SIGHUP};

void to_main_thread(int signal) {
  const pid_t self = ::getpid();  // the id of its main thread as well
  ::syscall(SYS_tgkill, self, self, signal);
}

class SignalsForMain {
 public:
  SignalsForMain() {
    ::pthread_sigmask(SIG_SETMASK, nullptr, &mask_);
    struct sigaction action {};
    action.sa_handler = to_main_thread;
    action.sa_flags = SA_RESTART;
    sigset_t ends;
    ::sigemptyset(&ends);
    for (const int signal : kEndSignals) ::sigaddset(&ends, signal);
    ::pthread_sigmask(SIG_BLOCK, &ends, nullptr);
    for (std::size_t i = 0; i < kEndSignals.size(); ++i)
      ::sigaction(kEndSignals[i], &action, &former_[i]);
  }
  SignalsForMain(const SignalsForMain&) = delete;
  SignalsForMain& operator=(const SignalsForMain&) = delete;
  ~SignalsForMain() {
    for (std::size_t i = 0; i < kEndSignals.size(); ++i)
      ::sigaction(kEndSignals[i], &former_[i], nullptr);
    ::pthread_sigmask(SIG_SETMASK, &mask_, nullptr);
  }

 private:
  sigset_t mask_{};
  std::array<struct sigaction, kEndSignals.size()> former_{};
};

class Gil {
 public:
  Gil() : state_(PyGILState_Ensure()) {}
  Gil(const Gil&) = delete;
  Gil& operator=(const Gil&) = delete;
  ~Gil() { PyGILState_Release(state_); }

 private:
  PyGILState_STATE state_;
};

// --- the runtime as Python sees it: valid while run() runs

struct Runtime {
  PyObject_HEAD rack_module* module;
};

constexpr const char* kNotRunning = "the component does not run: this is for its callbacks";

rack_module* module_of(PyObject* self) {
  rack_module* module = reinterpret_cast<Runtime*>(self)->module;
  if (module == nullptr) PyErr_SetString(PyExc_RuntimeError, kNotRunning);
  return module;
}

// What a program run is about; `user` of its callbacks.
struct Run {
  PyObject* component;
  Runtime* runtime;
  size_t data_max;  // bytes
};

// Takes the new reference. 0, or the failure noted for the runtime.
int result_of(rack_module* module, PyObject* result) {
  if (result == nullptr) {  // component._call lets nothing through but this
    PyErr_WriteUnraisable(nullptr);
    return rack_fail(module, TIMS_EINVALID, "its Python code failed: see standard error");
  }
  int code = 0;
  const char* text = nullptr;
  if (result != Py_None) {
    if (PyArg_ParseTuple(result, "is", &code, &text) == 0) {
      PyErr_Clear();
      code = rack_fail(module, TIMS_EINVALID, "it failed without a reason");
    } else {
      code = rack_fail(module, code, text);
    }
  }
  Py_DECREF(result);
  return code;
}

int call(rack_module* module, void* user, const char* name) {
  const Gil gil;
  const Run& run = *static_cast<Run*>(user);
  run.runtime->module = module;
  return result_of(module, PyObject_CallMethod(run.component, "_call", "s", name));
}

int init(rack_module* module, void* user) { return call(module, user, "module_init"); }
void cleanup(rack_module* module, void* user) { (void)call(module, user, "module_cleanup"); }
int turn_on(rack_module* module, void* user) { return call(module, user, "module_on"); }
int loop(rack_module* module, void* user) { return call(module, user, "module_loop"); }
void turn_off(rack_module* module, void* user) { (void)call(module, user, "module_off"); }

PyObject* header_tuple(const tims_header* h) {
  return Py_BuildValue("(IIIBbBB)", h->dest, h->src, h->length, h->flags, h->type, h->priority,
                       h->seq_nr);
}

bool header_of(PyObject* tuple, tims_header* h) {
  return PyArg_ParseTuple(tuple, "IIIBbBB", &h->dest, &h->src, &h->length, &h->flags,
                          reinterpret_cast<unsigned char*>(&h->type), &h->priority,
                          &h->seq_nr) != 0;
}

int command(rack_module* module, const tims_header* header, const void* body, size_t size,
            void* user) {
  const Gil gil;
  const Run& run = *static_cast<Run*>(user);
  PyObject* of = header_tuple(header);
  PyObject* result = of == nullptr ? nullptr
                                   : PyObject_CallMethod(run.component, "_call", "sOy#", "_command",
                                                         of, static_cast<const char*>(body),
                                                         static_cast<Py_ssize_t>(size));
  Py_XDECREF(of);
  return result_of(module, result);
}

// The bytes of the body that component._between(time, before, after) returned, or of a failure its
// code.
int64_t between(rack_module* module, uint32_t time, const rack_data_set* before,
                const rack_data_set* after, void* to, void* user) {
  const Gil gil;
  const Run& run = *static_cast<Run*>(user);
  PyObject* result = PyObject_CallMethod(
      run.component, "_call", "sIy#y#", "_between", time, static_cast<const char*>(before->body),
      static_cast<Py_ssize_t>(before->size), static_cast<const char*>(after->body),
      static_cast<Py_ssize_t>(after->size));
  if (result == nullptr || PyBytes_Check(result) == 0) {
    const int code = result_of(module, result);
    return code != 0 ? code : rack_fail(module, TIMS_EINVALID, "between() returned nothing");
  }
  char* bytes = nullptr;
  Py_ssize_t size = 0;
  (void)PyBytes_AsStringAndSize(result, &bytes, &size);
  std::memcpy(to, bytes, std::min(static_cast<size_t>(size), run.data_max));
  Py_DECREF(result);
  return size;  // one that is too large is refused by the runtime
}

int work(rack_module* module, const tims_header* /*request*/, void* data) {
  const Gil gil;
  return result_of(module, PyObject_CallObject(static_cast<PyObject*>(data), nullptr));
}

void release(void* data) {
  const Gil gil;
  Py_DECREF(static_cast<PyObject*>(data));
}

// --- methods

// False: raises.
bool is_within(const char* name, long long value, long long min, long long max) {
  if (value >= min && value <= max) return true;
  PyErr_Format(PyExc_ValueError, "%s is %lld: expected %lld to %lld", name, value, min, max);
  return false;
}

PyObject* integer(PyObject* self, PyObject* arguments) {
  const char* name = nullptr;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "s", &name) == 0) return nullptr;
  return PyLong_FromLong(rack_integer(module, name));
}

PyObject* real(PyObject* self, PyObject* arguments) {
  const char* name = nullptr;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "s", &name) == 0) return nullptr;
  return PyFloat_FromDouble(static_cast<double>(rack_real(module, name)));
}

PyObject* text(PyObject* self, PyObject* arguments) {
  const char* name = nullptr;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "s", &name) == 0) return nullptr;
  std::string value(rack_text(module, name, nullptr, 0) + 1, '\0');
  const size_t size = rack_text(module, name, value.data(), value.size());
  return PyUnicode_DecodeUTF8(
      value.data(), static_cast<Py_ssize_t>(std::min(size, value.size() - 1)), "surrogateescape");
}

PyObject* set(PyObject* self, PyObject* arguments) {
  const char* name = nullptr;
  PyObject* value = nullptr;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "sO", &name, &value) == 0) return nullptr;
  int good = 0;
  if (PyUnicode_Check(value) != 0) {
    const char* of = PyUnicode_AsUTF8AndSize(value, nullptr);
    if (of == nullptr) return nullptr;
    good = rack_set_text(module, name, of);
  } else {
    const long long number = PyLong_AsLongLong(value);
    if (number == -1 && PyErr_Occurred() != nullptr) return nullptr;
    if (!is_within(name, number, INT32_MIN, INT32_MAX)) return nullptr;
    good = rack_set_integer(module, name, static_cast<int32_t>(number));
  }
  if (good == 0) Py_RETURN_NONE;
  return PyErr_Format(PyExc_KeyError, "no parameter %s of this type", name);
}

PyObject* log(PyObject* self, PyObject* arguments) {
  int level = 0;
  const char* what = nullptr;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "is", &level, &what) == 0) return nullptr;
  rack_log(module, level, what);
  Py_RETURN_NONE;
}

PyObject* address(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  return module == nullptr ? nullptr : PyLong_FromUnsignedLong(rack_address(module));
}

PyObject* router(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  return module == nullptr ? nullptr : Py_BuildValue("z", rack_router(module));
}

PyObject* partner(PyObject* self, PyObject* arguments) {
  const char* name = nullptr;
  uint32_t there = 0;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "s", &name) == 0) return nullptr;
  const int code = rack_partner(module, name, &there);
  if (code == 0) return PyLong_FromUnsignedLong(there);
  if (code == TIMS_ENO_MAILBOX) Py_RETURN_NONE;
  return PyErr_Format(PyExc_KeyError, "no partner %s among the parameters", name);
}

PyObject* reply(PyObject* self, PyObject* arguments) {
  PyObject* request = nullptr;
  int type = 0;
  Py_buffer body{};
  rack_module* module = module_of(self);
  tims_header header{};
  if (module == nullptr || PyArg_ParseTuple(arguments, "Oiy*", &request, &type, &body) == 0)
    return nullptr;
  const bool good = is_within("type", type, -128, 127) && header_of(request, &header);
  int sent = 0;
  if (good) {  // to a sender that has closed it asks the router
    Py_BEGIN_ALLOW_THREADS sent = rack_reply(module, &header, static_cast<int8_t>(type), body.buf,
                                             static_cast<size_t>(body.len));
    Py_END_ALLOW_THREADS
  }
  PyBuffer_Release(&body);
  return good ? PyBool_FromLong(sent == 0) : nullptr;
}

PyObject* later(PyObject* self, PyObject* arguments) {
  PyObject* request = nullptr;
  PyObject* function = nullptr;
  rack_module* module = module_of(self);
  tims_header header{};
  if (module == nullptr || PyArg_ParseTuple(arguments, "OO", &request, &function) == 0 ||
      !header_of(request, &header))
    return nullptr;
  Py_INCREF(function);
  int added = 0;
  Py_BEGIN_ALLOW_THREADS added = rack_later(module, &header, work, release, function);
  Py_END_ALLOW_THREADS return PyBool_FromLong(added == 0);
}

PyObject* is_on(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  return module == nullptr ? nullptr : PyBool_FromLong(rack_is_on(module));
}

PyObject* is_wanted(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  return module == nullptr ? nullptr : PyBool_FromLong(rack_is_wanted(module));
}

PyObject* set_period(PyObject* self, PyObject* arguments) {
  long long period = 0;
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "L", &period) == 0 ||
      !is_within("period", period, 0, UINT32_MAX))
    return nullptr;
  rack_set_period(module, static_cast<uint32_t>(period));
  Py_RETURN_NONE;
}

PyObject* period(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  return module == nullptr ? nullptr : PyLong_FromUnsignedLong(rack_period(module));
}

PyObject* sleep_until_next(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  if (module == nullptr) return nullptr;
  Py_BEGIN_ALLOW_THREADS rack_sleep_until_next(module);
  Py_END_ALLOW_THREADS Py_RETURN_NONE;
}

PyObject* publish(PyObject* self, PyObject* arguments) {
  unsigned recorded = 0;
  Py_buffer body{};
  rack_module* module = module_of(self);
  if (module == nullptr || PyArg_ParseTuple(arguments, "Iy*", &recorded, &body) == 0)
    return nullptr;
  int good = 0;
  Py_BEGIN_ALLOW_THREADS good =
      rack_publish(module, recorded, body.buf, static_cast<size_t>(body.len));
  Py_END_ALLOW_THREADS const Py_ssize_t size = body.len;
  PyBuffer_Release(&body);
  if (good == 0) Py_RETURN_NONE;
  return PyErr_Format(PyExc_ValueError,
                      "a data set of %zd bytes: the component's data_max is smaller, or 0", size);
}

PyObject* stop(PyObject* self, PyObject* /*unused*/) {
  rack_module* module = module_of(self);
  if (module == nullptr) return nullptr;
  rack_stop(module);
  Py_RETURN_NONE;
}

PyMethodDef methods[] = {{"integer", integer, METH_VARARGS, nullptr},
                         {"real", real, METH_VARARGS, nullptr},
                         {"text", text, METH_VARARGS, nullptr},
                         {"set", set, METH_VARARGS, nullptr},
                         {"log", log, METH_VARARGS, nullptr},
                         {"address", address, METH_NOARGS, nullptr},
                         {"router", router, METH_NOARGS, nullptr},
                         {"partner", partner, METH_VARARGS, nullptr},
                         {"reply", reply, METH_VARARGS, nullptr},
                         {"later", later, METH_VARARGS, nullptr},
                         {"is_on", is_on, METH_NOARGS, nullptr},
                         {"is_wanted", is_wanted, METH_NOARGS, nullptr},
                         {"set_period", set_period, METH_VARARGS, nullptr},
                         {"period", period, METH_NOARGS, nullptr},
                         {"sleep_until_next", sleep_until_next, METH_NOARGS, nullptr},
                         {"publish", publish, METH_VARARGS, nullptr},
                         {"stop", stop, METH_NOARGS, nullptr},
                         {nullptr, nullptr, 0, nullptr}};

// --- run()

// The texts and rows that rack_component refers to.
struct Description {
  std::deque<std::string> texts;
  std::vector<rack_parameter> parameters;
  rack_component component{};

  const char* keep(const char* text) {
    return text == nullptr ? nullptr : texts.emplace_back(text).c_str();
  }
};

bool add_parameter(Description& description, PyObject* row) {
  rack_parameter of{};
  int kind = 0;
  int takes_effect = 0;
  if (PyArg_ParseTuple(row, "ssiidddzIbb", &of.name, &of.help, &kind, &takes_effect, &of.number,
                       &of.min, &of.max, &of.text, &of.class_id, &of.required,
                       &of.is_host_file) == 0)
    return false;
  of.name = description.keep(of.name);
  of.help = description.keep(of.help);
  of.text = description.keep(of.text);
  of.kind = static_cast<rack_parameter_kind>(kind);
  of.takes_effect = static_cast<rack_takes_effect>(takes_effect);
  description.parameters.push_back(of);
  return true;
}

bool describe(Description& description, PyObject* of, PyObject* rows) {
  rack_component& to = description.component;
  int interpolates = 0;
  if (PyArg_ParseTuple(of, "sszIIIIIIIIp", &to.program, &to.purpose, &to.class_name, &to.class_id,
                       &to.command_slots, &to.command_body_max, &to.data_max, &to.history,
                       &to.listeners, &to.no_samples, &to.ahead, &interpolates) == 0)
    return false;
  to.program = description.keep(to.program);
  to.purpose = description.keep(to.purpose);
  to.class_name = description.keep(to.class_name);
  for (Py_ssize_t i = 0; i < PyList_Size(rows); ++i)
    if (!add_parameter(description, PyList_GetItem(rows, i))) return false;
  to.parameters = description.parameters.data();
  to.parameter_count = description.parameters.size();
  to.init = init;
  to.cleanup = cleanup;
  to.on = turn_on;
  to.loop = loop;
  to.off = turn_off;
  to.command = command;
  if (interpolates != 0) to.between = between;
  return true;
}

// Arguments as main() has them, behind the program's name.
bool take_arguments(PyObject* list, Description& description, std::vector<char*>& pointers) {
  pointers.push_back(const_cast<char*>(description.component.program));
  for (Py_ssize_t i = 0; i < PyList_Size(list); ++i) {
    const char* of = PyUnicode_AsUTF8AndSize(PyList_GetItem(list, i), nullptr);
    if (of == nullptr) return false;
    pointers.push_back(description.texts.emplace_back(of).data());
  }
  pointers.push_back(nullptr);
  return true;
}

// run(component, runtime, description, parameters, arguments): the exit code.
PyObject* run(PyObject* module, PyObject* arguments) {
  PyObject* component = nullptr;
  PyObject* runtime = nullptr;
  PyObject* of = nullptr;
  PyObject* rows = nullptr;
  PyObject* given = nullptr;
  auto* type = static_cast<PyObject**>(PyModule_GetState(module));
  if (PyArg_ParseTuple(arguments, "OOOOO", &component, &runtime, &of, &rows, &given) == 0)
    return nullptr;
  if (reinterpret_cast<PyObject*>(Py_TYPE(runtime)) != *type || PyList_Check(rows) == 0 ||
      PyList_Check(given) == 0) {
    PyErr_SetString(PyExc_TypeError, "run(component, Runtime, tuple, list, list)");
    return nullptr;
  }
  Description description;
  std::vector<char*> pointers;
  if (!describe(description, of, rows) || !take_arguments(given, description, pointers))
    return nullptr;
  Run user{component, reinterpret_cast<Runtime*>(runtime), description.component.data_max};
  description.component.user = &user;
  int code = 0;
  {
    const SignalsForMain signals;
    Py_BEGIN_ALLOW_THREADS code =
        rack_run(&description.component, static_cast<int>(pointers.size()) - 1, pointers.data());
    Py_END_ALLOW_THREADS
  }
  user.runtime->module = nullptr;
  return PyLong_FromLong(code);
}

PyObject* time_stamp(PyObject* /*module*/, PyObject* /*unused*/) {
  return PyLong_FromUnsignedLong(rack_time_stamp());
}

PyMethodDef functions[] = {
    {"run", run, METH_VARARGS, nullptr},
    {"time_stamp", time_stamp, METH_NOARGS, "The wall clock as data state it, ms."},
    {nullptr, nullptr, 0, nullptr}};

void dealloc(PyObject* self) {
  PyTypeObject* type = Py_TYPE(self);
  reinterpret_cast<freefunc>(PyType_GetSlot(type, Py_tp_free))(self);
  Py_DECREF(type);
}

int execute(PyObject* module) {
  PyType_Slot slots[] = {
      {Py_tp_dealloc, reinterpret_cast<void*>(dealloc)}, {Py_tp_methods, methods}, {0, nullptr}};
  PyType_Spec spec = {"rack._rack.Runtime", sizeof(Runtime), 0, Py_TPFLAGS_DEFAULT, slots};
  PyObject* type = PyType_FromModuleAndSpec(module, &spec, nullptr);
  *static_cast<PyObject**>(PyModule_GetState(module)) = type;
  return type == nullptr ? -1 : PyModule_AddType(module, reinterpret_cast<PyTypeObject*>(type));
}

int traverse(PyObject* module, visitproc visit, void* arg) {
  auto* type = static_cast<PyObject**>(PyModule_GetState(module));
  if (type != nullptr) Py_VISIT(*type);
  return 0;
}

void free_module(void* module) {
  auto* type = static_cast<PyObject**>(PyModule_GetState(static_cast<PyObject*>(module)));
  if (type != nullptr) Py_CLEAR(*type);
}

PyModuleDef_Slot slots[] = {{Py_mod_exec, reinterpret_cast<void*>(execute)}, {0, nullptr}};
PyModuleDef definition = {PyModuleDef_HEAD_INIT,
                          "rack._rack",
                          "The runtime of components.",
                          sizeof(PyObject*),
                          functions,
                          slots,
                          traverse,
                          nullptr,
                          free_module};

}  // namespace

// NOLINTNEXTLINE(bugprone-reserved-identifier): the name that Python looks for
PyMODINIT_FUNC PyInit__rack() { return PyModuleDef_Init(&definition); }
