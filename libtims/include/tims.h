/* libtims for C, and for every language that binds to C.
 *
 * A component is a program that talks to others through mailboxes. It connects to the router of its
 * host, opens mailboxes, each with an address of its own, and sends from them and receives in them.
 * A message is a header of 16 bytes and a body, whose bytes are carried as they are.
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
 * A function that returns a number returns 0, or a count, when it has done what it says, and a
 * negative TIMS_E... when it has not. A function that returns a pointer returns NULL then. Either
 * way tims_error_code() has the code and tims_error_text() the sentence with all details, for the
 * calling thread's last failure. What a call may fail with is said at the call.
 *
 * Pointers must not be NULL unless it is said that they may.
 *
 * Ownership
 * ---------
 *
 * What a function hands out is given back with its partner, once:
 *
 *     tims_connect, tims_connect_with    tims_disconnect
 *     tims_open, tims_open_all           tims_close, tims_close_linger
 *     tims_peek                          tims_release
 *     tims_loan                          tims_loan_send or tims_loan_drop
 *
 * A mailbox may outlive its session: the connection ends with the last of them. A guard and a loan
 * end before their mailbox does. What is passed to a call is only looked at while the call lasts.
 *
 * Threads
 * -------
 *
 * Every function may be called from any thread at any time. Several threads may receive from one
 * mailbox; each message goes to one of them. Only the call that gives something back must be the
 * last one with it. A session has threads of its own; a child made by fork() has none of them, and
 * must leave its parent's sessions and mailboxes alone.
 *
 * Time
 * ----
 *
 * Time-outs are nanoseconds. TIMS_FOREVER waits without limit; 0 or less does not wait.
 *
 * Cost
 * ----
 *
 * A message between two mailboxes of one host is one copy and at most one wake-up, without the
 * router, and without a system call while the receiver is awake. Sending and copying receives
 * allocate nothing; tims_peek and tims_loan allocate a few bytes for what they hand out.
 *
 * The first message to an address, and the first one after its owner has closed or died, asks the
 * router where it is and waits for the answer: as a rule a fraction of a millisecond, for a router
 * that stands still 5 s. Who may not wait sends something to each address before it counts.
 *
 * Routers that come and go
 * ------------------------
 *
 * While there is no router, mailboxes of this host that know each other go on talking. When it is
 * back, or another one in its place, the session registers its mailboxes again by itself. Messages
 * for elsewhere that a router had not taken yet, up to 1024, wait for the next one, 30 s at most.
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

/* Of the library that runs, "0.1.0"; never freed. Programs and libraries of the same first two
 * numbers go together. */
TIMS_API const char* tims_version(void);

/* --- Errors ----------------------------------------------------------------------------------- */

enum tims_error {
  TIMS_EEMPTY = -1,             /* no message is waiting */
  TIMS_ETIMEOUT = -2,           /* the time given has passed */
  TIMS_ECLOSED = -3,            /* the mailbox or session was closed */
  TIMS_ENO_ROUTER = -4,         /* no router there, or it did not answer */
  TIMS_EREFUSED = -5,           /* the router said no */
  TIMS_EADDRESS_IN_USE = -6,    /* somebody else owns the address; the text names the owner */
  TIMS_ENO_MAILBOX = -7,        /* no such mailbox on this host any more */
  TIMS_EFULL = -8,              /* the receiver is full of more important messages */
  TIMS_ETOO_BIG = -9,           /* larger than the receiver takes */
  TIMS_EBUFFER_TOO_SMALL = -10, /* the caller's buffer; the message stays in the mailbox */
  TIMS_ERECLAIMED = -11,        /* the slot was taken back from this writer */
  TIMS_EBAD_LAYOUT = -12,       /* shared memory that does not look like a mailbox */
  TIMS_EVERSION = -13,          /* library and router share no protocol version */
  TIMS_EINVALID = -14,          /* the call itself is wrong; the text says what of it */
  TIMS_ESYSTEM = -15,           /* the operating system refused; the text has its words */
  TIMS_EANSWERED_ERROR = -16,   /* a component answered ERROR */
  TIMS_EMALFORMED = -17,        /* bytes that are not the message they should be */
  TIMS_EDISKFULL = -18          /* no room for a file */
};

