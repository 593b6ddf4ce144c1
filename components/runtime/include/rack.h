/* Components of RACK in C, and in every language that binds to C: the runtime of rack/module.h.
 *
 * A component states what it is in struct rack_component, with the functions that the runtime
 * calls, and hands it to rack_run():
 *
 *     static int turn_on(struct rack_module* module, void* user) { ... return 0; }
 *     static int loop(struct rack_module* module, void* user) {
 *       rack_sleep_until_next(module);
 *       return rack_publish(module, rack_time_stamp(), body, size);
 *     }
 *     int main(int argc, char** argv) {
 *       struct rack_component component = {.program = "Sweeper", .class_id = 144, .loop = loop};
 *       return rack_run(&component, argc, argv);
 *     }
 *
 * Arguments, commands, life cycle, parameters, data of the past, listeners and log texts are the
 * runtime's. components/examples/sweeper.c is a whole one. Bodies of messages have the layout of
 * the structs of rack/proxies: their fields in the order of declaration, without padding.
 *
 * Errors: functions return 0 or a TIMS_E... code as those of tims.h; callbacks return 0, or what
 * rack_fail() returned. A failed `on` or `loop` turns the component off and is retried; a failed
 * `command` is answered by ERROR with the reason.
 *
 * Threads: `init`, `cleanup` are called by the thread of rack_run(), `on`, `loop` and `off` by the
 * data task, `command` by the command task, and work for rack_later() by the worker. Every function
 * here may be called from any of them, except where it says otherwise.
 */
#ifndef RACK_H
#define RACK_H

#include <stddef.h>
#include <stdint.h>

#include "tims.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using, modernize-deprecated-headers): C */
#define RACK_API __attribute__((visibility("default")))

typedef struct rack_module rack_module; /* a component that runs */

enum rack_parameter_kind {
  RACK_INTEGER = 0,
  RACK_REAL = 1,
  RACK_TEXT = 2,
  /* Another component that this one needs: declares NAMESys and NAMEInst. `number` is the default
   * instance, `text` what it is, `class_id` its class. With min -1 it may be missing (-1). */
  RACK_PARTNER = 3,
};

enum rack_takes_effect { RACK_NOW = 0, RACK_AT_ON = 1, RACK_AT_START = 2 };

/* A parameter: an option of the program, and changed by messages while it runs. */
struct rack_parameter {
  const char* name;
  const char* help; /* one line, with the unit in brackets: "period of the data [ms]" */
  enum rack_parameter_kind kind;
  enum rack_takes_effect takes_effect;
  double number; /* the default of a number */
  double min;
  double max;        /* min and max 0: any */
  const char* text;  /* the default of a text; NULL: empty */
  uint32_t class_id; /* of a partner */
  uint8_t required;  /* not 0: must be given as an argument */
  /* Not 0: it names a file, folder or device of this host, which programs of other hosts cannot
   * change. */
  uint8_t is_host_file;
  uint8_t reserved[2];
};

/* A data set that was published. */
struct rack_data_set {
  uint32_t recorded; /* ms */
  const void* body;
  size_t size; /* bytes */
};

/* All texts must remain valid while rack_run() runs. NULL and 0 select the default. */
struct rack_component {
  const char* program;    /* "ChassisSim" */
  const char* purpose;    /* for --help */
  const char* class_name; /* of a class that RACK does not define (a number from 128 on) */
  const struct rack_parameter* parameters;
  size_t parameter_count;
  uint32_t class_id;
  uint32_t command_slots;    /* default 16 */
  uint32_t command_body_max; /* bytes; default 8192 */
  /* A component with data: the largest body of its data, bytes. 0: it has none. */
  uint32_t data_max;
  uint32_t history;   /* data sets that can be requested by their time; default 10 */
  uint32_t listeners; /* maximum number; default 64 */
  /* Not 0: every data set is needed. 0: links short of bandwidth may skip older ones. */
  uint32_t no_samples;

