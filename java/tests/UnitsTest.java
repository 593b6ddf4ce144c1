package rack;

import java.util.List;
import java.util.OptionalInt;
import rack.messages.CameraData;
import rack.messages.ChassisData;
import rack.messages.ClockData;
import rack.messages.DescriptionPage;
import rack.messages.DescriptionRequest;
import rack.messages.GdosData;
import rack.messages.LadarData;
import rack.messages.LadarPoint;
import rack.messages.Parameter;
import tims.Address;
import tims.Header;
import tims.Type;

/** What decides, without threads, clocks and messages. */
public final class UnitsTest {
  private static final Header REQUEST = Header.to(Address.parse("Ladar(0/0)"), Type.ON);

  private UnitsTest() {}

  public static void main(String[] arguments) throws Exception {
    addresses();
    values();
    lifeCycle();
    history();
    listeners();
    parameters();
    description();
  }

  private static void same(Object is, Object expected) {
    if (!is.equals(expected)) throw new AssertionError(is + ", expected " + expected);
  }

  private interface Action {
    void run() throws Exception;
  }

  private static void refused(Action action, String part) {
    try {
      action.run();
    } catch (Exception error) {
      if (error.getMessage().contains(part)) return;
      throw new AssertionError(error.getMessage() + ", expected " + part);
    }
    throw new AssertionError("was not refused: expected " + part);
  }

  private static void addresses() {
    same(Address.parse("Ladar(3/0):2"), 0x03140002);
    same(Address.parse("ladar(255/1)"), 0xff140100);
    same(Address.format(0x03140002), "Ladar(3/0):2");
    same(Address.format(Address.parse("0x80900100")), "0x80900100");
    for (String text : new String[] {"", "Ladar", "Ladar(256/0)", "Ladar(1/2", "Nobody(0/0)", "0x123456789", "Ladar(-1/0)"})
      refused(() -> Address.parse(text), text.startsWith("Nobody") ? "no class" : text.contains("256") ? "0 to 255" : "is no address");
  }

  private static void values() {
    refused(() -> {
      ClockData clock = new ClockData();
      clock.recordingTime = 1L << 32;
      clock.encode();
    }, "ClockData.recordingTime is 4294967296: expected a whole number from 0 to 4294967295");
    refused(() -> {
      Parameter one = new Parameter();
      one.name = "x".repeat(80);
      one.encode();
    }, "Parameter.name has 80 bytes, allowed are 79: shorten it");
    refused(() -> {
      LadarData scan = new LadarData();
      for (int i = 0; i < 2161; ++i) scan.points.add(new LadarPoint());
      scan.encode();
    }, "LadarData.points has 2161 elements, allowed are 2160: send fewer");
    refused(() -> {
      CameraData picture = new CameraData();
      picture.width = 2;
      picture.height = 2;
      picture.depth = 8;
      picture.image = new byte[3];
      picture.encode();
    }, "has 3 elements, but the other fields give 4");
    same(new ChassisData().activePilot, 0xffffff00);
    same(new GdosData().encode().length > 0, true);
  }

  private static void lifeCycle() {
    LifeCycle life = new LifeCycle();
    same(life.next(0), LifeCycle.Step.WAIT);
    same(life.turnOn(0, REQUEST), OptionalInt.empty());
    same(life.turnOn(0, REQUEST), OptionalInt.empty()); // both wait for the same result
    same(life.next(0), LifeCycle.Step.TURN_ON);
    same(life.failed(0, 10).size(), 2);
    same(life.status(), Type.ERROR);
    same(life.next(9), LifeCycle.Step.WAIT);
    same(life.next(10), LifeCycle.Step.TURN_ON);
    same(life.succeeded(LifeCycle.Step.TURN_ON).size(), 0);
    same(life.turnOn(11, REQUEST), OptionalInt.of(Type.OK));
    same(life.next(11), LifeCycle.Step.LOOP);
    same(life.failed(11, 1000), List.of());
    same(life.turnOn(12, REQUEST), OptionalInt.empty()); // an operator does not wait for the retry
    same(life.next(12), LifeCycle.Step.TURN_ON);
    same(life.turnOff().size(), 1);
    same(life.next(12), LifeCycle.Step.TURN_OFF);
    life.succeeded(LifeCycle.Step.TURN_OFF);
    same(life.status(), Type.DISABLED);
    for (int i = 0; i < 32; ++i) same(life.turnOn(13, REQUEST), OptionalInt.empty());
    same(life.turnOn(13, REQUEST), OptionalInt.of(Type.ERROR));
  }

