package tims;

import java.nio.ByteBuffer;

/** A message that was received. */
public final class Message {
  private final Header header;
  private final byte[] body;

  public Message(Header header, byte[] body) {
    this.header = header;
    this.body = body;
  }

  static Message of(byte[] whole) {
    return new Message(Header.of(whole), java.util.Arrays.copyOfRange(whole, Header.SIZE, whole.length));
  }

  public Header header() {
    return header;
  }

  public int type() {
    return header.type();
  }

  public int src() {
    return header.src();
  }

  /** Its body in the byte order that its header states; not to be written to. */
  public ByteBuffer body() {
    return ByteBuffer.wrap(body).asReadOnlyBuffer().order(header.order());
  }

  public int bodySize() {
    return body.length;
  }
}
