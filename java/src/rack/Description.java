package rack;

import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.List;
import java.util.Set;
import rack.messages.DescriptionPage;
import rack.messages.DescriptionRequest;
import tims.Address;

/** What a component states about itself as JSON, read page by page: components/runtime/logic/README.md has its members. */
final class Description {
  private static final int PAGE_MAX = 4000; // bytes
  private static final Set<String> AT_START = Set.of("system", "instance", "targetStatus");
  private static final Set<String> COMMON = Set.of("system", "instance", "gdosLevel", "targetStatus", "errorTimeout");

  private final byte[] text;

  /** hasData: it has the data of its class. */
  Description(String program, String purpose, int classId, List<Parameters.Row> rows, boolean hasData) {
    String name = Address.className(classId);
    text = ("{\"rack_description\": 1, \"program\": " + quoted(program) + ", \"purpose\": " + quoted(purpose) + ", \"class\": "
        + quoted(name) + ", \"class_id\": " + classId + ", \"parameters\": ["
        + String.join(",", rows.stream().map(Description::parameter).toList()) + "\n], \"inputs\": [], \"outputs\": ["
        + (hasData ? output(name, rows) : "") + "]}\n").getBytes(StandardCharsets.UTF_8);
  }

  /** @throws IllegalArgumentException there is no such page */
  DescriptionPage page(DescriptionRequest request) {
    int offset = request.offset;
    if (offset < 0 || offset > text.length || request.bytesMax < 0 || isInside(offset))
      throw new IllegalArgumentException("the description has " + text.length + " bytes, requested are " + request.bytesMax
          + " from byte " + offset + " on");
    int end = Math.min(text.length, offset + (request.bytesMax == 0 ? PAGE_MAX : Math.min(request.bytesMax, PAGE_MAX)));
    while (isInside(end)) --end;
    DescriptionPage page = new DescriptionPage();
    page.size = text.length;
    page.offset = offset;
    page.text = new String(Arrays.copyOfRange(text, offset, end), StandardCharsets.UTF_8);
    return page;
  }

  /** Of a character: the pages are texts. */
  private boolean isInside(int at) {
    return at < text.length && (text[at] & 0xc0) == 0x80;
  }

  private static String parameter(Parameters.Row row) {
    String help = row.help();
    int unit = help.indexOf('[');
    int after = help.indexOf(']', Math.max(unit, 0));
    StringBuilder out = new StringBuilder("\n  {\"name\": " + quoted(row.name()));
    if (row.initial() instanceof String initial) {
      out.append(", \"type\": \"text\", \"default\": ").append(quoted(initial));
    } else {
      out.append(", \"type\": ").append(row.initial() instanceof Integer ? "\"int\"" : "\"float\"").append(", \"default\": ")
          .append(row.initial()).append(", \"min\": ").append(number(row.min())).append(", \"max\": ").append(number(row.max()));
    }
    if (unit >= 0 && after > unit) {
      out.append(", \"unit\": ").append(quoted(help.substring(unit + 1, after)));
      help = (help.substring(0, unit).stripTrailing() + help.substring(after + 1)).strip();
    }
    out.append(", \"help\": ").append(quoted(help)).append(", \"takes_effect\": \"")
        .append(AT_START.contains(row.name()) ? "start" : COMMON.contains(row.name()) ? "now" : "on").append('"');
    return out.append(COMMON.contains(row.name()) ? ", \"common\": true}" : "}").toString();
  }

  private static String output(String name, List<Parameters.Row> rows) {
    String period = rows.stream().filter(row -> row.name().equals("period") || row.name().equals("periodTime"))
        .filter(row -> row.initial() instanceof Integer).findFirst()
        .map(row -> ", \"period\": " + quoted(row.name()) + ", \"default_ms\": " + row.initial()).orElse("");
    return "{\"class\": " + quoted(name) + ", \"message\": \"DATA\"" + period + "}";
  }

  private static String number(double value) {
    double finite = Math.max(-Float.MAX_VALUE, Math.min(Float.MAX_VALUE, value));
    return finite == Math.rint(finite) && Math.abs(finite) < 1e15 ? String.valueOf((long) finite) : String.valueOf(finite);
  }

  private static String quoted(String text) {
    StringBuilder out = new StringBuilder("\"");
    for (char each : text.toCharArray()) {
      if (each == '"' || each == '\\') out.append('\\').append(each);
      else if (each < ' ') out.append(String.format("\\u%04x", (int) each));
      else out.append(each);
    }
    return out.append('"').toString();
  }
}
