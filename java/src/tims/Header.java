package tims;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;

/**
 * The 16 bytes before the body of every message.
 *
 * @param dest its receiver
 * @param src its sender
 * @param type above 0 a command, 0 success, below 0 a reply or data ({@link Type})
 * @param priority 0 to 255, higher is more important
 * @param seqNr 0 to 255; replies repeat it
 * @param flags {@link Flag}; bits that are not known are kept
 */
public record Header(int dest, int src, int type, int priority, int seqNr, int flags) {
  public static final int SIZE = 16;

  /** A message of this type to a mailbox; the mailbox that sends it fills in `src`. */
  public static Header to(int dest, int type) {
    return new Header(dest, 0, type, 0, 0, 0);
  }

  public Header withPriority(int value) {
    return new Header(dest, src, type, value, seqNr, flags);
  }

  public Header withSeqNr(int value) {
    return new Header(dest, src, type, priority, value, flags);
  }

  public Header withFlags(int value) {
    return new Header(dest, src, type, priority, seqNr, value);
  }

  Header withSrc(int value) {
    return new Header(dest, value, type, priority, seqNr, flags);
  }

  /** The byte order of the body. */
  public ByteOrder order() {
    return (flags & Flag.BODY_LITTLE_ENDIAN) != 0 ? ByteOrder.LITTLE_ENDIAN : ByteOrder.BIG_ENDIAN;
  }

  /** A whole message: this header in big endian, and a body in the order that its flags state. */
  byte[] message(byte[] body) {
    ByteBuffer out = ByteBuffer.allocate(SIZE + body.length);
    out.put((byte) (flags & ~Flag.HEADER_LITTLE_ENDIAN)).put((byte) type).put((byte) priority).put((byte) seqNr);
    return out.putInt(dest).putInt(src).putInt(SIZE + body.length).put(body).array();
  }

  /** The length that a header states, in bytes, of the whole message; unsigned. */
  static long length(byte[] header) {
    return Integer.toUnsignedLong(ordered(header).getInt(12));
  }

  static Header of(byte[] message) {
    ByteBuffer in = ordered(message);
    return new Header(in.getInt(4), in.getInt(8), message[1], message[2] & 0xff, message[3] & 0xff, message[0] & 0xff);
  }

  private static ByteBuffer ordered(byte[] header) {
    boolean little = (header[0] & Flag.HEADER_LITTLE_ENDIAN) != 0;
    return ByteBuffer.wrap(header).order(little ? ByteOrder.LITTLE_ENDIAN : ByteOrder.BIG_ENDIAN);
  }
}
