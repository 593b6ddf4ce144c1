/* Bodies of messages to and from structs of C, in both byte orders.
 *
 * rack_messages.h has a struct for each body, with the names, units and numbers of C++ and Python
 * (mm, rad clockwise, ms). Its calls are the same for all:
 *
 *     struct rack_ChassisMoveData move;
 *     rack_init_ChassisMoveData(&move);                      its defaults
 *     move.vx = 200;                                         mm/s
 *     uint8_t body[RACK_BODY_MAX_ChassisMoveData];
 *     int64_t size = rack_encode_ChassisMoveData(&move, 0, body, sizeof body, NULL);
 *     if (size >= 0) tims_send(mailbox, &header, body, (size_t)size);
 *
 *     static _Alignas(8) uint8_t memory[RACK_MEMORY_LadarData];
 *     struct rack_LadarData scan;
 *     struct rack_problem problem;
 *     if (rack_decode_LadarData(&scan, header.flags, body, size, memory, sizeof memory, &problem)
 * != 0) puts(problem.text); else for (int i = 0; i < scan.pointNum; ++i)
 * use(scan.points[i].distance);
 *
 * `flags` are those of the message's header: TIMS_BODY_LITTLE_ENDIAN decides. Nothing is allocated.
 * A list is a pointer and a count, which is read when the struct is encoded. Decoding puts lists
 * into `memory` (RACK_MEMORY_... is enough for every body); those of single bytes point into the
 * body and are valid as long as it. Bodies come from other programs: no length in them is trusted.
 *
 * Own messages: python3 -m rack.generate --c share/rack/messages/thermometer.json > thermometer.h
 *
 * Functions return 0 or a size, or TIMS_EMALFORMED (not this struct), TIMS_EINVALID (values that
 * the struct cannot hold), TIMS_EBUFFER_TOO_SMALL (body or memory). */
#ifndef RACK_CODEC_H
#define RACK_CODEC_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "tims.h"

