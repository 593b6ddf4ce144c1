// Message: a received message, in place (peek) or as a copy (receive). Its body is what the buffer
// protocol exports.
#include <cstddef>

#include "objects.h"

namespace tims_python {
namespace {

Message* self_of(PyObject* object) { return reinterpret_cast<Message*>(object); }
bool is_released(const Message* message) {
  return message->guard == nullptr && message->copy == nullptr;
}

// Gives the slot back.
void end_peek(Message* message) {
  Mailbox* mailbox = message->mailbox;
  if (mailbox->session->generation == mailbox->state->generation) tims_release(message->guard);
  message->guard = nullptr;
  message->mailbox = nullptr;
  --mailbox->held;
  close_when_unused(mailbox);
  drop(mailbox);
}

void dealloc(PyObject* object) {
  Message* message = self_of(object);
  if (message->guard != nullptr) end_peek(message);
  drop(message->copy);
  free_object(object);
}

int get_buffer(PyObject* object, Py_buffer* view, int flags) {
  Message* message = self_of(object);
  if (is_released(message)) {
    PyErr_SetString(PyExc_BufferError,
                    "the message was released: use it before, or copy it by bytes(message)");
    return -1;
  }
  const int result =
      PyBuffer_FillInfo(view, object, const_cast<void*>(message->body), message->size, 1, flags);
  if (result == 0) ++message->exports;
  return result;
}

void release_buffer(PyObject* object, Py_buffer* /*view*/) { --self_of(object)->exports; }

Py_ssize_t length(PyObject* object) { return self_of(object)->size; }

PyObject* release(PyObject* object, PyObject* /*unused*/) {
  Message* message = self_of(object);
  if (message->exports > 0) {
    PyErr_Format(PyExc_BufferError,
                 "%zd views of the message live (memoryview, numpy array): delete them before it "
                 "is released, or "
                 "copy what is needed",
                 message->exports);
    return nullptr;
  }
  if (message->guard != nullptr) end_peek(message);
  drop(message->copy);
  Py_RETURN_NONE;
}

PyObject* enter(PyObject* object, PyObject* /*unused*/) { return referred(object); }

PyObject* exit(PyObject* object, PyObject* /*unused*/) { return release(object, nullptr); }

PyObject* repr(PyObject* object) {
  const Message* message = self_of(object);
  return PyUnicode_FromFormat("<tims.Message type %d from 0x%08x, %zd bytes%s>",
                              message->header.type, message->header.src, message->size,
                              is_released(message) ? ", released" : "");
}

PyObject* in_place(PyObject* object, void* /*unused*/) {
  return PyBool_FromLong(self_of(object)->guard != nullptr);
}
PyObject* little_endian(PyObject* object, void* /*unused*/) {
  return PyBool_FromLong(self_of(object)->header.flags & TIMS_BODY_LITTLE_ENDIAN);
}

constexpr Py_ssize_t at(size_t in_header) {
  return static_cast<Py_ssize_t>(offsetof(Message, header) + in_header);
}

PyMethodDef methods[] = {
    {"release", release, METH_NOARGS,
     "Gives its slot in the mailbox back. BufferError while views of it live."},
    {"__enter__", enter, METH_NOARGS, nullptr},
    {"__exit__", exit, METH_VARARGS, nullptr},
    {nullptr, nullptr, 0, nullptr}};
PyMemberDef members[] = {
    {"dest", T_UINT, at(offsetof(tims_header, dest)), READONLY, "address of the receiver"},
    {"src", T_UINT, at(offsetof(tims_header, src)), READONLY, "address of the sender"},
    {"flags", T_UBYTE, at(offsetof(tims_header, flags)), READONLY, "tims.FLAG_..."},
    {"type", T_BYTE, at(offsetof(tims_header, type)), READONLY,
     "above 0 a command, else a reply or data"},
    {"priority", T_UBYTE, at(offsetof(tims_header, priority)), READONLY,
     "0 to 255, higher is more important"},
    {"seq_nr", T_UBYTE, at(offsetof(tims_header, seq_nr)), READONLY, "replies repeat it"},
    {nullptr, 0, 0, 0, nullptr}};
PyGetSetDef properties[] = {
    {"in_place", in_place, nullptr, "whether it holds a slot of its mailbox", nullptr},
    {"little_endian", little_endian, nullptr, "byte order of the body", nullptr},
    {nullptr, nullptr, nullptr, nullptr, nullptr}};

}  // namespace

PyTypeObject* make_message_type(PyObject* module) {
  PyType_Slot slots[] = {
      {Py_tp_dealloc, as_slot(dealloc)},
      {Py_bf_getbuffer, as_slot(get_buffer)},
      {Py_bf_releasebuffer, as_slot(release_buffer)},
      {Py_sq_length, as_slot(length)},
      {Py_tp_repr, as_slot(repr)},
      {Py_tp_methods, methods},
      {Py_tp_members, members},
      {Py_tp_getset, properties},
      {Py_tp_doc, const_cast<char*>("A received message; memoryview(message) is its body.")},
      {0, nullptr}};
  PyType_Spec spec = {"tims.Message", sizeof(Message), 0,
                      Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};
  return reinterpret_cast<PyTypeObject*>(PyType_FromModuleAndSpec(module, &spec, nullptr));
}

PyObject* make_message(Mailbox* mailbox, tims_guard* guard, const tims_header& header,
                       const void* body, bool copied) {
  Message* message = self_of(PyType_GenericAlloc(mailbox->state->message_type, 0));
  if (message == nullptr) {
    tims_release(guard);
    return nullptr;
  }
  message->header = header;
  message->size = static_cast<Py_ssize_t>(header.length - TIMS_HEADER_SIZE);
  message->body = body;
  if (copied) {
    message->copy = PyBytes_FromStringAndSize(static_cast<const char*>(body), message->size);
    tims_release(guard);
    if (message->copy == nullptr) drop(message);
    if (message != nullptr) message->body = PyBytes_AsString(message->copy);
    return reinterpret_cast<PyObject*>(message);
  }
  message->guard = guard;
  message->mailbox = referred(mailbox);
  ++mailbox->held;
  return reinterpret_cast<PyObject*>(message);
}

}  // namespace tims_python