  private static void history() throws Exception {
    DataHistory history = new DataHistory(3);
    refused(() -> history.at(0, 100), "no data yet");
    int start = -170; // the times wrap at 0
    for (int i = 0; i < 4; ++i) history.add(start + 100 * i, new byte[] {(byte) i});
    same(history.at(0, 100)[0], (byte) 3);
    same(history.at(start + 100, 100)[0], (byte) 1);
    same(history.at(start + 150, 100)[0], (byte) 2); // of two the later
    same(history.at(start + 149, 100)[0], (byte) 1);
    same(history.at(start + 500, 100)[0], (byte) 3);
    refused(() -> history.at(start + 501, 100), "not yet available");
    refused(() -> history.at(start + 99, 100), "no longer available");
  }

  private static void listeners() throws Exception {
    same(Listeners.reduction(0, 100), 1L);
    same(Listeners.reduction(199, 100), 1L);
    same(Listeners.reduction(200, 100), 2L);
    Listeners listeners = new Listeners(2);
    listeners.add(1, REQUEST, 2, false);
    listeners.add(2, REQUEST, 1, true);
    refused(() -> listeners.add(3, REQUEST, 1, false), "2 listeners already");
    same(listeners.due(Type.DATA, 0).size(), 1);
    same(listeners.due(Type.DATA, 0).get(0).dest(), 1);
    same(listeners.due(Type.DATA, 0).size(), 0);
    listeners.remove(1);
    same(listeners.clear(Type.ERROR), List.of());
  }

  private static void parameters() {
    Parameters all = new Parameters(Parameters.integer("period", 100, "period [ms]", 10, 1000),
        Parameters.real("gain", 0.5f, "gain", 0, 2), Parameters.text("file", "", "what to read"));
    all.parse("period", "10");
    all.parse("gain", "1.5");
    all.parse("file", "a=b");
    same(all.get("file"), "a=b");
    refused(() -> all.parse("period", "9"), "period is 9, allowed are 10 to 1000");
    refused(() -> all.parse("period", "fast"), "expected a whole number");
    refused(() -> all.parse("gain", "NaN"), "gain is NaN");
    refused(() -> all.parse("speed", "1"), "there is no parameter speed; there are period, gain, file");
    refused(() -> all.set("file", "x".repeat(80)), "shorten it");
    rack.messages.ParameterList list = all.list("Program");
    same(list.parameters.get(0).valueString, "Program");
    list.parameters.remove(0);
    list.parameters.get(0).valueInt = 20;
    list.parameters.get(1).valueFloat = 3f;
    refused(() -> all.set(list), "gain is 3.0, allowed are 0 to 2");
    same(all.get("period"), 10); // all or none
  }

  private static void description() {
    List<Parameters.Row> rows = new java.util.ArrayList<>(List.of(Parameters.real("gain", 0.5f, "gain \u00fc\u00fc \"x\" [%]", 0, 2)));
    for (int i = 0; i < 200; ++i) rows.add(Parameters.text("file" + i, "", "what to read, \u00e4"));
    Description long1 = new Description("P", "", 0x14, rows, false);
    StringBuilder whole = new StringBuilder();
    DescriptionRequest request = new DescriptionRequest();
    DescriptionPage page;
    do {
      request.bytesMax = 5 + request.offset % 3; // no page ends inside a character
      page = long1.page(request);
      whole.append(page.text);
      request.offset += page.text.getBytes(java.nio.charset.StandardCharsets.UTF_8).length;
    } while (request.offset < page.size);
    same(page.size > 4000, true);
    same(whole.toString().startsWith("{\"rack_description\": 1, \"program\": \"P\", \"purpose\": \"\", \"class\": \"Ladar\""), true);
    same(whole.toString().contains("\"default\": 0.5, \"min\": 0, \"max\": 2, \"unit\": \"%\", \"help\": \"gain \u00fc\u00fc \\\"x\\\"\""), true);
    same(whole.toString().contains("\ufffd"), false);
    same(whole.toString().endsWith("], \"inputs\": [], \"outputs\": []}\n"), true);
    request.offset = page.size;
    same(long1.page(request).text, "");
    request.offset = page.size + 1;
    refused(() -> long1.page(request), "the description has " + page.size + " bytes");
    request.offset = -1;
    refused(() -> long1.page(request), "from byte -1");
    request.offset = 0;
    request.bytesMax = 0;
    same(long1.page(request).text.getBytes(java.nio.charset.StandardCharsets.UTF_8).length <= 4000, true);
  }
}
