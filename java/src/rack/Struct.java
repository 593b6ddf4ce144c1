package rack;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import tims.Message;

/** The body of a message. Fields, units and names are those of C++: mm, rad clockwise, ms. */
public abstract class Struct {
  /** The bytes of a body in big endian. @throws CodecException a value that the struct cannot hold */
  public final byte[] encode() {
    return encode(ByteOrder.BIG_ENDIAN);
  }

  public final byte[] encode(ByteOrder order) {
    BodyWriter out = new BodyWriter(order);
    write(out);
    return out.bytes();
  }

  /** Fills a struct from a body in the byte order of the buffer. @throws CodecException it is not this struct */
  public static <T extends Struct> T decode(T into, ByteBuffer body) {
    BodyReader in = new BodyReader(body);
    into.read(in);
    in.end(into.getClass().getSimpleName(), into.wholeSize(), into.surplus());
    return into;
  }

  public static <T extends Struct> T decode(T into, Message message) {
    return decode(into, message.body());
  }

  /** A body of so many bytes is accepted, too; 0: no other. */
  protected int wholeSize() {
    return 0;
  }

  /** A body that is longer by so many bytes is accepted, too. */
  protected int surplus() {
    return 0;
  }

  protected abstract void read(BodyReader in);

  protected abstract void write(BodyWriter out);
}
