import java.io.BufferedReader;
import java.io.InputStreamReader;
import java.lang.reflect.Field;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.HexFormat;
import java.util.List;
import rack.CodecException;
import rack.Struct;
import rack.messages.Bodies;

/** The codec against that of C++: reads what `tims-schema --vectors` prints. */
public final class CodecTest {
  private int line;
  private String json;
  private int at;

  private CodecTest() {}

  public static void main(String[] arguments) throws Exception {
    CodecTest test = new CodecTest();
    int compared = 0;
    int damaged = 0;
    BufferedReader in = new BufferedReader(new InputStreamReader(System.in, StandardCharsets.ISO_8859_1));
    for (String text = in.readLine(); text != null; text = in.readLine()) {
      ++test.line;
      if (test.vector(text.split(" ", 4))) ++compared;
      else ++damaged;
    }
    test.check(compared > 200 && damaged > 50, "there are too few vectors");
    System.out.println(compared + " bodies are those of C++, " + damaged + " damaged ones are refused with the same words");
  }

  private void check(boolean holds, String what) {
    if (!holds) throw new AssertionError("vector " + line + ": " + what + (json == null ? "" : " at " + json.substring(Math.min(at, json.length()))));
  }

  /** False: it is a damaged one. */
  private boolean vector(String[] parts) throws Exception {
    ByteOrder order = parts[1].equals("little") ? ByteOrder.LITTLE_ENDIAN : ByteOrder.BIG_ENDIAN;
    byte[] body = parts[2].equals("-") ? new byte[0] : HexFormat.of().parseHex(parts[2]);
    json = null;
    try {
      Struct struct = decode(parts[0], body, order);
      check(!parts[3].startsWith("!"), "a damaged body was decoded: " + parts[3]);
      json = parts[3];
      at = 0;
      compareStruct(struct);
      check(at == json.length(), "C++ knows more of it");
      roundTrip(parts[0], struct, order);
      return true;
    } catch (CodecException error) {
      check(parts[3].equals("!" + error.getMessage()), "\"" + error.getMessage() + "\", in C++ " + parts[3]);
      return false;
    }
  }

  private static Struct decode(String name, byte[] body, ByteOrder order) {
    return Struct.decode(Bodies.BY_NAME.get(name).get(), ByteBuffer.wrap(body).order(order));
  }

  /** Through the other byte order, and back: the same bytes. A text that was not UTF-8 has grown, and may not fit. */
  private void roundTrip(String name, Struct struct, ByteOrder order) {
    ByteOrder other = order == ByteOrder.BIG_ENDIAN ? ByteOrder.LITTLE_ENDIAN : ByteOrder.BIG_ENDIAN;
    byte[] encoded;
    try {
      encoded = struct.encode(order);
    } catch (CodecException error) {
      check(json.contains("\\u00") && (error.getMessage().contains("allowed are") || error.getMessage().contains("expected")), error.getMessage());
      return;
    }
    Struct again = decode(name, decode(name, encoded, order).encode(other), other);
    check(Arrays.equals(again.encode(order), encoded), "the body changed on its way through the other byte order");
  }

  // --- the struct against the JSON of C++

  private void expect(String text) {
    check(json.startsWith(text, at), "expected " + text);
    at += text.length();
  }

  private void compareStruct(Struct struct) throws Exception {
    expect("{");
    boolean first = true;
    while (json.charAt(at) != '}') {
      if (!first) expect(",");
      first = false;
      expect("\"");
      int end = json.indexOf('"', at);
      String name = json.substring(at, end);
      at = end;
      expect("\":");
      compareField(struct, name);
    }
    expect("}");
  }

  private void compareField(Struct struct, String name) throws Exception {
    Field field;
    try {
      field = struct.getClass().getField(name);
    } catch (NoSuchFieldException error) { // a count: the length of its list
      number();
      return;
    }
    Object value = field.get(struct);
    if (value instanceof List<?> list) {
      compareMany(list.toArray());
    } else if (value instanceof float[] reals) {
      Object[] boxed = new Object[reals.length];
      for (int i = 0; i < reals.length; ++i) boxed[i] = reals[i];
      compareMany(boxed);
    } else if (value instanceof int[] whole) {
      compareMany(Arrays.stream(whole).boxed().toArray());
    } else if (value instanceof byte[] bytes) {
      compareBytes(bytes);
    } else {
      compareOne(value);
    }
  }

  private void compareMany(Object[] values) throws Exception {
    expect("[");
    for (int i = 0; i < values.length; ++i) {
      if (i > 0) expect(",");
      compareOne(values[i]);
    }
    expect("]");
  }

  private void compareBytes(byte[] bytes) throws Exception {
    if (json.charAt(at) == '"') {
      expect("\"" + HexFormat.of().formatHex(bytes) + "\"");
      return;
    }
    Object[] boxed = new Object[bytes.length];
    for (int i = 0; i < bytes.length; ++i) boxed[i] = bytes[i] & 0xff;
    compareMany(boxed);
  }

  private void compareOne(Object value) throws Exception {
    if (value instanceof Struct inner) compareStruct(inner);
    else if (value instanceof String text) check(text.equals(string()), "another text: " + text);
    else if (json.charAt(at) == '"') string(); // an address
    else compareNumber(value);
  }

  private void compareNumber(Object value) {
    String text = number();
    boolean same = text.equals("null")
        ? value instanceof Integer || !Double.isFinite(((Number) value).doubleValue())
        : value instanceof Float real ? Float.parseFloat(text) == real
        : value instanceof Double real ? Double.parseDouble(text) == real
        : Long.parseLong(text) == ((Number) value).longValue();
    check(same, value + " is " + text + " in C++");
  }

  private String number() {
    int start = at;
    while (at < json.length() && ",]}".indexOf(json.charAt(at)) < 0) ++at;
    return json.substring(start, at);
  }

  private String string() {
    expect("\"");
    java.io.ByteArrayOutputStream bytes = new java.io.ByteArrayOutputStream();
    for (; json.charAt(at) != '"'; ++at) {
      if (json.charAt(at) != '\\') {
        bytes.write(json.charAt(at));
      } else if (json.charAt(++at) == 'u') {
        bytes.write(Integer.parseInt(json.substring(at + 1, at + 5), 16));
        at += 4;
      } else {
        bytes.write(json.charAt(at));
      }
    }
    expect("\"");
    return new String(bytes.toByteArray(), StandardCharsets.UTF_8);
  }
}