/* Of the calling thread's last failure: 0 when there was none. The text is valid until this
 * thread's next failure. */
TIMS_API int tims_error_code(void);
TIMS_API const char* tims_error_text(void);
/* Of a code, one word for logs and scripts ("address_in_use"); never freed. */
TIMS_API const char* tims_error_name(int code);

/* --- Types ------------------------------------------------------------------------------------ */

/* NOLINTBEGIN(modernize-use-using): C */
typedef struct tims_session tims_session; /* a connection to a router */
typedef struct tims_mailbox tims_mailbox; /* where messages are sent from and received */
typedef struct tims_guard tims_guard;     /* a received message that is looked at in its place */
typedef struct tims_loaned tims_loaned;   /* room in a receiver's mailbox, to build a message in */
/* NOLINTEND(modernize-use-using) */

#define TIMS_HEADER_SIZE 16

/* Bits of tims_header.flags. Others travel untouched; those of the header's own byte order are the
 * library's business. */
#define TIMS_BODY_LITTLE_ENDIAN 0x02 /* order of the numbers in the body; not set: big endian */
#define TIMS_STREAM 0x10       /* a sample: a newer one may replace it where a link is short */
#define TIMS_TRACE 0x20        /* every router on the way tells the sender */
#define TIMS_TELL_IF_GONE 0x40 /* answer NOT_AVAILABLE when nobody owns dest, as for commands */
#define TIMS_TELL_WHY 0x80     /* who refuses this command says why, behind ERROR */

/* In the machine's own byte order. */
struct tims_header {
  uint32_t dest;
  uint32_t src;
  uint32_t length;  /* bytes, the 16 of the header included */
  uint8_t flags;    /* TIMS_... bits */
  int8_t type;      /* above 0 a command, 0 success, below 0 a reply or data */
  uint8_t priority; /* 0 to 255, higher is more important */
  uint8_t seq_nr;   /* replies repeat it */
};

/* --- Sessions --------------------------------------------------------------------------------- */

/* Connects to a router and waits for it at most timeout_ns.
 *
 * router: "unix:PATH", "/PATH", "HOST:PORT", "HOST" (port 2000), "[IPv6]:PORT". NULL: $TIMS_ROUTER;
 * else the user's own router, when there is one; else /run/tims/router.sock.
 * name: of this program, as `timsctl` shows it, at most 31 bytes. NULL: the process's name.
 *
 * Over TCP the session is a client of the original protocol, and the router may be an original one:
 * what is sent goes through the router, also from one mailbox of the session to another.
 *
 * NULL with TIMS_ETIMEOUT, TIMS_EREFUSED, TIMS_EVERSION, TIMS_EINVALID (router is no address). */
TIMS_API tims_session* tims_connect(const char* router, const char* name, int64_t timeout_ns);

/* What happens to a session while it lives. */
enum tims_event {
  TIMS_EVENT_WAITING = 0,       /* no router answers; trying again */
  TIMS_EVENT_CONNECTED = 1,     /* to a router, for the first time or again */
  TIMS_EVENT_LOST = 2,          /* the router went away; trying again */
  TIMS_EVENT_MAILBOX_LOST = 3,  /* somebody else owns the address by now; tried again later */
  TIMS_EVENT_MESSAGES_LOST = 4, /* what waited for the former router is too old */
};

/* 0 and NULL stand for the default. */
struct tims_session_options {
  const char* router; /* as for tims_connect */
  const char* name;
  int64_t timeout_ns; /* 0: TIMS_FOREVER */
  /* The largest message that a router reached over TCP takes, header included: it does not say so
   * itself, and closes the connection of whoever sends a larger one. 16 to 2^30; default 262144. */
  uint32_t tcp_message_max;
  /* Real-time priority (SCHED_FIFO, 1 to 99) of the thread that carries messages over TCP; default,
   * or without the right to it: none. */
  int32_t tcp_priority;
  /* Called from a thread of the session with `user` and one line for people, which is valid while
   * the call lasts. It must not give the session back. Default: all but TIMS_EVENT_CONNECTED are
   * written to stderr. */
  void (*on_event)(void* user, enum tims_event event, const char* text);
  void* user;
};
TIMS_API tims_session* tims_connect_with(const struct tims_session_options* options);

