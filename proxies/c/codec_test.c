/* The codec of C against that of C++: reads what `tims-schema --vectors` prints. Compiled as C11
 * and as C++. */
#include <errno.h>
#include <math.h>
#include <rack_messages.h>
#include <stdarg.h>
#include <stdlib.h>

/* NOLINTBEGIN: C that is compiled as C++, too */

enum { kMemory = 24 << 20, kBodyMax = 8 << 20 };

struct run {
  uint8_t* memory;
  uint8_t* value;
  uint8_t* body;
  uint8_t* again;
  unsigned long line;
  unsigned long compared;
  unsigned long damaged;
};

static void fail(const struct run* run, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fprintf(stderr, "vector %lu: ", run->line);
  vfprintf(stderr, format, arguments);
  fprintf(stderr, "\n");
  va_end(arguments);
  exit(1);
}

static void check(const struct run* run, int holds, const char* what) {
  if (!holds) fail(run, "%s", what);
}

static const struct rack_layout* layout_of(const char* name) {
  const struct rack_body* each;
  for (each = rack_bodies; each->name != NULL; ++each)
    if (strcmp(each->layout->name, name) == 0) return each->layout;
  return NULL;
}

static size_t from_hex(const char* text, uint8_t* bytes) {
  size_t count = 0;
  if (strcmp(text, "-") == 0) return 0;
  for (; text[0] != 0 && text[1] != 0; text += 2) {
    const char digits[3] = {text[0], text[1], 0};
    bytes[count++] = (uint8_t)strtoul(digits, NULL, 16);
  }
  return count;
}

/* --- the struct against the JSON of C++ ------------------------------------------------------- */

static void expect(const struct run* run, const char** json, const char* text) {
  const size_t size = strlen(text);
  if (strncmp(*json, text, size) != 0) fail(run, "expected %s at %.60s", text, *json);
  *json += size;
}

/* A byte of a string: texts of JSON show bytes that are not printable as \u00XX. */
static uint8_t next_byte(const char** json) {
  char digits[5] = {0};
  if (**json != '\\') return (uint8_t) * (*json)++;
  *json += 2;
  if ((*json)[-1] != 'u') return (uint8_t)(*json)[-1];
  memcpy(digits, *json, 4);
  *json += 4;
  return (uint8_t)strtoul(digits, NULL, 16);
}

static void compare_text(const struct run* run, const char** json, const uint8_t* text,
                         size_t size) {
  size_t i;
  expect(run, json, "\"");
  for (i = 0; i < size; ++i)
    if (next_byte(json) != text[i]) fail(run, "another text before %.40s", *json);
  expect(run, json, "\"");
}

static void compare_real(const struct run* run, const char** json, const uint8_t* at, size_t size) {
  char* end;
  double value;
  double wanted;
  float narrow;
  if (size == 4)
    memcpy(&narrow, at, 4), value = (double)narrow;
  else
    memcpy(&value, at, 8);
  if (strncmp(*json, "null", 4) == 0) {
    check(run, !isfinite(value), "a number is finite, and null in C++");
    *json += 4;
    return;
  }
  wanted = size == 4 ? (double)strtof(*json, &end) : strtod(*json, &end);
  if (wanted < value || wanted > value) fail(run, "%g is %.30s in C++", value, *json);
  *json = end;
}

static void compare_whole(const struct run* run, const char** json, const uint8_t* at, size_t size,
                          int is_signed) {
  uint64_t value = 0;
  char* end;
  size_t i;
  for (i = 0; i < size; ++i) value |= (uint64_t)at[RACK_NATIVE != 0 ? i : size - 1 - i] << (8 * i);
  if (strncmp(*json, "null", 4) == 0) { /* no address */
    check(run, value == 0xffffff00U || value == 0xffffffffU, "a number, and null in C++");
    *json += 4;
    return;
  }
  if (**json == '"') { /* an address */
    *json = strchr(*json + 1, '"') + 1;
    return;
  }
  if (is_signed && size < 8 && (value >> (8 * size - 1)) != 0) value |= ~(uint64_t)0 << (8 * size);
  errno = 0;
  if ((is_signed ? (uint64_t)strtoll(*json, &end, 10) : strtoull(*json, &end, 10)) != value ||
      errno != 0)
    fail(run, "%lld is %.30s in C++", (long long)value, *json);
  *json = end;
}

static void compare_struct(const struct run* run, const char** json, const struct rack_layout* of,
                           const uint8_t* value);

