package rack;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.List;

/** Writes the fields of structs; refuses values that they cannot hold. */
public final class BodyWriter {
  private ByteBuffer body = ByteBuffer.allocate(256);

  BodyWriter(ByteOrder order) {
    body.order(order);
  }

  byte[] bytes() {
    return Arrays.copyOf(body.array(), body.position());
  }

  public void i8(String field, int value) {
    room(1).put((byte) whole(field, value, Byte.MIN_VALUE, Byte.MAX_VALUE));
  }

  public void u8(String field, int value) {
    room(1).put((byte) whole(field, value, 0, 0xff));
  }

  public void i16(String field, int value) {
    room(2).putShort((short) whole(field, value, Short.MIN_VALUE, Short.MAX_VALUE));
  }

  public void u16(String field, int value) {
    room(2).putShort((short) whole(field, value, 0, 0xffff));
  }

  public void i32(String field, int value) {
    room(4).putInt(value);
  }

  public void u32(String field, long value) {
    room(4).putInt((int) whole(field, value, 0, 0xffffffffL));
  }

  public void i64(String field, long value) {
    room(8).putLong(value);
  }

  public void f32(String field, float value) {
    room(4).putFloat(value);
  }

  public void f64(String field, double value) {
    room(8).putDouble(value);
  }

  public void f32s(String field, float[] values, int count) {
    if (values.length != count)
      throw new CodecException(field + " has " + values.length + " elements, not " + count);
    for (float value : values) room(4).putFloat(value);
  }

  public void text(String field, String value, int bytes) {
    byte[] raw = utf8(value);
    if (raw.length >= bytes)
      throw new CodecException(field + " has " + raw.length + " bytes, allowed are " + (bytes - 1) + ": shorten it");
    room(bytes).put(raw).put(new byte[bytes - raw.length]);
  }

  // --- lists

  /** The count before a list. */
  public void count(String field, int count, int most) {
    room(4).putInt(checked(field, count, most));
  }

  /** A tail, whose count the other fields state. */
  public void tail(String field, int count, long stated, int most) {
    checked(field, count, most);
    if (stated != count)
      throw new CodecException(field + " has " + count + " elements, but the other fields give " + stated + ": correct one of them");
  }

  public void bytes(byte[] values) {
    room(values.length).put(values);
  }

  public void i32s(int[] values) {
    for (int value : values) room(4).putInt(value);
  }

  public void structs(List<? extends Struct> values) {
    for (Struct value : values) value.write(this);
  }

  public void struct(Struct value) {
    value.write(this);
  }

  /** Zeros up to the size of the whole body. */
  public void pad(int size) {
    if (body.position() < size) room(size - body.position()).put(new byte[size - body.position()]);
  }

  public static byte[] utf8(String text) {
    return text.getBytes(StandardCharsets.UTF_8);
  }

  private static int checked(String field, int count, int most) {
    if (count > most)
      throw new CodecException(field + " has " + count + " elements, allowed are " + most + ": send fewer");
    return count;
  }

  private static long whole(String field, long value, long low, long high) {
    if (value < low || value > high)
      throw new CodecException(field + " is " + value + ": expected a whole number from " + low + " to " + high);
    return value;
  }

  private ByteBuffer room(int bytes) {
    if (body.remaining() < bytes) {
      int size = Math.max(2 * body.capacity(), body.position() + bytes);
      body = ByteBuffer.allocate(size).order(body.order()).put(bytes());
    }
    return body;
  }
}
