package tims;

import java.io.IOException;
import java.net.InetSocketAddress;
import java.net.URI;
import java.time.Duration;
import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.function.Consumer;
import javax.net.ssl.SSLContext;

/**
 * A connection to a router, over TCP or a WebSocket; one that is lost is made again, and its mailboxes are registered
 * again. Any thread may use it.
 *
 * <pre>{@code
 * try (Session session = Session.connect("192.168.1.2"); Mailbox mailbox = session.open("Tool(0/7)", 16, 65536)) {
 *   mailbox.send(Address.parse("Ladar(0/0)"), Type.GET_STATUS);
 *   Message answer = mailbox.receive(Duration.ofSeconds(1));
 * }
 * }</pre>
 */
public final class Session implements AutoCloseable {
  public static final int TCP_PORT = 2000;
  private static final int INIT = 13; // commands to the router, with dest = src = 0
  private static final int DELETE = 12;
  private static final int LIFESIGN = 17;
  private static final Duration ANSWER_TIME = Duration.ofSeconds(2);
  private static final long PAUSE_MIN = 200; // ms between two attempts
  private static final long PAUSE_MAX = 1500;

  /** How to connect. Each method returns the options that it changed. */
  public static final class Options {
    private final String router;
    private Duration timeout = Duration.ofSeconds(10);
    private Duration silence = Duration.ofSeconds(15);
    private int messageMax = 262144;
    private SSLContext tls;
    private String bearer;
    private Consumer<String> events = text -> System.err.println("tims: " + text);

    /**
     * @param router "HOST", "HOST:PORT", "[IPv6]:PORT" (TCP, port 2000), or "ws://HOST:PORT" and "wss://HOST:PORT" (the
     *     router's HTTP port)
     */
    public Options(String router) {
      this.router = router;
    }

    /** How long {@link Session#connect} waits for the router; default 10 s. */
    public Options timeout(Duration value) {
      timeout = value;
      return this;
    }

    /** A router that sends nothing for so long is lost: three times its lifesign.interval; default 15 s. */
    public Options silence(Duration value) {
      silence = value;
      return this;
    }

    /** message.max of the router, in bytes with the header; default 262144. */
    public Options messageMax(int value) {
      messageMax = value;
      return this;
    }

    /** For wss: whose certificates are trusted; default: those of the Java runtime. */
    public Options tls(SSLContext value) {
      tls = value;
      return this;
    }

    /** For wss: what `timsctl web --bearer` prints. */
    public Options bearer(String value) {
      bearer = value;
      return this;
    }

    /** Gets a line of text when the connection is lost or made again; default: to stderr. */
    public Options events(Consumer<String> value) {
      events = value;
      return this;
    }
  }

  private final Options options;
  private final Map<Integer, Mailbox> mailboxes = new LinkedHashMap<>();
  private final Map<Integer, Message> answers = new HashMap<>(); // of the router, by sequence number; null: awaited
  private final Thread keeper = new Thread(this::keep, "tims-session");
  private Connection connection; // null: there is none
  private long heardAt;
  private String lost = "";
  private int seqNr;
  private boolean closed;

  /** @throws TimsException NO_ROUTER: none answered in 10 s */
  public static Session connect(String router) throws TimsException, InterruptedException {
    return connect(new Options(router));
  }

  /** @throws TimsException NO_ROUTER: none answered in the time of the options */
  public static Session connect(Options options) throws TimsException, InterruptedException {
    Session session = new Session(options);
    session.newConnection(); // an address that is not valid is reported here
    session.keeper.setDaemon(true);
    session.keeper.start();
    try {
      session.awaitConnected(options.timeout);
    } catch (TimsException | InterruptedException error) {
      session.close();
      throw error;
    }
    return session;
  }

  private Session(Options options) {
    this.options = options;
  }

  public synchronized boolean isConnected() {
    return connection != null;
  }

  /** Waits for a router. @throws TimsException NO_ROUTER, CLOSED */
  public synchronized void awaitConnected(Duration timeout) throws TimsException, InterruptedException {
    long end = System.nanoTime() + timeout.toNanos();
    while (connection == null) {
      if (closed) throw closedError();
      long left = (end - System.nanoTime() + 999_999) / 1_000_000;
      if (left <= 0) throw noRouter();
      wait(left);
    }
  }

