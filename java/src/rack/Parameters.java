package rack;

import java.util.ArrayList;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import rack.messages.Parameter;
import rack.messages.ParameterList;

/** The parameters of a component: options of its program, and changed by messages while it runs. */
public final class Parameters {
  /** A row; help is one line with the unit in brackets: "period of the data [ms]". */
  public record Row(String name, String help, Object initial, double min, double max) {}

  public static Row integer(String name, int initial, String help, int min, int max) {
    return new Row(name, help, initial, min, max);
  }

  public static Row real(String name, float initial, String help, double min, double max) {
    return new Row(name, help, initial, min, max);
  }

  /** At most 79 bytes. */
  public static Row text(String name, String initial, String help) {
    return new Row(name, help, initial, 0, 0);
  }

  private static final int TEXT_MAX = 79;

  private final Map<String, Row> rows = new LinkedHashMap<>();
  private final Map<String, Object> values = new LinkedHashMap<>();

  Parameters(Row... all) {
    for (Row each : all) {
      rows.put(each.name(), each);
      values.put(each.name(), each.initial());
    }
  }

  List<Row> rows() {
    return List.copyOf(rows.values());
  }

  synchronized Object get(String name) {
    Object value = values.get(name);
    if (value == null) throw new IllegalArgumentException("there is no parameter " + name + ": declare it in the constructor");
    return value;
  }

  /** @throws IllegalArgumentException there is no such parameter, or the value is of another type or out of range */
  synchronized void set(String name, Object value) {
    Row row = rows.get(name);
    if (row == null) throw new IllegalArgumentException("there is no parameter " + name + "; there are " + String.join(", ", rows.keySet()));
    if (row.initial().getClass() != value.getClass())
      throw new IllegalArgumentException(name + " is " + value + ": expected " + kind(row));
    if (value instanceof Number number && !(number.doubleValue() >= row.min() && number.doubleValue() <= row.max()))
      throw new IllegalArgumentException(name + " is " + value + ", allowed are " + shown(row.min()) + " to " + shown(row.max()));
    if (value instanceof String text && BodyWriter.utf8(text).length > TEXT_MAX)
      throw new IllegalArgumentException(name + " is longer than " + TEXT_MAX + " bytes: shorten it");
    values.put(name, value);
  }

  /** A value as it is written in the command line. */
  void parse(String name, String text) {
    Row row = rows.get(name);
    Object value = text;
    try {
      if (row != null && row.initial() instanceof Integer) value = Integer.valueOf(text);
      else if (row != null && row.initial() instanceof Float) value = Float.valueOf(text);
    } catch (NumberFormatException error) {
      throw new IllegalArgumentException(name + " is \"" + text + "\": expected " + kind(row));
    }
    set(name, value);
  }

  /** SET_PARAM: nothing is set if one of them is refused. */
  synchronized void set(ParameterList list) {
    Map<String, Object> before = new LinkedHashMap<>(values);
    try {
      for (Parameter each : list.parameters)
        set(each.name, each.type == 1 ? each.valueString : each.type == 2 ? (Object) each.valueFloat : (Object) each.valueInt);
    } catch (IllegalArgumentException error) {
      values.putAll(before);
      throw error;
    }
  }

  /** GET_PARAM: as the first the name of the program. */
  synchronized ParameterList list(String program) {
    ParameterList list = new ParameterList();
    list.parameters.add(one("name", program));
    values.forEach((name, value) -> list.parameters.add(one(name, value)));
    return list;
  }

  private static Parameter one(String name, Object value) {
    Parameter one = new Parameter();
    one.name = name;
    if (value instanceof Integer number) one.valueInt = number;
    else if (value instanceof Float number) one.valueFloat = number;
    else one.valueString = (String) value;
    one.type = value instanceof Integer ? 0 : value instanceof Float ? 2 : 1;
    return one;
  }

  String help() {
    List<String> lines = new ArrayList<>();
    for (Row each : rows.values())
      lines.add(String.format("  --%-20s %s (%s)", each.name(), each.help(), each.initial()));
    return String.join("\n", lines);
  }

  private static String kind(Row row) {
    return row.initial() instanceof Integer ? "a whole number" : row.initial() instanceof Float ? "a number" : "a text";
  }

  private static String shown(double value) {
    return value == Math.rint(value) ? String.valueOf((long) value) : String.valueOf(value);
  }
}
