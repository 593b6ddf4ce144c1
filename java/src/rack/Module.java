package rack;

import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.OptionalInt;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.ThreadLocalRandom;
import java.util.concurrent.TimeUnit;
import rack.messages.DescriptionRequest;
import rack.messages.ParameterList;
import tims.Address;
import tims.Flag;
import tims.Header;
import tims.Mailbox;
import tims.Message;
import tims.Session;
import tims.TimsException;
import tims.Type;

/**
 * A component: it is turned on and off, has parameters and log texts, and answers commands, as one in C++. Its methods are
 * called by two threads, moduleOn, moduleLoop and moduleOff by the data task, moduleCommand by the command task: what both
 * use is protected by a lock. A method that throws in the data task turns the component off, and it is tried again after
 * some seconds; one that throws in the command task refuses the command with the text of the exception.
 */
public abstract class Module {
  /** Of log texts, as of the parameter gdosLevel. */
  public enum Level {
    PRINT,
    ERROR,
    WARNING,
    INFO,
    DETAIL
  }

  private static final int LOG = Address.of(0, 1, 0, 0);
  private static final int LOG_MAX = 256; // bytes
  private static final int REASON_MAX = 240;
  private static final Duration SHORT = Duration.ofMillis(500);

  private final String program;
  private final int classId;
  private final Parameters parameters;
  private Description description;
  private final LifeCycle lifeCycle = new LifeCycle();
  private final Object lock = new Object(); // of lifeCycle
  private String router = "localhost";
  private Session session;
  private Mailbox commands;
  private final CountDownLatch ended = new CountDownLatch(1);
  private volatile boolean stops;

  /**
   * @param program its name, as "Sweeper"
   * @param classId as LadarProxy.CLASS_ID
   * @param rows its own parameters
   */
  protected Module(String program, int classId, Parameters.Row... rows) {
    this.program = program;
    this.classId = classId;
    List<Parameters.Row> all = new ArrayList<>(List.of(
        Parameters.integer("system", 0, "number of the robot", 0, 255),
        Parameters.integer("instance", 0, "number of the component", 0, 255),
        Parameters.integer("gdosLevel", 2, "log texts: 0 print, 1 error, 2 warning, 3 info, 4 detail", 0, 4),
        Parameters.integer("targetStatus", 0, "1: on at the start", 0, 1),
        Parameters.integer("errorTimeout", -1, "delay after an error, -1: 2 to 4 s [ms]", -1, Integer.MAX_VALUE)));
    all.addAll(List.of(rows));
    parameters = new Parameters(all.toArray(new Parameters.Row[0]));
  }

  // --- what a component is

  /** One sentence, for people who look for a component. */
  protected String purpose() {
    return "";
  }

  /** Once at the start, and at the end. */
  protected void moduleInit() throws Exception {}

  protected void moduleCleanup() {}

  protected void moduleOn() throws Exception {}

  /** Called again and again while it is on: it sleeps or waits by itself. */
  protected abstract void moduleLoop() throws Exception;

  /** Also after an error, to clean up. */
  protected void moduleOff() {}

  /** Commands of its class: answers by reply(), or throws. */
  protected void moduleCommand(Message command) throws Exception {
    throw new Refused("unknown command " + command.type());
  }

  // --- for its methods

  protected final int integer(String name) {
    return (Integer) parameters.get(name);
  }

  protected final float real(String name) {
    return (Float) parameters.get(name);
  }

  protected final String text(String name) {
    return (String) parameters.get(name);
  }

  /** Of its command mailbox. */
  protected final int address() {
    return commands.address();
  }

  /** Another mailbox of the component; local ids are 1 to 255. */
  protected final Mailbox openMailbox(int local, int slots, int bodyMax) throws TimsException, InterruptedException {
    return session.open(address() | local, slots, bodyMax);
  }

  protected final boolean isOn() {
    synchronized (lock) {
      return lifeCycle.isOn();
    }
  }

  /** It was not turned off and is not stopping: for a moduleOn that waits. */
  protected final boolean isWanted() {
    synchronized (lock) {
      return lifeCycle.wantsOn() && !stops;
    }
  }

  protected final void reply(Message command, int type, Struct body) throws TimsException {
    commands.reply(command.header(), type, body == null ? new byte[0] : body.encode());
  }