/* NULL is allowed. What is still on the way is not waited for: tims_flush. */
TIMS_API void tims_disconnect(tims_session* session);

/* 1 while a router is there, else 0. */
TIMS_API int tims_is_connected(const tims_session* session);
/* The router's own address; over TCP 0. */
TIMS_API uint32_t tims_router_address(const tims_session* session);
/* Waits until the router has taken all that was sent through this session before: it goes on from
 * there also when this program ends. Messages to mailboxes of this host are in those as soon as
 * they are sent. While there is no router the call waits for the next one.
 *
 * 0, or TIMS_ETIMEOUT: what is left still goes out as long as the session lives. */
TIMS_API int tims_flush(tims_session* session, int64_t timeout_ns);

/* Where tims_connect(NULL, ...) looks. Writes at most size bytes, NUL included; returns the length
 * without NUL. */
TIMS_API size_t tims_default_router(char* buffer, size_t size);

/* --- Mailboxes -------------------------------------------------------------------------------- */

struct tims_mailbox_options {
  uint32_t address;
  uint32_t slots;    /* messages it can hold, 1 to 65535 */
  uint32_t body_max; /* largest body it takes, bytes, at most 2^30 - 16 */
  uint8_t event_fd;  /* not 0: tims_event_fd() works */
  uint8_t reserved[3];
  /* How long a receive looks for the next message, and yields the processor between two looks,
   * before it sleeps: for streams, where waking costs more than the message. Nanoseconds. */
  int64_t spin_ns;
};

/* Waits for a router when there is none at the moment. NULL with TIMS_EADDRESS_IN_USE,
 * TIMS_EINVALID (slots or body_max), TIMS_EREFUSED (the router has room for no more). */
TIMS_API tims_mailbox* tims_open(tims_session* session, const struct tims_mailbox_options* options);
/* All or none, in one exchange with the router: writes `count` mailboxes. 0, or as tims_open. */
TIMS_API int tims_open_all(tims_session* session, const struct tims_mailbox_options* options,
                           size_t count, tims_mailbox** mailboxes);

/* Senders learn it with their next message; what waits in the mailbox is lost. NULL is allowed. */
TIMS_API void tims_close(tims_mailbox* mailbox);
/* tims_flush() of its session, and tims_close() then or after linger_ns. 0, or TIMS_ETIMEOUT: the
 * mailbox is closed either way. */
TIMS_API int tims_close_linger(tims_mailbox* mailbox, int64_t linger_ns);

TIMS_API uint32_t tims_mailbox_address(const tims_mailbox* mailbox);
TIMS_API uint32_t tims_mailbox_body_max(const tims_mailbox* mailbox);

/* For an event loop: a descriptor to poll, and for nothing else, which is readable when a message
 * has come. After each wake-up receive with time-out 0 until TIMS_EEMPTY: that arms it again. It is
 * the mailbox's, and goes with it. -1 without the option. */
TIMS_API int tims_event_fd(const tims_mailbox* mailbox);

struct tims_counters {
  uint64_t received;  /* by the owner */
  uint64_t waiting;   /* in the mailbox now */
  uint64_t replaced;  /* thrown away for a newer message of the same or higher priority */
  uint64_t refused;   /* not taken: full of more important messages */
  uint64_t too_big;   /* not taken: larger than a slot */
  uint64_t reclaimed; /* half-written by a sender that died */
};
TIMS_API void tims_mailbox_counters(const tims_mailbox* mailbox, struct tims_counters* counters);

/* --- Sending ---------------------------------------------------------------------------------- */

