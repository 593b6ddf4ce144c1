package rack;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.util.ArrayList;
import java.util.List;
import java.util.function.Supplier;

/** Reads the fields of structs. No length in a body is trusted; errors have the words of the codec of C++. */
public final class BodyReader {
  private static final String ADVICE = "; its sender is broken, or has another version of this message";

  private final ByteBuffer body;

  BodyReader(ByteBuffer body) {
    this.body = body.slice().order(body.order());
  }

  /** At the start of a struct: it has at least so many bytes. */
  public void begin(String struct, int size) {
    if (body.remaining() < size)
      throw new CodecException(struct + " has at least " + size + " bytes, not " + body.remaining() + " bytes" + ADVICE);
  }

  void end(String struct, int whole, int surplus) {
    int size = body.position();
    int given = body.limit();
    if (given != size && given != whole && !(surplus > 0 && given == size + surplus))
      throw new CodecException(struct + " is " + size + " bytes long by its own counts, not " + given + " bytes" + ADVICE);
  }

  public int i8() {
    return body.get();
  }

  public int u8() {
    return body.get() & 0xff;
  }

  public int i16() {
    return body.getShort();
  }

  public int u16() {
    return body.getShort() & 0xffff;
  }

  public int i32() {
    return body.getInt();
  }

  public long u32() {
    return Integer.toUnsignedLong(body.getInt());
  }

  public long i64() {
    return body.getLong();
  }

  public float f32() {
    return body.getFloat();
  }

  public double f64() {
    return body.getDouble();
  }

  public float[] f32s(int count) {
    float[] values = new float[count];
    for (int i = 0; i < count; ++i) values[i] = body.getFloat();
    return values;
  }

  /** A text in a fixed number of bytes. Bytes that are not UTF-8 become U+FFFD. */
  public String text(int bytes) {
    byte[] raw = raw(bytes);
    int length = 0;
    while (length < bytes - 1 && raw[length] != 0) ++length;
    return new String(raw, 0, length, StandardCharsets.UTF_8);
  }

  // --- lists; `counted` is what an error names

  public byte[] bytes(String counted, long count, int most) {
    return raw(checked(counted, count, most, 1));
  }

  public String chars(String counted, long count, int most) {
    return new String(bytes(counted, count, most), StandardCharsets.UTF_8);
  }

  public int[] i32s(String counted, long count, int most) {
    int[] values = new int[checked(counted, count, most, 4)];
    for (int i = 0; i < values.length; ++i) values[i] = body.getInt();
    return values;
  }

  public <T extends Struct> List<T> structs(String counted, long count, int most, int size, Supplier<T> made) {
    int length = checked(counted, count, most, size);
    List<T> values = new ArrayList<>(length);
    for (int i = 0; i < length; ++i) values.add(struct(made.get()));
    return values;
  }

  public <T extends Struct> T struct(T into) {
    into.read(this);
    return into;
  }

  private int checked(String counted, long count, int most, int size) {
    if (count < 0 || count > most)
      throw new CodecException(counted + " is " + count + ", allowed are 0 to " + most + ADVICE);
    if (count * size > body.remaining())
      throw new CodecException(counted + " needs " + count * size + " bytes, only " + body.remaining() + " bytes follow" + ADVICE);
    return (int) count;
  }

  private byte[] raw(int count) {
    byte[] bytes = new byte[count];
    body.get(bytes);
    return bytes;
  }
}
