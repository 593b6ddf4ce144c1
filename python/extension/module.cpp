// tims._tims: what the package tims is made of.
#include "objects.h"

namespace tims_python {

State* state_of(PyObject* module) { return static_cast<State*>(PyModule_GetState(module)); }

namespace {

PyObject* forked(PyObject* module, PyObject* /*unused*/) {
  ++state_of(module)->generation;
  Py_RETURN_NONE;
}

PyObject* default_router(PyObject* /*module*/, PyObject* /*unused*/) {
  char text[512];
  tims_default_router(text, sizeof text);
  return PyUnicode_FromString(text);
}

PyObject* error_name(PyObject* /*module*/, PyObject* number) {
  const long code = PyLong_AsLong(number);
  if (code == -1 && PyErr_Occurred() != nullptr) return nullptr;
  return PyUnicode_FromString(tims_error_name(static_cast<int>(code)));
}

PyObject* name_class(PyObject* module, PyObject* arguments) {
  unsigned id = 0;
  const char* name = nullptr;
  if (PyArg_ParseTuple(arguments, "Is:name_class", &id, &name) == 0) return nullptr;
  if (tims_name_class(id, name) != 0) return raise_last(state_of(module));
  Py_RETURN_NONE;
}

PyMethodDef functions[] = {
    {"_forked", forked, METH_NOARGS, nullptr},
    {"default_router", default_router, METH_NOARGS, "The router that Session() connects to."},
    {"error_name", error_name, METH_O, "The name of an error code: 'address_in_use'."},
    {"name_class", name_class, METH_VARARGS,
     "name_class(class_id, name): a class that RACK does not define, with a number from 128 on"},
    {nullptr, nullptr, 0, nullptr}};

// In a child process (see State::generation).
bool watch_forks(PyObject* module) {
  PyObject* os = PyImport_ImportModule("os");
  PyObject* function = PyObject_GetAttrString(module, "_forked");
  PyObject* watch = os == nullptr ? nullptr : PyObject_GetAttrString(os, "register_at_fork");
  PyObject* arguments = PyTuple_New(0);
  PyObject* keywords =
      function == nullptr ? nullptr : Py_BuildValue("{sO}", "after_in_child", function);
  PyObject* done =
      watch == nullptr || keywords == nullptr ? nullptr : PyObject_Call(watch, arguments, keywords);
  const bool good = done != nullptr;
  for (PyObject* each : {os, function, watch, arguments, keywords, done}) Py_XDECREF(each);
  return good;
}

bool add_type(PyObject* module, PyTypeObject* type) {
  return type != nullptr && PyModule_AddType(module, type) == 0;
}

int execute(PyObject* module) {
  State* state = state_of(module);
  PyObject* errors = PyImport_ImportModule("tims.errors");
  if (errors == nullptr) return -1;
  state->error_of = PyObject_GetAttrString(errors, "error_of");
  Py_DECREF(errors);
  if (state->error_of == nullptr) return -1;
  state->session_type = make_session_type(module);
  state->mailbox_type = make_mailbox_type(module);
  state->message_type = make_message_type(module);
  const bool good =
      add_type(module, state->session_type) && add_type(module, state->mailbox_type) &&
      add_type(module, state->message_type) &&
      PyModule_AddStringConstant(module, "__version__", tims_version()) == 0 && watch_forks(module);
  return good ? 0 : -1;
}

int traverse(PyObject* module, visitproc visit, void* arg) {
  State* state = state_of(module);
  if (state == nullptr) return 0;
  for (PyTypeObject* type : {state->session_type, state->mailbox_type, state->message_type})
    Py_VISIT(reinterpret_cast<PyObject*>(type));
  Py_VISIT(state->error_of);
  return 0;
}

int clear(PyObject* module) {
  State* state = state_of(module);
  if (state == nullptr) return 0;
  drop(state->error_of);
  return 0;
}

// The types are needed by objects until the module itself goes.
void free_module(void* module) {
  State* state = state_of(static_cast<PyObject*>(module));
  if (state == nullptr) return;
  drop(state->session_type);
  drop(state->mailbox_type);
  drop(state->message_type);
  drop(state->error_of);
}

PyModuleDef_Slot slots[] = {{Py_mod_exec, as_slot(execute)}, {0, nullptr}};
PyModuleDef definition = {PyModuleDef_HEAD_INIT,
                          "tims._tims",
                          "The types of tims.",
                          sizeof(State),
                          functions,
                          slots,
                          traverse,
                          clear,
                          free_module};

}  // namespace
}  // namespace tims_python

// NOLINTNEXTLINE(bugprone-reserved-identifier): the name that Python looks for
PyMODINIT_FUNC PyInit__tims() { return PyModuleDef_Init(&tims_python::definition); }
