package tims;

import java.util.Map;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** Addresses: system, class, instance and local id, 8 bits each. */
public final class Address {
  private static final Pattern TEXT =
      Pattern.compile("([A-Za-z][A-Za-z0-9]*)\\((\\d{1,3})/(\\d{1,3})\\)(?::(\\d{1,3}))?");
  private static final Pattern NUMBER = Pattern.compile("0[xX][0-9a-fA-F]{1,8}");

  private Address() {}

  /** Of values from 0 to 255. */
  public static int of(int system, int classId, int instance, int local) {
    for (int each : new int[] {system, classId, instance, local})
      if (each < 0 || each > 255) throw new IllegalArgumentException(each + " in an address: expected 0 to 255");
    return system << 24 | classId << 16 | instance << 8 | local;
  }

  /**
   * "Ladar(3/0)", "Ladar(3/0):2" or "0x03140002".
   *
   * @throws IllegalArgumentException it is none of them
   */
  public static int parse(String text) {
    if (NUMBER.matcher(text).matches()) return Integer.parseUnsignedInt(text.substring(2), 16);
    Matcher found = TEXT.matcher(text);
    if (!found.matches())
      throw new IllegalArgumentException('"' + text + "\" is no address: expected one as Ladar(3/0) or 0x03140000");
    int local = found.group(4) == null ? 0 : Integer.parseInt(found.group(4));
    return of(Integer.parseInt(found.group(2)), classId(found.group(1)), Integer.parseInt(found.group(3)), local);
  }

  public static String format(int address) {
    String name = ClassNames.BY_ID.get(classOf(address));
    if (name == null) return String.format("0x%08x", address);
    String text = name + "(" + systemOf(address) + "/" + instanceOf(address) + ")";
    return localOf(address) == 0 ? text : text + ":" + localOf(address);
  }

  /** Its number, if the class has no name. */
  public static String className(int classId) {
    return ClassNames.BY_ID.getOrDefault(classId, String.valueOf(classId));
  }

  public static int systemOf(int address) {
    return address >>> 24;
  }

  public static int classOf(int address) {
    return address >>> 16 & 0xff;
  }

  public static int instanceOf(int address) {
    return address >>> 8 & 0xff;
  }

  public static int localOf(int address) {
    return address & 0xff;
  }

  private static int classId(String name) {
    for (Map.Entry<Integer, String> each : ClassNames.BY_ID.entrySet())
      if (each.getValue().equalsIgnoreCase(name)) return each.getKey();
    throw new IllegalArgumentException("there is no class " + name + ": write the address as a number, 0x00900000");
  }
}