/* Sends to header->dest with its type, priority, seq_nr and flags; src and length are filled in.
 * body may be NULL when body_size is 0.
 *
 * To a known mailbox of this host the call never waits. What the router has to deliver waits until
 * it has taken earlier messages, at most 0.2 s when it stands still. A full mailbox throws away its
 * oldest message of the lowest priority, if that is not above the new one's: else TIMS_EFULL. A
 * command (type above 0) to an address that nobody owns is answered by the router with type -3.
 *
 * 0, or TIMS_EFULL, TIMS_ETOO_BIG, TIMS_ENO_MAILBOX, TIMS_ENO_ROUTER, TIMS_ERECLAIMED. */
TIMS_API int tims_send(tims_mailbox* mailbox, const struct tims_header* header, const void* body,
                       size_t body_size);

struct tims_piece {
  const void* data;
  size_t size;
};
/* The body in several pieces, one behind the other; more than 64 of them cost an allocation. */
TIMS_API int tims_send_pieces(tims_mailbox* mailbox, const struct tims_header* header,
                              const struct tims_piece* pieces, size_t count);

/* Back to the sender of `request`, with its priority and sequence number. */
TIMS_API int tims_reply(tims_mailbox* mailbox, const struct tims_header* request, int8_t type,
                        const void* body, size_t body_size);

/* Room for a body of body_size bytes in the receiver's own slot: a large body is built in its place
 * and not copied. Until it is sent or dropped the slot is held. NULL as tims_send. */
TIMS_API tims_loaned* tims_loan(tims_mailbox* mailbox, const struct tims_header* header,
                                size_t body_size);
TIMS_API void* tims_loan_body(tims_loaned* loan);
TIMS_API int tims_loan_send(tims_loaned* loan); /* the loan is gone afterwards, sent or not */
TIMS_API void tims_loan_drop(tims_loaned* loan);

/* --- Receiving -------------------------------------------------------------------------------- */

/* The most important message, of those the oldest. */

/* Copies the body to the front of buffer and returns its size. header may be NULL.
 * TIMS_EBUFFER_TOO_SMALL leaves the message first in the mailbox. TIMS_EEMPTY when timeout_ns is 0
 * or less, else TIMS_ETIMEOUT. */
TIMS_API int64_t tims_receive(tims_mailbox* mailbox, struct tims_header* header, void* buffer,
                              size_t buffer_size, int64_t timeout_ns);

/* In its place: the body, header->length - 16 bytes, can be read until tims_release(), and its slot
 * is held as long. header and body may be NULL. The bytes are in memory that the sender shares:
 * they are to be trusted as far as the sender is. NULL with TIMS_EEMPTY or TIMS_ETIMEOUT. */
TIMS_API tims_guard* tims_peek(tims_mailbox* mailbox, struct tims_header* header, const void** body,
                               int64_t timeout_ns);
TIMS_API void tims_release(tims_guard* guard);

/* Throws away every waiting message; returns how many. */
TIMS_API int64_t tims_clean(tims_mailbox* mailbox);

/* --- Addresses -------------------------------------------------------------------------------- */

/* An address is a number of four fields: system, class, instance, local. How many bits each has is
 * the same in a whole fleet (address.widths of its routers): a session knows it from its router.
 * session NULL, as long as there is none: 8 bits each, as in fleets that say nothing else. */

struct tims_address_fields {
  uint32_t system;
  uint32_t class_id;
  uint32_t instance;
  uint32_t local;
};
/* Each field is cut to its width. */
TIMS_API uint32_t tims_make_address(const tims_session* session,
                                    const struct tims_address_fields* fields);
TIMS_API void tims_split_address(const tims_session* session, uint32_t address,
                                 struct tims_address_fields* fields);

/* "Ladar(3/0)", "Ladar(3/0):2" or "0x03140002"; class names without regard to case. 0 or
 * TIMS_EINVALID. */
TIMS_API int tims_parse_address(const tims_session* session, const char* text, uint32_t* address);
/* Writes at most size bytes, NUL included; returns the length without NUL. */
TIMS_API size_t tims_format_address(const tims_session* session, uint32_t address, char* buffer,
                                    size_t size);

#ifdef __cplusplus
}
#endif

#endif