  protected final void reply(Message command, int type) throws TimsException {
    reply(command, type, null);
  }

  protected final void log(Level level, String text) {
    if (level.ordinal() > integer("gdosLevel")) return;
    byte[] raw = text.replace("%", "%%").getBytes(StandardCharsets.UTF_8);
    send(new Header(LOG, 0, -124 - level.ordinal(), 0, 0, 0), java.util.Arrays.copyOf(raw, Math.min(raw.length, LOG_MAX)));
  }

  /** From any thread. */
  public final void stop() {
    stops = true;
    synchronized (lock) {
      lock.notifyAll();
    }
  }

  // --- for DataModule

  /** A message whose receiver may be gone, or its router: that is noticed by who asks. */
  final void send(Header header, byte[] body) {
    try {
      commands.send(header, body);
    } catch (TimsException error) {
      if (error.code() == TimsException.Code.TOO_BIG) throw new IllegalArgumentException(error.getMessage(), error);
    }
  }

  final boolean stops() {
    return stops;
  }

  /** After moduleOn; the component is on when it returns. */
  void begin() throws Exception {}

  /** It is not on any more. */
  void end() {}

  boolean hasData() {
    return false;
  }

  /** False: it is no request of data. */
  boolean dataCommand(Message command) throws Exception {
    return false;
  }

  // --- the program

  /** Runs until SIGTERM, SIGINT or stop(); returns the exit status: 0, 1 when it failed, 2 on wrong usage. */
  public final int run(String... arguments) {
    try {
      if (!parse(arguments)) return 0;
    } catch (IllegalArgumentException error) {
      System.err.println(program + ": " + error.getMessage());
      return 2;
    }
    Runtime.getRuntime().addShutdownHook(new Thread(this::stopAndWait, program + "E"));
    try (Session opened = Session.connect(router)) {
      session = opened;
      commands = opened.open(Address.of(integer("system"), classId, integer("instance"), 0), 16, 8192);
      tasks();
      return 0;
    } catch (Exception error) {
      System.err.println(program + ": " + error.getMessage());
      return 1;
    } finally {
      ended.countDown();
    }
  }

  /** At a signal: the runtime of Java ends when this does. */
  private void stopAndWait() {
    stop();
    try {
      ended.await(SHORT.toMillis() * 4, TimeUnit.MILLISECONDS); // moduleOff and the last log text
    } catch (InterruptedException error) {
      // The program ends in any case.
    }
  }

  /** "--name value" or "--name=value"; false: help was printed. */
  private boolean parse(String... arguments) {
    for (int i = 0; i < arguments.length; ++i) {
      String[] parts = arguments[i].split("=", 2);
      String name = parts[0].replaceFirst("^--?", "");
      if (name.equals("help")) {
        System.out.println("usage: " + program + " [--router HOST:PORT|ws://HOST:PORT] [--NAME VALUE ...]\n" + parameters.help());
        return false;
      }
      if (name.equals(parts[0])) throw new IllegalArgumentException(arguments[i] + " is no option: --help lists them");
      if (parts.length < 2 && i + 1 == arguments.length) throw new IllegalArgumentException(name + " has no value");
      String value = parts.length == 2 ? parts[1] : arguments[++i];
      if (name.equals("router")) router = value;
      else parameters.parse(name, value);
    }
    return true;
  }

  private void tasks() throws Exception {
    description = new Description(program, purpose(), classId, parameters.rows(), hasData());
    Thread commandTask = new Thread(this::commandTask, program + "C");
    log(Level.PRINT, "Init");
    moduleInit();
    if (integer("targetStatus") == 1) lifeCycle.turnOn();
    commandTask.start();
    try {
      while (!stops) step();
    } finally { // also if this thread was interrupted
      stop();
      if (isOn()) turnOff();
      commandTask.join();
      moduleCleanup();
      log(Level.PRINT, "Terminated");
    }
  }

  private void step() throws InterruptedException {
    LifeCycle.Step step;
    synchronized (lock) {
      step = lifeCycle.next(System.nanoTime());
      if (step == LifeCycle.Step.WAIT) {
        lock.wait(100);
        return;
      }
    }
    if (step == LifeCycle.Step.TURN_OFF) turnOff();
    else if (step == LifeCycle.Step.TURN_ON) turnOn();
    else loop();
  }

