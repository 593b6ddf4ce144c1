/* libtims for C, and for every language that binds to C.
 *
 * A component is a program that communicates with others through mailboxes. It connects to the
 * router of its host and opens mailboxes, each with its own address, to send and receive messages.
 * A message is a header of 16 bytes and a body, which is transmitted unchanged.
 *
 *     #include <stdio.h>
 *     #include <tims.h>
 *
 *     int main(void) {
 *       struct tims_mailbox_options options = {.slots = 16, .body_max = 4096};
 *       struct tims_header header = {.type = 21, .priority = 10};
 *       char answer[4096];
 *       tims_session* session = tims_connect(NULL, "example", TIMS_FOREVER);
 *       if (session == NULL) return printf("%s\n", tims_error_text()), 1;
 *       tims_parse_address(session, "Tool(1/7)", &options.address);
 *       tims_parse_address(session, "Ladar(1/0)", &header.dest);
 *       tims_mailbox* mailbox = tims_open(session, &options);
 *       if (mailbox != NULL && tims_send(mailbox, &header, "hello", 5) == 0) {
 *         int64_t size = tims_receive(mailbox, &header, answer, sizeof answer, 1000000000);
 *         if (size < 0) printf("%s\n", tims_error_text());
 *       }
 *       tims_close(mailbox);
 *       tims_disconnect(session);
 *     }
 *
 * A C++ program includes tims/session.h instead: the same library with its own types.
 *
 * Errors
 * ------
 *
 * A function that returns a number returns 0 or a count on success, and a negative TIMS_E... code
 * on failure. A function that returns a pointer returns NULL on failure. In both cases
 * tims_error_code() returns the code and tims_error_text() a sentence with all details of the
 * calling thread's last failure. The possible errors are listed with each function.
 *
 * Pointers must not be NULL unless the description allows it.
 *
 * Ownership
 * ---------
 *
 * Every object has a function that releases it, to be called exactly once:
 *
 *     tims_connect, tims_connect_with    tims_disconnect
 *     tims_open, tims_open_all           tims_close, tims_close_linger
 *     tims_peek                          tims_release
 *     tims_loan                          tims_loan_send or tims_loan_drop
 *
 * A mailbox may outlive its session: the connection ends with the last of them. A guard or a loan
 * must be released before its mailbox. Arguments are not used after the call has returned.
 *
 * Threads
 * -------
 *
 * Every function may be called from any thread at any time. Several threads may receive from one
 * mailbox; each message goes to one of them. After the call that releases an object, no other call
 * may use it. A session has its own threads. They do not exist in a child process created by
 * fork(), which therefore must not use its parent's sessions and mailboxes.
 *
 * Time
 * ----
 *
 * Time-outs are nanoseconds. TIMS_FOREVER waits without limit; 0 or less does not wait.
 *
 * Cost
 * ----
 *
 * A message between two mailboxes of one host costs one copy and at most one wake-up; it does not
 * pass through the router, and needs no system call while the receiver is awake. tims_send and
 * tims_receive do not allocate memory; tims_peek and tims_loan allocate a few bytes for the object
 * that they return.
 *
 * For the first message to an address, and for the first one after its owner closed it or crashed,
 * the library asks the router where the address is and waits for the answer. This usually takes a
 * fraction of a millisecond, and at most 5 s if the router does not respond. A real-time program
 * should send one message to each address during start-up.
 *
 * Router failure and restart
 * --------------------------
 *
 * Without a router, mailboxes of this host that have exchanged messages before continue to do so.
 * When a router is available again, the session registers its mailboxes automatically. Messages to
 * other hosts that the former router had not accepted, up to 1024, are kept for the next router for
 * at most 30 s.
 */
#ifndef TIMS_H
#define TIMS_H

#include <stddef.h>
#include <stdint.h>

#include "tims/export.h"