static void compare_one(const struct run* run, const char** json, const struct rack_field* field,
                        const uint8_t* at) {
  if (field->kind == RACK_KIND_STRUCT)
    compare_struct(run, json, field->inner, at);
  else if (field->kind == RACK_KIND_TEXT)
    compare_text(run, json, at, strlen((const char*)at));
  else if (field->kind == RACK_KIND_REAL)
    compare_real(run, json, at, field->size);
  else
    compare_whole(run, json, at, field->size, field->kind == RACK_KIND_SIGNED);
}

static void compare_bytes(const struct run* run, const char** json, const uint8_t* at,
                          size_t count) {
  size_t i;
  expect(run, json, "\"");
  for (i = 0; i < count; ++i, *json += 2) {
    const char digits[3] = {(*json)[0], (*json)[1], 0};
    check(run, strtoul(digits, NULL, 16) == at[i], "another byte");
  }
  expect(run, json, "\"");
}

static void compare_many(const struct run* run, const char** json, const struct rack_field* field,
                         const uint8_t* at, size_t count) {
  size_t i;
  expect(run, json, "[");
  for (i = 0; i < count; ++i, at += field->stride) {
    if (i != 0) expect(run, json, ",");
    compare_one(run, json, field, at);
  }
  expect(run, json, "]");
}

static void compare_field(const struct run* run, const char** json, const struct rack_layout* of,
                          const struct rack_field* field, const uint8_t* value) {
  const uint8_t* at = value + field->at;
  size_t count = field->most;
  if (field->role != RACK_FIXED) {
    count = (size_t)rack_stated_(of, field, value);
    memcpy(&at, value + field->at, sizeof at);
  }
  if (field->role != RACK_FIXED && **json == '"') {
    if (strcmp(field->name, "text") == 0 || strcmp(field->name, "name") == 0)
      compare_text(run, json, at, count);
    else
      compare_bytes(run, json, at, count);
  } else if (field->role != RACK_FIXED || **json == '[') {
    compare_many(run, json, field, at, count);
  } else {
    compare_one(run, json, field, at);
  }
}

static void compare_struct(const struct run* run, const char** json, const struct rack_layout* of,
                           const uint8_t* value) {
  size_t i;
  expect(run, json, "{");
  for (i = 0; i < of->field_count; ++i) {
    if (i != 0) expect(run, json, ",");
    expect(run, json, "\"");
    expect(run, json, of->fields[i].name);
    expect(run, json, "\":");
    compare_field(run, json, of, &of->fields[i], value);
  }
  expect(run, json, "}");
}

/* --- a vector --------------------------------------------------------------------------------- */

/* Encoded in both orders, decoded, and encoded again: the same bytes. */
static void check_round_trip(struct run* run, const struct rack_layout* of, uint8_t flags) {
  struct rack_problem problem;
  const uint8_t other = flags ^ TIMS_BODY_LITTLE_ENDIAN;
  const int64_t size = rack_encode_struct(of, run->value, flags, run->again, kBodyMax, &problem);
  const int64_t turned = rack_encode_struct(of, run->value, other, run->body, kBodyMax, &problem);
  if (size < 0 || size != turned) fail(run, "%s: %s", of->name, problem.text);
  if (size > 0) {
    check(run,
          rack_encode_struct(of, run->value, flags, run->again, (size_t)size - 1, NULL) ==
              TIMS_EBUFFER_TOO_SMALL,
          "a buffer that is too small is not noticed");
    check(run, rack_encode_struct(of, run->value, flags, run->again, (size_t)size, NULL) == size,
          "a buffer of the right size is refused");
  }
  if (rack_decode_struct(of, run->value, other, run->body, (size_t)turned, run->memory, kMemory,
                         &problem) != 0)
    fail(run, "%s: its own body is refused: %s", of->name, problem.text);
  memcpy(run->body + turned, run->again, (size_t)size);
  check(run,
        rack_encode_struct(of, run->value, flags, run->again, kBodyMax, NULL) == size &&
            memcmp(run->again, run->body + turned, (size_t)size) == 0,
        "the body changed on its way through the other byte order");
}

/* Copies that end where the body does: the address sanitizer sees who reads on. */
static uint8_t* exact(const uint8_t* body, size_t size) {
  uint8_t* copy = (uint8_t*)malloc(size == 0 ? 1 : size);
  if (size != 0) memcpy(copy, body, size);
  return copy;
}