  /**
   * Registers an address.
   *
   * @param slots messages that it can hold, 1 to 65535
   * @param bodyMax bytes of the largest body
   * @throws TimsException ADDRESS_IN_USE, NO_ROUTER, CLOSED
   */
  public Mailbox open(int address, int slots, int bodyMax) throws TimsException, InterruptedException {
    Mailbox mailbox = new Mailbox(this, address, slots, bodyMax);
    synchronized (this) {
      if (closed) throw closedError();
      if (mailboxes.putIfAbsent(address, mailbox) != null) throw inUse(address);
    }
    int answer;
    try {
      answer = register(address);
    } catch (TimsException | InterruptedException error) {
      closed(mailbox); // the router may still register it
      throw error;
    }
    if (answer == Type.OK) return mailbox;
    synchronized (this) {
      mailboxes.remove(address, mailbox);
    }
    throw inUse(address);
  }

  /** The same with an address as "Tool(0/7)". */
  public Mailbox open(String address, int slots, int bodyMax) throws TimsException, InterruptedException {
    return open(Address.parse(address), slots, bodyMax);
  }

  /** Closes its mailboxes, too. */
  @Override
  public void close() {
    Connection ending;
    Mailbox[] ours;
    synchronized (this) {
      if (closed) return;
      ours = mailboxes.values().toArray(new Mailbox[0]);
    }
    for (Mailbox each : ours) each.close();
    synchronized (this) {
      closed = true;
      ending = connection;
      connection = null;
      notifyAll();
    }
    keeper.interrupt();
    if (ending != null) ending.close();
  }

  // --- for mailboxes

  void send(Header header, byte[] body) throws TimsException {
    if (body.length > options.messageMax - Header.SIZE)
      throw new TimsException(TimsException.Code.TOO_BIG, "a body of " + body.length + " bytes to "
          + Address.format(header.dest()) + ", the router accepts " + (options.messageMax - Header.SIZE)
          + ": send less, or raise message.max of the router and of the session");
    Connection now;
    synchronized (this) {
      if (closed) throw closedError();
      if (connection == null) throw noRouter();
      now = connection;
    }
    try {
      now.send(header.message(body));
    } catch (IOException error) {
      now.close();
      throw new TimsException(TimsException.Code.NO_ROUTER, "the connection to " + options.router + " ended: " + error.getMessage());
    }
  }

  void closed(Mailbox mailbox) {
    synchronized (this) {
      mailboxes.remove(mailbox.address(), mailbox);
    }
    try {
      send(Header.to(0, DELETE), word(mailbox.address()));
    } catch (TimsException error) {
      // The router forgets it with the connection.
    }
  }

  // --- the router

  /** The type of its answer. */
  private int register(int address) throws TimsException, InterruptedException {
    int number;
    synchronized (this) {
      do {
        seqNr = seqNr % 255 + 1;
      } while (answers.containsKey(seqNr));
      number = seqNr;
      answers.put(number, null);
    }
    try {
      send(Header.to(0, INIT).withSeqNr(number), word(address));
      return answer(number).type();
    } finally {
      synchronized (this) {
        answers.remove(number);
      }
    }
  }

  private synchronized Message answer(int number) throws TimsException, InterruptedException {
    long end = System.nanoTime() + ANSWER_TIME.toNanos();
    while (answers.get(number) == null) {
      long left = (end - System.nanoTime() + 999_999) / 1_000_000;
      if (left <= 0 || closed || connection == null) throw noRouter();
      wait(left);
    }
    return answers.get(number);
  }

  private void received(Connection from, byte[] bytes) {
    Message message = Message.of(bytes);
    Header header = message.header();
    Mailbox mailbox;
    synchronized (this) {
      heardAt = System.nanoTime();
      if (header.dest() == 0 && header.src() == 0) {
        if (header.type() != LIFESIGN && answers.containsKey(header.seqNr())) {
          answers.put(header.seqNr(), message);
          notifyAll();
        }
      }
      mailbox = mailboxes.get(header.dest());
    }
    if (header.type() == LIFESIGN && header.dest() == 0) answerLifesign(from, header);
    else if (mailbox != null) mailbox.deliver(message);
  }

  private static void answerLifesign(Connection from, Header header) {
    try {
      from.send(new Header(0, 0, Type.OK, header.priority(), header.seqNr(), 0).message(new byte[0]));
    } catch (IOException error) {
      from.close(); // its reader reports it
    }
  }

  // --- the thread that keeps the connection