#ifdef __cplusplus
extern "C" {
#endif

#define TIMS_FOREVER INT64_MAX

/* --- Version ---------------------------------------------------------------------------------- */

/* Version of the loaded library, "0.2.0"; never freed. A program works with every library whose
 * first two numbers are the same. */
TIMS_API const char* tims_version(void);

/* --- Errors ----------------------------------------------------------------------------------- */

enum tims_error {
  TIMS_EEMPTY = -1,             /* no message is waiting */
  TIMS_ETIMEOUT = -2,           /* the given time has passed */
  TIMS_ECLOSED = -3,            /* the mailbox or session was closed */
  TIMS_ENO_ROUTER = -4,         /* there is no router, or it did not answer */
  TIMS_EREFUSED = -5,           /* the router refused the request */
  TIMS_EADDRESS_IN_USE = -6,    /* another program owns the address; the text names it */
  TIMS_ENO_MAILBOX = -7,        /* the mailbox does not exist on this host any more */
  TIMS_EFULL = -8,              /* the receiver is full of more important messages */
  TIMS_ETOO_BIG = -9,           /* larger than the receiver accepts */
  TIMS_EBUFFER_TOO_SMALL = -10, /* the message stays in the mailbox */
  TIMS_ERECLAIMED = -11,        /* the slot was reclaimed from this writer */
  TIMS_EBAD_LAYOUT = -12,       /* shared memory without a valid mailbox */
  TIMS_EVERSION = -13,          /* library and router have no protocol version in common */
  TIMS_EINVALID = -14,          /* the call itself is wrong; the text states the reason */
  TIMS_ESYSTEM = -15,           /* the operating system refused; the text has its message */
  TIMS_EANSWERED_ERROR = -16,   /* a component answered ERROR */
  TIMS_EMALFORMED = -17,        /* bytes that do not form the expected message */
  TIMS_EDISKFULL = -18          /* no space for a file */
};

/* Code and text of the calling thread's last failure; 0 when there was none. The text is valid
 * until this thread's next failure. */
TIMS_API int tims_error_code(void);
TIMS_API const char* tims_error_text(void);
/* Name of an error code for logs and scripts ("address_in_use"); never freed. */
TIMS_API const char* tims_error_name(int code);

/* --- Types ------------------------------------------------------------------------------------ */

/* NOLINTBEGIN(modernize-use-using): C */
typedef struct tims_session tims_session; /* a connection to a router */
typedef struct tims_mailbox tims_mailbox; /* where messages are sent from and received */
typedef struct tims_guard tims_guard;     /* a received message that is read in place */
typedef struct tims_loaned tims_loaned; /* a slot in a receiver's mailbox, to build a message in */
/* NOLINTEND(modernize-use-using) */

#define TIMS_HEADER_SIZE 16

/* Bits of tims_header.flags. Other bits are transmitted unchanged, except the byte order of the
 * header, which the library sets. */
#define TIMS_BODY_LITTLE_ENDIAN 0x02 /* byte order of the body; not set: big endian */
#define TIMS_STREAM 0x10             /* a sample: a newer one may replace it on a slow link */
#define TIMS_TRACE 0x20              /* every router on the path reports to the sender */
#define TIMS_REPORT_IF_GONE                                                                       \
  0x40                          /* answer NOT_AVAILABLE when dest does not exist, as for commands \
                                 */
#define TIMS_FOREIGN 0x04       /* set by the router: over TCP, WebSocket, or from another host */
#define TIMS_REPORT_REASON 0x80 /* a receiver that refuses the command adds the reason to ERROR */

/* In native byte order. */
struct tims_header {
  uint32_t dest;
  uint32_t src;
  uint32_t length;  /* bytes, including the 16 of the header */
  uint8_t flags;    /* TIMS_... bits */
  int8_t type;      /* above 0 a command, 0 success, below 0 a reply or data */
  uint8_t priority; /* 0 to 255, higher is more important */
  uint8_t seq_nr;   /* replies repeat it */
};

/* --- Sessions --------------------------------------------------------------------------------- */

/* Connects to a router and waits for it at most timeout_ns.
 *
 * router: "unix:PATH", "/PATH", "HOST:PORT", "HOST" (port 2000), "[IPv6]:PORT". NULL: $TIMS_ROUTER;
 * else the user's own router, if there is one; else /run/tims/router.sock.
 * name: name of this program in `timsctl`, at most 31 bytes. NULL: the name of the process.
 *
 * Over TCP the session is a client of the original protocol, and the router may be an original one:
 * all messages go through the router, also those between two mailboxes of the session.
 *
 * NULL with TIMS_ETIMEOUT, TIMS_EREFUSED, TIMS_EVERSION, TIMS_EINVALID (router is not valid). */
TIMS_API tims_session* tims_connect(const char* router, const char* name, int64_t timeout_ns);

/* Events of a session. */
enum tims_event {
  TIMS_EVENT_WAITING = 0,       /* no router answers; retrying */
  TIMS_EVENT_CONNECTED = 1,     /* connected to a router, for the first time or again */
  TIMS_EVENT_LOST = 2,          /* connection to the router lost; retrying */
  TIMS_EVENT_MAILBOX_LOST = 3,  /* another program owns the address now; retried later */
  TIMS_EVENT_MESSAGES_LOST = 4, /* messages for the former router were too old */
};

/* 0 and NULL select the default. */
struct tims_session_options {
  const char* router; /* as for tims_connect */
  const char* name;
  int64_t timeout_ns; /* 0: TIMS_FOREVER */
  /* The largest message that a router reached over TCP accepts, header included. The router does
   * not report this limit, and closes the connection of a client that sends a larger message.
   * 16 to 2^30; default 262144. */
  uint32_t tcp_message_max;
  /* Real-time priority (SCHED_FIFO, 1 to 99) of the thread that carries messages over TCP. Default,
   * and without the required privilege: normal scheduling. */
  int32_t tcp_priority;
  /* Called from a thread of the session with `user` and one line of text, which is valid during the
   * call. It must not call tims_disconnect(). Default: all events except TIMS_EVENT_CONNECTED are
   * written to stderr. */
  void (*on_event)(void* user, enum tims_event event, const char* text);
  void* user;
};
TIMS_API tims_session* tims_connect_with(const struct tims_session_options* options);

/* NULL is allowed. Does not wait for messages still to be sent: see tims_flush. */
TIMS_API void tims_disconnect(tims_session* session);

/* 1 while connected to a router, else 0. */
TIMS_API int tims_is_connected(const tims_session* session);
/* The router's own address; over TCP 0. */
TIMS_API uint32_t tims_router_address(const tims_session* session);
/* Waits until the router has accepted all messages sent through this session before the call; the
 * router then forwards them even if this program exits. Messages to mailboxes of this host are
 * delivered as soon as they are sent. While there is no router the call waits for the next one.
 *
 * 0, or TIMS_ETIMEOUT: the remaining messages are still sent as long as the session exists. */
TIMS_API int tims_flush(tims_session* session, int64_t timeout_ns);

/* The router that tims_connect(NULL, ...) connects to. Writes at most size bytes, NUL included;
 * returns the length without NUL. */
TIMS_API size_t tims_default_router(char* buffer, size_t size);

/* --- Mailboxes -------------------------------------------------------------------------------- */

struct tims_mailbox_options {
  uint32_t address;
  uint32_t slots;    /* messages it can hold, 1 to 65535 */
  uint32_t body_max; /* largest body it accepts, bytes, at most 2^30 - 16 */
  uint8_t event_fd;  /* not 0: tims_event_fd() is available */
  uint8_t reserved[3];
  /* How long a receive polls for the next message, yielding the processor between two polls, before
   * it sleeps. Useful for streams, where a wake-up costs more than the message. Nanoseconds. */
  int64_t spin_ns;
};

/* Waits for a router if there is none at the moment. NULL with TIMS_EADDRESS_IN_USE,
 * TIMS_EINVALID (slots or body_max), TIMS_EREFUSED (the router has no room for more mailboxes). */
TIMS_API tims_mailbox* tims_open(tims_session* session, const struct tims_mailbox_options* options);
/* Opens all or none, in one exchange with the router: writes `count` mailboxes. 0, or the errors of
 * tims_open. */
TIMS_API int tims_open_all(tims_session* session, const struct tims_mailbox_options* options,
                           size_t count, tims_mailbox** mailboxes);
/* tims_open() that can be ended: the calling thread asks go_on(user) about every 50 ms while it
 * waits; 0 ends the call with TIMS_ETIMEOUT, and nothing is opened. go_on() must not use the
 * session. */
TIMS_API tims_mailbox* tims_open_while(tims_session* session,
                                       const struct tims_mailbox_options* options,
                                       int (*go_on)(void* user), void* user);

/* A sender notices it with its next message. Messages in the mailbox are lost. NULL is allowed. */
TIMS_API void tims_close(tims_mailbox* mailbox);
/* Calls tims_flush() of its session for at most linger_ns, then tims_close(). 0, or TIMS_ETIMEOUT:
 * the mailbox is closed in both cases. */
TIMS_API int tims_close_linger(tims_mailbox* mailbox, int64_t linger_ns);

TIMS_API uint32_t tims_mailbox_address(const tims_mailbox* mailbox);
TIMS_API uint32_t tims_mailbox_body_max(const tims_mailbox* mailbox);

/* For an event loop: a descriptor that is readable when a message has arrived. Use it only for
 * polling. It is armed by a receive with time-out 0 that ends with TIMS_EEMPTY, and by nothing
 * else: receive until TIMS_EEMPTY before the first poll, and after each wake-up. Whoever takes one
 * message and then polls may wait for ever. One thread at a time receives from such a mailbox:
 * while another one does, TIMS_EEMPTY arms nothing. It belongs to the mailbox, which closes it. -1
 * without the option. */
TIMS_API int tims_event_fd(const tims_mailbox* mailbox);

struct tims_counters {
  uint64_t received;  /* taken by the owner */
  uint64_t waiting;   /* in the mailbox now */
  uint64_t replaced;  /* dropped for a newer message of the same or higher priority */
  uint64_t refused;   /* not accepted: full of more important messages */
  uint64_t too_big;   /* not accepted: larger than a slot */
  uint64_t reclaimed; /* half-written by a sender that crashed */
};
TIMS_API void tims_mailbox_counters(const tims_mailbox* mailbox, struct tims_counters* counters);

/* --- Sending ---------------------------------------------------------------------------------- */

/* Sends to header->dest with its type, priority, seq_nr and flags; src and length are filled in.
 * body may be NULL when body_size is 0.
 *
 * To a known mailbox of this host the call never waits. A message that the router has to deliver
 * waits until the router has accepted earlier messages, at most 0.2 s if it does not respond. A
 * full mailbox drops its oldest message of the lowest priority if that priority is not above the
 * new message's; else TIMS_EFULL. If no mailbox has the address, the router answers a command (type
 * above 0) with type -3.
 *
 * 0, or TIMS_EFULL, TIMS_ETOO_BIG, TIMS_ENO_MAILBOX, TIMS_ENO_ROUTER, TIMS_ERECLAIMED. */
TIMS_API int tims_send(tims_mailbox* mailbox, const struct tims_header* header, const void* body,
                       size_t body_size);

/* tims_send() that never waits, neither for the router nor for a place. TIMS_ETIMEOUT: it would
 * have to; nothing is sent. */
TIMS_API int tims_try_send(tims_mailbox* mailbox, const struct tims_header* header,
                           const void* body, size_t body_size);

struct tims_piece {
  const void* data;
  size_t size;
};
/* Sends a body that consists of several pieces; more than 64 of them need an allocation. */
TIMS_API int tims_send_pieces(tims_mailbox* mailbox, const struct tims_header* header,
                              const struct tims_piece* pieces, size_t count);

/* Sends to the sender of `request`, with its priority and sequence number. */
TIMS_API int tims_reply(tims_mailbox* mailbox, const struct tims_header* request, int8_t type,
                        const void* body, size_t body_size);

/* Reserves a slot of the receiver for a body of body_size bytes: a large body is built in place and
 * not copied. The slot is held until the loan is sent or dropped. NULL with the errors of
 * tims_send. */
TIMS_API tims_loaned* tims_loan(tims_mailbox* mailbox, const struct tims_header* header,
                                size_t body_size);
TIMS_API void* tims_loan_body(tims_loaned* loan);
TIMS_API int tims_loan_send(tims_loaned* loan); /* releases the loan even on failure */
TIMS_API void tims_loan_drop(tims_loaned* loan);

/* --- Receiving -------------------------------------------------------------------------------- */

/* These functions take the oldest message of the highest priority. */

/* Copies the body to the front of buffer and returns its size. header may be NULL.
 * TIMS_EBUFFER_TOO_SMALL leaves the message first in the mailbox. TIMS_EEMPTY when timeout_ns is 0
 * or less, else TIMS_ETIMEOUT. */
TIMS_API int64_t tims_receive(tims_mailbox* mailbox, struct tims_header* header, void* buffer,
                              size_t buffer_size, int64_t timeout_ns);

/* Receives in place: the body, header->length - 16 bytes, can be read until tims_release(), and its
 * slot is held until then. header and body may be NULL. The memory is shared with the sender: trust
 * the bytes only as far as the sender. NULL with TIMS_EEMPTY or TIMS_ETIMEOUT. */
TIMS_API tims_guard* tims_peek(tims_mailbox* mailbox, struct tims_header* header, const void** body,
                               int64_t timeout_ns);
TIMS_API void tims_release(tims_guard* guard);

/* Discards every waiting message; returns their number. */
TIMS_API int64_t tims_clean(tims_mailbox* mailbox);

/* --- Addresses -------------------------------------------------------------------------------- */

/* An address is a number of four fields: system, class, instance, local. Their widths in bits are
 * the same in the whole fleet (address.widths of its routers); a session gets them from its router.
 * session NULL: the default widths, 8 bits each. */

struct tims_address_fields {
  uint32_t system;
  uint32_t class_id;
  uint32_t instance;
  uint32_t local;
};
/* Values that exceed the width of their field are truncated. */
TIMS_API uint32_t tims_make_address(const tims_session* session,
                                    const struct tims_address_fields* fields);
TIMS_API void tims_split_address(const tims_session* session, uint32_t address,
                                 struct tims_address_fields* fields);

/* Registers a name for a class of components that RACK does not define, with a number from 128 on:
 * this program then reads and writes "Thermometer(0/0)" instead of "unknown[80](0/0)". Call it
 * before the program starts threads. At most 64 names. 0, also if this class has this name already,
 * or TIMS_EINVALID. */
TIMS_API int tims_name_class(uint32_t class_id, const char* name);

/* "Ladar(3/0)", "Ladar(3/0):2" or "0x03140002"; class names are case-insensitive, also those of
 * tims_name_class(). 0 or TIMS_EINVALID. */
TIMS_API int tims_parse_address(const tims_session* session, const char* text, uint32_t* address);
/* Writes at most size bytes, NUL included; returns the length without NUL. */
TIMS_API size_t tims_format_address(const tims_session* session, uint32_t address, char* buffer,
                                    size_t size);

#ifdef __cplusplus
}
#endif

#endif