static void check_vector(struct run* run, const struct rack_layout* of, uint8_t flags, size_t size,
                         const char* result) {
  struct rack_problem problem;
  uint8_t* body = exact(run->body, size);
  const int code =
      rack_decode_struct(of, run->value, flags, body, size, run->memory, kMemory, &problem);
  const char* json = result;
  if (*result == '!') {
    check(run, code == TIMS_EMALFORMED, "a damaged body was decoded");
    if (strcmp(problem.text, result + 1) != 0)
      fail(run, "\"%s\", in C++ \"%s\"", problem.text, result + 1);
    ++run->damaged;
  } else {
    if (code != 0) fail(run, "%s", problem.text);
    compare_struct(run, &json, of, run->value);
    check(run, *json == 0, "C++ knows more of it");
    check_round_trip(run, of, flags);
    ++run->compared;
  }
  free(body);
}

/* --- by hand ---------------------------------------------------------------------------------- */

static void check_calls(struct run* run) {
  static const uint8_t kMove[] = {0, 0, 0, 200, 0, 0, 0, 0, 0x3d, 0xcc, 0xcc, 0xcd};
  struct rack_problem problem;
  struct rack_ChassisMoveData move;
  struct rack_LadarPoint points[2] = {{-1.5F, 1234, 128, -1}, {0.5F, 7, 0, 2}};
  struct rack_LadarData scan;
  struct rack_CameraParamData camera;
  struct rack_FileName file;
  uint8_t body[256];
  int64_t size;
  rack_init_ChassisMoveData(&move);
  move.vx = 200, move.omega = 0.1F;
  check(run,
        rack_encode_ChassisMoveData(&move, 0, body, sizeof body, &problem) == sizeof kMove &&
            memcmp(body, kMove, sizeof kMove) == 0,
        "MOVE has another body");
  rack_init_CameraParamData(&camera);
  check(run, camera.sx >= 1 && camera.sx <= 1, "defaults are not those of C++");
  rack_init_LadarData(&scan);
  scan.pointNum = 2, scan.points = points;
  size = rack_encode_LadarData(&scan, TIMS_BODY_LITTLE_ENDIAN, body, sizeof body, &problem);
  check(run, size == 24 + 2 * 16, "a scan has another size");
  memset(&scan, 0, sizeof scan);
  check(run,
        rack_decode_LadarData(&scan, TIMS_BODY_LITTLE_ENDIAN, body, (size_t)size, run->memory,
                              RACK_MEMORY_LadarData, &problem) == 0 &&
            scan.points[0].distance == 1234 && scan.points[1].intensity == 2,
        "a scan is not what it was");
  check(run,
        rack_decode_LadarData(&scan, TIMS_BODY_LITTLE_ENDIAN, body, (size_t)size, run->memory, 31,
                              &problem) == TIMS_EBUFFER_TOO_SMALL,
        "memory that is too small is not noticed");
  scan.pointNum = 2161;
  check(run,
        rack_encode_LadarData(&scan, 0, body, sizeof body, &problem) == TIMS_EINVALID &&
            strcmp(problem.text,
                   "LadarData.points has 2161 elements, allowed are 2160: send fewer") == 0,
        problem.text);
  rack_init_FileName(&file);
  file.length = 1, file.name = "x";
  check(run, rack_encode_FileName(&file, 0, body, sizeof body, &problem) == 132,
        "a file name is padded to 132 bytes");
}

int main(void) {
  struct run run = {NULL, NULL, NULL, NULL, 0, 0, 0};
  char* line = NULL;
  size_t capacity = 0;
  ssize_t length;
  run.memory = (uint8_t*)malloc(kMemory);
  run.value = (uint8_t*)malloc(1 << 20);
  run.body = (uint8_t*)malloc(2 * (size_t)kBodyMax);
  run.again = (uint8_t*)malloc(kBodyMax);
  check_calls(&run);
  while ((length = getline(&line, &capacity, stdin)) > 0) {
    char* rest = line;
    const char* name = strsep(&rest, " ");
    const char* order = strsep(&rest, " ");
    const char* hex = strsep(&rest, " ");
    const struct rack_layout* of = layout_of(name);
    ++run.line;
    if (of == NULL || rest == NULL) fail(&run, "there is no %s", name);
    rest[strcspn(rest, "\n")] = 0;
    check_vector(&run, of, strcmp(order, "little") == 0 ? TIMS_BODY_LITTLE_ENDIAN : 0,
                 from_hex(hex, run.body), rest);
  }
  check(&run, run.compared > 200 && run.damaged > 50, "there are too few vectors");
  printf("%lu bodies are those of C++, %lu damaged ones are refused with the same words\n",
         run.compared, run.damaged);
  free(line), free(run.memory), free(run.value), free(run.body), free(run.again);
  return 0;
}
/* NOLINTEND */