#ifdef __cplusplus
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
extern "C" {
#endif

/* NOLINTBEGIN: C */

/* The flags of a body in the byte order of this host, as rack_publish() and rack_reply() send it.
 */
#if __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define RACK_NATIVE TIMS_BODY_LITTLE_ENDIAN
#else
#define RACK_NATIVE 0
#endif

/* What is wrong, and where. */
struct rack_problem {
  char text[192];
};

enum rack_kind {
  RACK_KIND_SIGNED,
  RACK_KIND_UNSIGNED,
  RACK_KIND_REAL,
  RACK_KIND_TEXT,
  RACK_KIND_STRUCT
};
enum rack_role {
  RACK_FIXED,    /* `most` elements in the struct */
  RACK_SEQUENCE, /* its count is a field of the body */
  RACK_TAIL      /* its count follows from other fields */
};

struct rack_layout;
struct rack_field {
  const char* name;
  const char* counted_by; /* what an error of its count names */
  enum rack_kind kind;
  enum rack_role role;
  uint32_t size; /* of an element in a body, bytes */
  uint32_t most; /* elements */
  size_t at;     /* in the struct: the elements, or a pointer to them */
  size_t count_at;
  size_t stride; /* of an element in memory */
  const struct rack_layout* inner;
};

struct rack_layout {
  const char* name;
  const struct rack_field* fields;
  size_t field_count;
  size_t struct_size;
  size_t fixed_size; /* of a body without its lists */
  size_t whole_size; /* not 0: a body of this length is accepted, too */
  size_t surplus;    /* not 0: a body may be so much longer */
  int pads;          /* not 0: written with whole_size */
  const uint8_t* made;
  size_t made_size;
  void (*tails)(const void* value, int64_t* counts);
};

/* A message with a body. */
struct rack_body {
  uint8_t class_id;
  int8_t type;
  const char* name;
  const struct rack_layout* layout;
};

/* --- not for programs ---------------------------------------------------------------------------
 */

static inline int rack_problem_(struct rack_problem* problem, int code, const char* format,
                                const char* of, const char* field, long long a, long long b) {
  static const char kAdvice[] = "; its sender is broken, or has another version of this message";
  if (problem == NULL) return code;
  char number[2][24];
  const char* parts[4];
  size_t used = 0;
  snprintf(number[0], sizeof number[0], "%lld", a);
  snprintf(number[1], sizeof number[1], "%lld", b);
  parts[0] = of, parts[1] = field, parts[2] = number[0], parts[3] = number[1];
  for (; *format != 0 && used + 1 < sizeof problem->text; ++format) {
    if (*format == '$') {
      const int written =
          snprintf(problem->text + used, sizeof problem->text - used, "%s", parts[*++format - '0']);
      used += written < 0 ? 0 : (size_t)written;
    } else {
      problem->text[used++] = *format;
    }
  }
  if (used >= sizeof problem->text) used = sizeof problem->text - 1;
  snprintf(problem->text + used, sizeof problem->text - used, "%s",
           code == TIMS_EMALFORMED ? kAdvice : "");
  return code;
}

static inline void rack_copy_number_(uint8_t* to, const uint8_t* from, size_t size, int swap) {
  size_t i;
  for (i = 0; i < size; ++i) to[i] = from[swap ? size - 1 - i : i];
}

/* Elements of fixed size from a body. */
static inline void rack_read_(const struct rack_field* field, size_t count, uint8_t* to,
                              const uint8_t* body, int swap) {
  size_t i;
  size_t k;
  for (i = 0; i < count; ++i, to += field->stride, body += field->size) {
    if (field->kind == RACK_KIND_TEXT) {
      const void* end = memchr(body, 0, field->size - 1);
      const size_t length = end == NULL ? field->size - 1 : (size_t)((const uint8_t*)end - body);
      memset(to, 0, field->size);
      memcpy(to, body, length);
    } else if (field->kind == RACK_KIND_STRUCT) {
      const uint8_t* at = body;
      for (k = 0; k < field->inner->field_count; ++k) {
        const struct rack_field* inner = &field->inner->fields[k];
        rack_read_(inner, inner->most, to + inner->at, at, swap);
        at += (size_t)inner->most * inner->size;
      }
    } else {
      rack_copy_number_(to, body, field->size, swap);
    }
  }
}

static inline int rack_write_(const struct rack_layout* of, const struct rack_field* field,
                              size_t count, uint8_t* body, const uint8_t* from, int swap,
                              struct rack_problem* problem) {
  size_t i;
  size_t k;
  for (i = 0; i < count; ++i, from += field->stride, body += field->size) {
    if (field->kind == RACK_KIND_TEXT) {
      const void* end = memchr(from, 0, field->size);
      if (end == NULL)
        return rack_problem_(problem, TIMS_EINVALID,
                             "$0.$1 has $2 bytes, allowed are $3: shorten it", of->name,
                             field->name, field->size, (long long)field->size - 1);
      memset(body, 0, field->size);
      memcpy(body, from, (size_t)((const uint8_t*)end - from));
    } else if (field->kind == RACK_KIND_STRUCT) {
      uint8_t* at = body;
      for (k = 0; k < field->inner->field_count; ++k) {
        const struct rack_field* inner = &field->inner->fields[k];
        const int code =
            rack_write_(field->inner, inner, inner->most, at, from + inner->at, swap, problem);
        if (code != 0) return code;
        at += (size_t)inner->most * inner->size;
      }
    } else {
      rack_copy_number_(body, from, field->size, swap);
    }
  }
  return 0;
}

/* The count of a list as the struct states it. */
static inline int64_t rack_stated_(const struct rack_layout* of, const struct rack_field* field,
                                   const uint8_t* value) {
  int64_t counts[4] = {0, 0, 0, 0};
  size_t tail = 0;
  size_t i;
  int32_t count;
  if (field->role == RACK_SEQUENCE) {
    memcpy(&count, value + field->count_at, sizeof count);
    return count;
  }
  for (i = 0; &of->fields[i] != field; ++i) tail += of->fields[i].role == RACK_TAIL;
  of->tails(value, counts);
  return counts[tail];
}

static inline int rack_wrong_count_(const struct rack_layout* of, const struct rack_field* field,
                                    int64_t count, struct rack_problem* problem) {
  return rack_problem_(problem, TIMS_EMALFORMED, "$0.$1 is $2, allowed are 0 to $3", of->name,
                       field->counted_by, count, field->most);
}

/* A list out of `left` bytes of a body; its length in the body is added to *at. */
static inline int rack_read_list_(const struct rack_layout* of, const struct rack_field* field,
                                  uint8_t* value, const uint8_t* body, size_t left, size_t* at,
                                  uint8_t** memory, size_t* memory_size, int swap,
                                  struct rack_problem* problem) {
  const int64_t count = rack_stated_(of, field, value);
  const uint8_t* elements = body;
  size_t needed;
  size_t padding;
  if (count < 0 || count > (int64_t)field->most)
    return rack_wrong_count_(of, field, count, problem);
  if ((size_t)count * field->size > left)
    return rack_problem_(problem, TIMS_EMALFORMED, "$0.$1 needs $2 bytes, only $3 bytes follow",
                         of->name, field->counted_by, (long long)count * field->size,
                         (long long)left);
  if (field->size != 1) {
    padding = (8 - (size_t)((uintptr_t)*memory & 7)) & 7;
    needed = (size_t)count * field->stride + padding;
    if (needed > *memory_size)
      return rack_problem_(problem, TIMS_EBUFFER_TOO_SMALL,
                           "$0.$1 needs $2 bytes of memory, $3 bytes are left: give it more",
                           of->name, field->name, (long long)needed, (long long)*memory_size);
    if (*memory != NULL) {
      elements = *memory + padding;
      rack_read_(field, (size_t)count, *memory + padding, body, swap);
      *memory += needed;
      *memory_size -= needed;
    }
  }
  if (field->role == RACK_TAIL) {
    const uint32_t stated = (uint32_t)count;
    memcpy(value + field->count_at, &stated, sizeof stated);
  }
  memcpy(value + field->at, &elements, sizeof elements);
  *at += (size_t)count * field->size;
  return 0;
}

/* The length of the body of a struct, or what is wrong with its lists. */
static inline int64_t rack_size_(const struct rack_layout* of, const uint8_t* value,
                                 struct rack_problem* problem) {
  size_t size = of->fixed_size;
  size_t i;
  for (i = 0; i < of->field_count; ++i) {
    const struct rack_field* field = &of->fields[i];
    int64_t count;
    if (field->role == RACK_FIXED) continue;
    count = rack_stated_(of, field, value);
    if (field->role == RACK_TAIL) {
      uint32_t given;
      memcpy(&given, value + field->count_at, sizeof given);
      if ((int64_t)given != count)
        return rack_problem_(
            problem, TIMS_EINVALID,
            "$0.$1 has $2 elements, but the other fields give $3: correct one of them", of->name,
            field->name, given, count);
    }
    if (count < 0 || count > (int64_t)field->most)
      return rack_problem_(problem, TIMS_EINVALID,
                           "$0.$1 has $2 elements, allowed are $3: send fewer", of->name,
                           field->name, count, field->most);
    size += (size_t)count * field->size;
  }
  return (int64_t)(of->pads && size < of->whole_size ? of->whole_size : size);
}

/* --- any struct by its layout -------------------------------------------------------------------
 */

static inline int rack_decode_struct(const struct rack_layout* of, void* to, uint8_t flags,
                                     const void* from, size_t size, void* memory,
                                     size_t memory_size, struct rack_problem* problem) {
  const int swap = (flags & TIMS_BODY_LITTLE_ENDIAN) != RACK_NATIVE;
  const uint8_t* body = (const uint8_t*)from;
  uint8_t* value = (uint8_t*)to;
  uint8_t* free_memory = (uint8_t*)memory;
  size_t at = 0;
  size_t i;
  if (size < of->fixed_size)
    return rack_problem_(problem, TIMS_EMALFORMED, "$0 has at least $2 bytes, not $3 bytes",
                         of->name, "", (long long)of->fixed_size, (long long)size);
  memset(value, 0, of->struct_size);
  for (i = 0; i < of->field_count; ++i) {
    const struct rack_field* field = &of->fields[i];
    if (field->role == RACK_FIXED) {
      rack_read_(field, field->most, value + field->at, body + at, swap);
      at += (size_t)field->most * field->size;
    } else {
      const int code = rack_read_list_(of, field, value, body + at, size - at, &at, &free_memory,
                                       &memory_size, swap, problem);
      if (code != 0) return code;
    }
  }
  if (size != at && size != of->whole_size && !(of->surplus > 0 && size == at + of->surplus))
    return rack_problem_(problem, TIMS_EMALFORMED,
                         "$0 is $2 bytes long by its own counts, not $3 bytes", of->name, "",
                         (long long)at, (long long)size);
  return 0;
}

static inline int64_t rack_encode_struct(const struct rack_layout* of, const void* from,
                                         uint8_t flags, void* to, size_t capacity,
                                         struct rack_problem* problem) {
  const int swap = (flags & TIMS_BODY_LITTLE_ENDIAN) != RACK_NATIVE;
  const uint8_t* value = (const uint8_t*)from;
  uint8_t* body = (uint8_t*)to;
  const int64_t size = rack_size_(of, value, problem);
  size_t i;
  if (size < 0) return size;
  if ((size_t)size > capacity)
    return rack_problem_(problem, TIMS_EBUFFER_TOO_SMALL,
                         "$0 needs $2 bytes, the buffer has $3: give it more", of->name, "", size,
                         (long long)capacity);
  if (of->pads) memset(body, 0, (size_t)size);
  for (i = 0; i < of->field_count; ++i) {
    const struct rack_field* field = &of->fields[i];
    const uint8_t* elements = value + field->at;
    size_t count = field->most;
    int code;
    if (field->role != RACK_FIXED) {
      count = (size_t)rack_stated_(of, field, value);
      memcpy(&elements, value + field->at, sizeof elements);
    }
    code = rack_write_(of, field, count, body, elements, swap, problem);
    if (code != 0) return code;
    body += count * field->size;
  }
  return size;
}

static inline void rack_init_struct(const struct rack_layout* of, void* value) {
  memset(value, 0, of->struct_size);
  if (of->made != NULL)
    (void)rack_decode_struct(of, value, TIMS_BODY_LITTLE_ENDIAN, of->made, of->made_size, NULL, 0,
                             NULL);
}

/* NOLINTEND */

#ifdef __cplusplus
}
#pragma GCC diagnostic pop
#endif

#endif
