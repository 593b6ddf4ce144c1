/* libtims for C, and for every language that binds to C.
 *
 * A component connects to the router of its host (tims_connect), opens mailboxes (tims_open), and
 * sends and receives through them.
 *
 * Conventions
 *   Errors     Functions return 0 or a count on success and a negative TIMS_E... otherwise.
 *              tims_error_text() gives the sentence with all details for the calling thread's last
 *              failure.
 *   Ownership  What a function hands out is given back with its partner: tims_connect /
 *              tims_disconnect, tims_open / tims_close, tims_peek / tims_release,
 *              tims_loan / tims_loan_send or tims_loan_drop. Mailboxes may outlive their
 *              session; guards and loans go before their mailbox.
 *   Threads    Every function may be called from any thread; several threads may receive from one
 *              mailbox, each message goes to one of them. tims_close() must be the last call.
 *   Time       Nanoseconds. TIMS_FOREVER waits without limit, 0 does not wait.
 *   Cost       No allocation for sending and copying receives; tims_peek and tims_loan allocate a
 *              few bytes (for the handle). No system call while the receiver is awake. The first
 * message to an address asks the router where it is. Bytes      Bodies are carried as they are.
 * Header fields are in native order.
 */
#ifndef TIMS_H
#define TIMS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TIMS_FOREVER INT64_MAX

enum tims_error {
  TIMS_EEMPTY = -1,             /* no message waiting */
  TIMS_ETIMEOUT = -2,           /* the time given has passed */
  TIMS_ECLOSED = -3,            /* the mailbox or session was closed */
  TIMS_ENO_ROUTER = -4,         /* no router at the socket */
  TIMS_EREFUSED = -5,           /* the router said no */
  TIMS_EADDRESS_IN_USE = -6,    /* somebody else owns the address */
  TIMS_ENO_MAILBOX = -7,        /* no such mailbox here */
  TIMS_EFULL = -8,              /* receiver full of more important messages */
  TIMS_ETOO_BIG = -9,           /* larger than the receiver's slot */
  TIMS_EBUFFER_TOO_SMALL = -10, /* the caller's buffer; the message stays in the mailbox */
  TIMS_ERECLAIMED = -11,        /* the slot was taken back from this writer */
  TIMS_EBAD_LAYOUT = -12,       /* shared memory that does not look like a mailbox */
  TIMS_EVERSION = -13,          /* client and router share no protocol version */
  TIMS_EINVALID = -14,          /* the call itself is wrong */
  TIMS_ESYSTEM = -15,           /* the operating system refused */
  TIMS_EANSWERED_ERROR = -16,   /* the component answered ERROR */
  TIMS_EMALFORMED = -17,        /* bytes that are not the message they should be */
  TIMS_EDISKFULL = -18          /* no room for a file */
};

/* Bits of flags (others travel untouched). */
#define TIMS_BODY_LITTLE_ENDIAN 0x02
#define TIMS_TRACE 0x20  /* every router on the way tells the sender */
#define TIMS_STREAM 0x10 /* a sample: a newer one may replace it where a link is short */

struct tims_header {
  uint32_t dest;
  uint32_t src;
  uint32_t length; /* bytes, the 16 of the header included */
  uint8_t flags;
  int8_t type; /* > 0 command, 0 success, < 0 reply or data */
  uint8_t priority;
  uint8_t seq_nr;
};

struct tims_mailbox_options {
  uint32_t address;
  uint32_t slots;    /* messages it can hold, 1 to 65535 */
  uint32_t body_max; /* largest body it takes, bytes */
  uint8_t event_fd;  /* not 0: tims_event_fd() works */
};

/* NOLINTBEGIN(modernize-use-using): C */
typedef struct tims_session tims_session;
typedef struct tims_mailbox tims_mailbox;
typedef struct tims_guard tims_guard;
typedef struct tims_loaned tims_loaned;
/* NOLINTEND(modernize-use-using) */

/* The sentence for the calling thread's last failure; valid until its next failure. */
const char* tims_error_text(void);

/* router: "unix:PATH", "/PATH" or "HOST:PORT"; NULL: $TIMS_ROUTER, the user's socket, or
 * /run/tims/router.sock. name NULL: the program's. Waits for a router at most timeout_ns. NULL on
 * failure. */
tims_session* tims_connect(const char* router, const char* name, int64_t timeout_ns);
void tims_disconnect(tims_session* session);

/* NULL on failure, e.g. TIMS_EADDRESS_IN_USE: tims_error_text() names the owner. */
tims_mailbox* tims_open(tims_session* session, const struct tims_mailbox_options* options);
/* Senders learn it with their next message. */
void tims_close(tims_mailbox* mailbox);
/* For an event loop: a descriptor to poll, and for nothing else, which is readable when a message
 * has come. Receive with timeout 0 until TIMS_EEMPTY after each wake-up: that arms it again. -1
 * without the option. */
int tims_event_fd(const tims_mailbox* mailbox);

/* Sends header->dest, type, priority, seq_nr, flags; src and length are filled in. Never blocks. */
int tims_send(tims_mailbox* mailbox, const struct tims_header* header, const void* body,
              size_t body_size);
/* Back to the sender of `request`, with its priority and sequence number. */
int tims_reply(tims_mailbox* mailbox, const struct tims_header* request, int8_t type,
               const void* body, size_t body_size);
/* Room for a body in the receiver's own slot. NULL on failure. */
tims_loaned* tims_loan(tims_mailbox* mailbox, const struct tims_header* header, size_t body_size);
void* tims_loan_body(tims_loaned* loan);
int tims_loan_send(tims_loaned* loan); /* the loan is gone afterwards, sent or not */
void tims_loan_drop(tims_loaned* loan);

/* Copies the body; returns its size. TIMS_EBUFFER_TOO_SMALL leaves the message in its place. */
int64_t tims_receive(tims_mailbox* mailbox, struct tims_header* header, void* buffer,
                     size_t buffer_size, int64_t timeout_ns);
/* In place: the body can be read until tims_release(). NULL on failure. */
tims_guard* tims_peek(tims_mailbox* mailbox, struct tims_header* header, const void** body,
                      int64_t timeout_ns);
void tims_release(tims_guard* guard);
/* Throws away every waiting message; returns how many. */
int64_t tims_clean(tims_mailbox* mailbox);

/* An address is a number of four fields: system, class, instance, local. How many bits each has is
 * the same in a whole fleet (address.widths of its routers): a session knows it from its router.
 * session NULL, as long as there is none: 8 bits each, as in fleets that say nothing else. */

/* "Ladar(3/0)", "Ladar(3/0):2" or "0x03140002"; 0 or TIMS_EINVALID. */
int tims_parse_address(const tims_session* session, const char* text, uint32_t* address);
/* Writes at most size bytes, NUL included; returns the length without NUL. */
size_t tims_format_address(const tims_session* session, uint32_t address, char* buffer,
                           size_t size);

#ifdef __cplusplus
}
#endif

#endif