  void* user; /* for the callbacks; each of them but `loop` may be NULL */
  int (*init)(rack_module* module, void* user);
  void (*cleanup)(rack_module* module, void* user);
  int (*on)(rack_module* module, void* user);
  int (*loop)(rack_module* module, void* user);
  void (*off)(rack_module* module, void* user);
  /* Commands of the class: replies itself. The body is valid during the call. Returning
   * rack_unknown_command() refuses a command that the component does not know. */
  int (*command)(rack_module* module, const struct tims_header* header, const void* body,
                 size_t size, void* user);
  /* Interpolates: writes the data of a requested time to `to`, from the data sets before and after
   * it; at most `ahead` ms after the newest, these are the newest two. Returns the size of the
   * body, at most data_max, or what rack_fail() returned. Called by the command task. NULL: a
   * request gets the data set that is nearest to its time. */
  int64_t (*between)(rack_module* module, uint32_t time, const struct rack_data_set* before,
                     const struct rack_data_set* after, void* to, void* user);
  uint32_t ahead; /* ms; 0: a later time gets the newest data set, as without `between` */
};

/* Runs the program until SIGTERM, SIGINT, SIGHUP or rack_stop(); returns its exit code: 0, 1 when
 * it failed, 2 on wrong usage. Only in the main thread, before others are started. */
RACK_API int rack_run(const struct rack_component* component, int argc, char** argv);
/* From any thread, also before the callbacks. */
RACK_API void rack_stop(rack_module* module);

/* --- for callbacks -------------------------------------------------------------------------- */

/* Notes why a callback of this thread fails, and returns the code, which the callback returns. */
RACK_API int rack_fail(rack_module* module, int code, const char* text);
RACK_API int rack_unknown_command(rack_module* module);

/* Copies of parameters by their names, which must be declared: 0 and an empty text for others.
 * rack_text() writes at most size bytes, NUL included, and returns the length without NUL. */
RACK_API int32_t rack_integer(rack_module* module, const char* name);
RACK_API float rack_real(rack_module* module, const char* name);
RACK_API size_t rack_text(rack_module* module, const char* name, char* buffer, size_t size);
/* Sets a number or a text that the component has determined. TIMS_EINVALID: no such parameter. */
RACK_API int rack_set_integer(rack_module* module, const char* name, int32_t value);
RACK_API int rack_set_text(rack_module* module, const char* name, const char* value);

/* level: 0 print, 1 error, 2 warning, 3 info, 4 detail, as of the parameter gdosLevel. */
RACK_API void rack_log(rack_module* module, int level, const char* text);

/* The address of its command mailbox; 0 before there is one. */
RACK_API uint32_t rack_address(rack_module* module);
/* The router of the argument --router, for tims_connect(); NULL: the default one. Mailboxes of that
 * session may have the component's address with local ids from 2 on. */
RACK_API const char* rack_router(rack_module* module);
/* The address of a partner by its present parameters. TIMS_ENO_MAILBOX: it works without it. */
RACK_API int rack_partner(rack_module* module, const char* name, uint32_t* address);

/* In a command: answers it. 0, or TIMS_ENO_MAILBOX: its sender does not get it. */
RACK_API int rack_reply(rack_module* module, const struct tims_header* request, int8_t type,
                        const void* body, size_t size);
/* In a command that takes long: `work` is called by the worker, and replies. Its error is answered
 * by ERROR. `release` (or NULL) is called once, when `data` is not needed any more. 0, or the error
 * that the command shall return: too many wait. */
RACK_API int rack_later(rack_module* module, const struct tims_header* request,
                        int (*work)(rack_module* module, const struct tims_header* request,
                                    void* data),
                        void (*release)(void* data), void* data);

RACK_API int rack_is_on(rack_module* module);
/* It was not turned off and is not stopping: for an `on` that waits. */
RACK_API int rack_is_wanted(rack_module* module);

/* --- data ----------------------------------------------------------------------------------- */

/* The wall clock as data state it: ms, modulo 2^32. */
RACK_API uint32_t rack_time_stamp(void);
/* In `on`: the period of the data, ms. */
RACK_API void rack_set_period(rack_module* module, uint32_t period_ms);
RACK_API uint32_t rack_period(rack_module* module);
/* In `loop`: sleeps until the next multiple of the period since ON; missed ones are skipped. */
RACK_API void rack_sleep_until_next(rack_module* module);
/* In `loop`: keeps a data set, a body of the class's DATA in the byte order of this host, and sends
 * it to the listeners. `recorded`: its time, ms, which is its first field. TIMS_EINVALID: larger
 * than data_max, or the component has no data. */
RACK_API int rack_publish(rack_module* module, uint32_t recorded, const void* body, size_t size);
/* NOLINTEND(modernize-use-using, modernize-deprecated-headers) */

#ifdef __cplusplus
}
#endif

#endif