  private void turnOn() {
    try {
      moduleOn();
      begin();
    } catch (Exception error) {
      log(Level.PRINT, "Error, can't turn on module");
      fail(error);
      return;
    }
    log(Level.PRINT, "Module on");
    succeed(LifeCycle.Step.TURN_ON);
  }

  private void loop() {
    try {
      moduleLoop();
    } catch (Exception error) {
      if (stops) return; // it was interrupted by the end
      log(Level.PRINT, "Error");
      fail(error);
      return;
    }
    succeed(LifeCycle.Step.LOOP);
  }

  private void turnOff() {
    end();
    moduleOff();
    log(Level.PRINT, "Module off");
    succeed(LifeCycle.Step.TURN_OFF);
  }

  private void succeed(LifeCycle.Step step) {
    List<Header> waiting;
    synchronized (lock) {
      waiting = lifeCycle.succeeded(step);
    }
    for (Header each : waiting) send(answer(each, Type.OK), new byte[0]);
  }

  private void fail(Exception error) {
    String reason = reason(error);
    end();
    moduleOff();
    log(Level.ERROR, reason);
    int delay = integer("errorTimeout");
    long after = (delay >= 0 ? Math.max(delay, 10) : ThreadLocalRandom.current().nextInt(2000, 4000)) * 1_000_000L;
    List<Header> waiting;
    synchronized (lock) {
      waiting = lifeCycle.failed(System.nanoTime(), after);
    }
    for (Header each : waiting) refuse(each, reason);
  }

  private static String reason(Exception error) {
    return error.getMessage() == null ? error.getClass().getSimpleName() : error.getMessage();
  }

  // --- commands

  private void commandTask() {
    while (!stops) {
      try {
        Message command = commands.receive(SHORT);
        if (command.type() > 0) dispatch(command);
      } catch (TimsException error) {
        if (error.code() != TimsException.Code.TIMEOUT) return; // the session is closed
      } catch (InterruptedException error) {
        return;
      }
    }
  }

  private void dispatch(Message command) {
    try {
      if (!genericCommand(command) && !dataCommand(command)) moduleCommand(command);
    } catch (Exception error) {
      refuse(command.header(), reason(error));
    }
  }

  private boolean genericCommand(Message command) throws Exception {
    switch (command.type()) {
      case Type.ON -> on(command);
      case Type.OFF -> off(command);
      case Type.GET_STATUS -> reply(command, status());
      case Type.GET_PARAM -> reply(command, Type.PARAM, parameters.list(program));
      case Type.GET_DESCRIPTION -> reply(command, Type.DESCRIPTION, description.page(DescriptionRequest.decode(command)));
      case Type.SET_PARAM -> {
        parameters.set(ParameterList.decode(command));
        reply(command, Type.OK);
      }
      default -> {
        return false;
      }
    }
    return true;
  }

  private int status() {
    synchronized (lock) {
      return lifeCycle.status();
    }
  }

  private void on(Message command) throws TimsException {
    // Who waits for a reason says so in the body, too: the flag does not reach a component that is connected by TCP.
    int wants = command.bodySize() >= 4 ? Flag.REPORT_REASON : 0;
    Header request = command.header().withFlags(command.header().flags() | wants);
    OptionalInt answer;
    synchronized (lock) {
      answer = lifeCycle.turnOn(System.nanoTime(), request);
      lock.notifyAll();
    }
    if (answer.isPresent()) reply(command, answer.getAsInt());
  }

  private void off(Message command) throws TimsException {
    List<Header> waiting;
    synchronized (lock) {
      waiting = lifeCycle.turnOff();
      lock.notifyAll();
    }
    reply(command, Type.OK);
    for (Header each : waiting) refuse(each, "it was turned off");
  }

  private void refuse(Header request, String reason) {
    byte[] raw = reason.getBytes(StandardCharsets.UTF_8);
    boolean wanted = (request.flags() & Flag.REPORT_REASON) != 0;
    send(answer(request, Type.ERROR), wanted ? java.util.Arrays.copyOf(raw, Math.min(raw.length, REASON_MAX)) : new byte[0]);
  }

  private static Header answer(Header request, int type) {
    return new Header(request.src(), 0, type, request.priority(), request.seqNr(), 0);
  }
}
