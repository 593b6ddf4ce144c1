package tims;

import java.io.IOException;

/** What went wrong, where, and what to do. */
public class TimsException extends IOException {
  private static final long serialVersionUID = 1;

  /** The errors of tims.h that a client without shared memory can meet. */
  public enum Code {
    TIMEOUT,
    CLOSED,
    NO_ROUTER,
    REFUSED,
    ADDRESS_IN_USE,
    NO_MAILBOX,
    TOO_BIG,
    INVALID,
    ANSWERED_ERROR,
    MALFORMED
  }

  private final Code code;

  public TimsException(Code code, String text) {
    super(text);
    this.code = code;
  }

  public Code code() {
    return code;
  }
}