  private void keep() {
    long pause = PAUSE_MIN;
    try {
      for (;;) {
        String why = "";
        if (connectOnce()) {
          pause = PAUSE_MIN;
          why = watch();
        }
        synchronized (this) {
          if (closed) return;
        }
        if (!why.isEmpty()) options.events.accept("lost " + options.router + ": " + why + "; connecting again");
        Thread.sleep(pause); // close() interrupts it
        pause = Math.min(2 * pause, PAUSE_MAX);
      }
    } catch (InterruptedException error) {
      // The session is closed.
    }
  }

  private boolean connectOnce() throws InterruptedException {
    Connection attempt;
    Reports reports;
    try {
      attempt = newConnection();
      reports = new Reports(attempt);
      attempt.open(reports);
    } catch (IOException error) {
      synchronized (this) {
        lost = error.getMessage() == null ? error.getClass().getSimpleName() : error.getMessage();
      }
      return false;
    }
    Integer[] ours;
    synchronized (this) {
      if (closed) {
        attempt.close();
        return false;
      }
      if (reports.end != null) { // the router has closed it already
        lost = reports.end;
        return false;
      }
      connection = attempt;
      heardAt = System.nanoTime();
      ours = mailboxes.keySet().toArray(new Integer[0]);
      notifyAll();
    }
    for (int address : ours) registerAgain(address);
    return true;
  }

  /** Another program may have taken the address meanwhile: then it is tried with the next connection again. */
  private void registerAgain(int address) throws InterruptedException {
    try {
      if (register(address) != Type.OK)
        options.events.accept(Address.format(address) + " is owned by another program now: messages to it are lost");
    } catch (TimsException error) {
      // This connection has ended, too.
    }
  }

  /** Returns when the connection has ended, and why. */
  private synchronized String watch() throws InterruptedException {
    while (connection != null && !closed) {
      long left = (heardAt + options.silence.toNanos() - System.nanoTime() + 999_999) / 1_000_000;
      if (left > 0) {
        wait(left);
      } else {
        lost = "it is silent for " + options.silence.toMillis() + " ms";
        connection.close();
        connection = null;
        notifyAll();
      }
    }
    return lost;
  }

  private Connection newConnection() throws TimsException {
    try {
      if (options.router.startsWith("ws://") || options.router.startsWith("wss://"))
        return new WebSocketConnection(URI.create(options.router).resolve("/tims"), options.messageMax, options.tls, options.bearer);
      URI parts = URI.create("tims://" + options.router);
      if (parts.getHost() == null || !parts.getPath().isEmpty()) throw new IllegalArgumentException("no host");
      int port = parts.getPort() < 0 ? TCP_PORT : parts.getPort();
      return new TcpConnection(InetSocketAddress.createUnresolved(parts.getHost(), port), options.messageMax);
    } catch (IllegalArgumentException error) {
      throw new TimsException(TimsException.Code.INVALID,
          '"' + options.router + "\" is no router: expected HOST, HOST:PORT, ws://HOST:PORT or wss://HOST:PORT");
    }
  }

  private final class Reports implements Connection.Listener {
    private final Connection from;
    private String end; // null: it has not ended; guarded by the session

    Reports(Connection from) {
      this.from = from;
    }

    @Override
    public void received(byte[] message) {
      Session.this.received(from, message);
    }

    @Override
    public void alive() {
      synchronized (Session.this) {
        heardAt = System.nanoTime();
      }
    }

    @Override
    public void ended(String why) {
      synchronized (Session.this) {
        end = why == null ? "it ended" : why;
        if (connection != from) return;
        lost = end;
        connection = null;
        Session.this.notifyAll();
      }
    }
  }

  private static byte[] word(int value) {
    return new byte[] {(byte) (value >>> 24), (byte) (value >>> 16), (byte) (value >>> 8), (byte) value};
  }

  private TimsException inUse(int address) {
    return new TimsException(TimsException.Code.ADDRESS_IN_USE,
        Address.format(address) + " is owned by another program: use another instance or local id");
  }

  private TimsException noRouter() {
    return new TimsException(TimsException.Code.NO_ROUTER,
        "no router at " + options.router + (lost.isEmpty() ? "" : " (" + lost + ")") + ": is tims-router running there?");
  }

  private static TimsException closedError() {
    return new TimsException(TimsException.Code.CLOSED, "the session is closed: connect again");
  }
}
