import java.time.Duration;
import java.util.concurrent.LinkedBlockingQueue;
import rack.messages.LadarData;
import rack.messages.LadarProxy;
import tims.Address;
import tims.Header;
import tims.Mailbox;
import tims.Message;
import tims.Session;
import tims.TimsException;
import tims.Type;

/** ClientTest ROUTER: the client against a router with Ladar(0/3); prints "lost" and "again" when the router is restarted. */
public final class ClientTest {
  private static final Duration PATIENCE = Duration.ofSeconds(60);

  private ClientTest() {}

  public static void main(String[] arguments) throws Exception {
    LinkedBlockingQueue<String> events = new LinkedBlockingQueue<>();
    Session.Options options = new Session.Options(arguments[0]).timeout(PATIENCE).events(events::add);
    try (Session session = Session.connect(options); Mailbox mailbox = session.open("Tool(0/40)", 4, 70000)) {
      messages(session, mailbox);
      full(mailbox);
      // Over TCP it is a program of the original for the router, which takes away what those do not know.
      proxies(session, arguments[0].startsWith("ws") ? "radius" : "see its log texts");
      System.out.println("ready");
      check(events.take().contains("connecting again"), "the loss is reported");
      System.out.println("lost");
      session.awaitConnected(PATIENCE);
      again(mailbox);
      System.out.println("again");
    }
  }

  private static void check(boolean holds, String what) {
    if (!holds) throw new AssertionError("not so: " + what);
  }

  private interface Action {
    void run() throws Exception;
  }

  private static void fails(TimsException.Code code, String part, Action action) throws Exception {
    try {
      action.run();
    } catch (TimsException error) {
      check(error.code() == code && error.getMessage().contains(part), error.code() + " " + error.getMessage());
      return;
    }
    throw new AssertionError("did not fail: " + code);
  }

  private static void messages(Session session, Mailbox mailbox) throws Exception {
    mailbox.send(new Header(mailbox.address(), 0, 21, 7, 200, 0), new byte[] {1, 2, 3, 4});
    Message message = mailbox.receive(PATIENCE);
    check(message.src() == mailbox.address() && message.type() == 21, "a message to itself");
    check(message.header().priority() == 7 && message.header().seqNr() == 200, "priority and number are kept");
    check(message.body().getInt() == 0x01020304, "the body is in big endian");
    mailbox.send(Address.parse("Ladar(0/77)"), Type.GET_STATUS);
    check(mailbox.receive(PATIENCE).type() == Type.NOT_AVAILABLE, "nobody is there");
    fails(TimsException.Code.TIMEOUT, "no message", () -> mailbox.receive(Duration.ofMillis(10)));
    fails(TimsException.Code.ADDRESS_IN_USE, "another program", () -> session.open("Tool(0/40)", 4, 100));
    fails(TimsException.Code.ADDRESS_IN_USE, "Ladar(0/3)", () -> session.open("Ladar(0/3)", 4, 100));
    fails(TimsException.Code.TOO_BIG, "message.max", () -> mailbox.send(mailbox.address(), 1, new byte[300000]));
    fails(TimsException.Code.INVALID, "is no router", () -> Session.connect("a b:x"));
    byte[] large = new byte[65536];
    large[65535] = 9;
    mailbox.send(mailbox.address(), 21, large);
    check(mailbox.receive(PATIENCE).body().get(65535) == 9, "a large body");
  }

  /** It holds 4: the oldest of the lowest priority gives way, if the new one is not less important. */
  private static void full(Mailbox mailbox) throws Exception {
    int[] priorities = {5, 1, 1, 9, 1, 0, 20};
    for (int i = 0; i < priorities.length; ++i)
      mailbox.send(new Header(mailbox.address(), 0, 1, priorities[i], i, 0), new byte[0]);
    mailbox.send(new Header(mailbox.address(), 0, 1, 255, 100, 0), new byte[0]);
    while (mailbox.counters().replaced() + mailbox.counters().refused() < 4) Thread.onSpinWait();
    StringBuilder order = new StringBuilder();
    for (int i = 0; i < 4; ++i) order.append(mailbox.receive(PATIENCE).header().seqNr()).append(' ');
    check(order.toString().equals("100 6 3 0 "), "the order is " + order);
    check(mailbox.counters().refused() == 1 && mailbox.counters().replaced() == 3, mailbox.counters().toString());
    check(mailbox.clean() == 0, "it is empty");
  }

  private static void proxies(Session session, String reason) throws Exception {
    try (Mailbox work = session.open("Tool(0/41)", 4, 70000); Mailbox data = session.open("Tool(0/41):1", 4, 70000)) {
      LadarProxy ladar = new LadarProxy(work, "Ladar(0/3)");
      ladar.setOnTimeout(PATIENCE);
      ladar.setReplyTimeout(PATIENCE);
      check(ladar.status() == Type.DISABLED, "it is off");
      fails(TimsException.Code.ANSWERED_ERROR, "Ladar(0/3), GET_DATA", ladar::getData);
      ladar.on();
      LadarData scan = ladar.getData();
      check(scan.points.size() == 181 && scan.points.get(90).distance == 3000, "a scan");
      check(ladar.getData(scan.recordingTime).recordingTime == scan.recordingTime, "the scan of that time");
      check(ladar.subscribe(data, 50) == 50, "every fifth scan");
      long first = ladar.decodeStream(data.receive(PATIENCE)).get().recordingTime;
      check(ladar.decodeStream(data.receive(PATIENCE)).get().recordingTime - first >= 40, "the pace of its stream");
      ladar.setParameter("radius", 500);
      check(ladar.getParameters().get("radius").equals(500), "a parameter");
      fails(TimsException.Code.ANSWERED_ERROR, "Ladar(0/3), SET_PARAM: " + reason, () -> ladar.setParameter("radius", 5));
      while (ladar.getNextData(PATIENCE).points.get(0).distance != 500) Thread.onSpinWait();
      ladar.off();
      for (;;) {
        Message message = data.receive(PATIENCE);
        if (message.type() != Type.ERROR) continue;
        fails(TimsException.Code.ANSWERED_ERROR, "ended its stream", () -> ladar.decodeStream(message));
        break;
      }
    }
    try (Mailbox work = session.open("Tool(0/41)", 4, 70000)) {
      fails(TimsException.Code.NO_MAILBOX, "Ladar(0/9), ON: is it running", () -> new LadarProxy(work, "Ladar(0/9)").on());
    }
  }

  private static void again(Mailbox mailbox) throws Exception {
    for (;;) { // until the new router knows the address
      try {
        mailbox.send(mailbox.address(), 22);
        if (mailbox.receive(Duration.ofMillis(200)).type() == 22) return;
      } catch (TimsException error) {
        check(error.code() == TimsException.Code.TIMEOUT || error.code() == TimsException.Code.NO_ROUTER, error.getMessage());
      }
    }
  }
}
