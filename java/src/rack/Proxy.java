package rack;

import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.time.Duration;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.function.Supplier;
import rack.messages.Parameter;
import rack.messages.ParameterList;
import tims.Address;
import tims.Flag;
import tims.Header;
import tims.Mailbox;
import tims.Message;
import tims.TimsException;
import tims.TimsException.Code;
import tims.Type;

/**
 * Calls of a component: a command is sent, and its answer waited for.
 *
 * <p>Every call throws TimsException with component and command in its text: ANSWERED_ERROR (the component refused, with
 * its reason), TIMEOUT, NO_MAILBOX (no such component), MALFORMED, and what sending throws. One call at a time uses a work
 * mailbox; other messages that arrive there meanwhile are discarded. It must accept the largest answer.
 */
public class Proxy {
  private static final int REASON_MAX = 240; // bytes

  private final Mailbox work;
  private final int component;
  private final Map<Integer, String> commands;
  private Duration onTime = Duration.ofSeconds(5);
  private Duration replyTime = Duration.ofSeconds(2);
  private int priority;
  private int seqNr;

  /** @param commands names of the commands of its class, for errors */
  protected Proxy(Mailbox work, int component, Map<Integer, String> commands) {
    this.work = work;
    this.component = component;
    this.commands = commands;
  }

  public final Mailbox work() {
    return work;
  }

  public final int component() {
    return component;
  }

  /** For ON; default 5 s. */
  public final void setOnTimeout(Duration value) {
    onTime = value;
  }

  /** For all other calls; default 2 s. */
  public final void setReplyTimeout(Duration value) {
    replyTime = value;
  }

  /** Of its commands, 0 to 255; default 0. */
  public final void setPriority(int value) {
    priority = value;
  }

  /** Returns when the component is on; one with data then has its first. */
  public final void on() throws TimsException, InterruptedException {
    ask(Type.ON, word(REASON_MAX), onTime, Type.OK);
  }

  public final void off() throws TimsException, InterruptedException {
    ask(Type.OFF, new byte[0], replyTime, Type.OK);
  }

  /** {@link Type#ENABLED} (on), {@link Type#DISABLED} (off) or {@link Type#ERROR}. */
  public final int status() throws TimsException, InterruptedException {
    return ask(Type.GET_STATUS, new byte[0], replyTime, Type.ENABLED, Type.DISABLED, Type.ERROR).type();
  }

  /** All parameters: Integer, Float or String by their names. */
  public final Map<String, Object> getParameters() throws TimsException, InterruptedException {
    Map<String, Object> values = new LinkedHashMap<>();
    for (Parameter each : query(Type.GET_PARAM, null, ParameterList::new, Type.PARAM).parameters)
      values.put(each.name, each.type == 1 ? each.valueString : each.type == 2 ? (Object) each.valueFloat : each.valueInt);
    return values;
  }

  /** ANSWERED_ERROR: there is no such parameter, or the value is out of range or of another type. */
  public final void setParameter(String name, Object value) throws TimsException, InterruptedException {
    Parameter one = new Parameter();
    one.name = name;
    one.type = value instanceof String ? 1 : value instanceof Integer ? 0 : 2;
    if (value instanceof String text) one.valueString = text;
    else if (value instanceof Integer number) one.valueInt = number;
    else one.valueFloat = ((Number) value).floatValue();
    ParameterList list = new ParameterList();
    list.parameters.add(one);
    command(Type.SET_PARAM, list);
  }

  // --- for commands of a class

  /** A command that is answered by OK. */
  protected final void command(int type, Struct body) throws TimsException, InterruptedException {
    ask(type, body == null ? new byte[0] : body.encode(), replyTime, Type.OK);
  }

  /** A request that is answered by a message of one of these types, which has this body. */
  protected final <T extends Struct> T query(int type, Struct body, Supplier<T> answer, int... answers)
      throws TimsException, InterruptedException {
    Message message = ask(type, body == null ? new byte[0] : body.encode(), replyTime, answers);
    return decoded(type, answer.get(), message);
  }

  final <T extends Struct> T decoded(int type, T into, Message message) throws TimsException {
    try {
      return Struct.decode(into, message);
    } catch (CodecException error) {
      throw new TimsException(Code.MALFORMED, name(type) + ": " + error.getMessage());
    }
  }

  final Message ask(int type, byte[] body, Duration timeout, int... answers) throws TimsException, InterruptedException {
    long end = System.nanoTime() + timeout.toNanos();
    seqNr = seqNr % 255 + 1;
    int flags = work.bodyMax() >= REASON_MAX ? Flag.REPORT_REASON : 0;
    try {
      work.send(new Header(component, 0, type, priority, seqNr, flags), body);
      for (;;) {
        Message message = work.receive(Duration.ofNanos(Math.max(end - System.nanoTime(), 0)));
        if (message.src() != component || message.header().seqNr() != seqNr) continue;
        for (int each : answers) if (message.type() == each) return message;
        refuse(message);
      }
    } catch (TimsException error) {
      String text = error.code() == Code.TIMEOUT ? "no answer in " + timeout.toMillis() + " ms" : error.getMessage();
      throw new TimsException(error.code(), name(type) + ": " + text);
    }
  }

  /** Throws what the answer states; returns if it is none. */
  private static void refuse(Message message) throws TimsException {
    switch (message.type()) {
      case Type.NOT_AVAILABLE:
        throw new TimsException(Code.NO_MAILBOX, "is it running, and is there a route to it?");
      case Type.TIMEOUT:
        throw new TimsException(Code.ANSWERED_ERROR, "it waited for another component, which did not answer");
      case Type.ERROR:
        throw new TimsException(Code.ANSWERED_ERROR, reason(message.body()));
      default:
    }
  }

  private static String reason(ByteBuffer body) {
    byte[] raw = new byte[Math.min(body.remaining(), REASON_MAX)];
    body.get(raw);
    String text = new String(raw, StandardCharsets.UTF_8).split("\0", 2)[0];
    return text.isEmpty() ? "see its log texts for the reason" : text;
  }

  private String name(int type) {
    String known = switch (type) {
      case Type.ON -> "ON";
      case Type.OFF -> "OFF";
      case Type.GET_STATUS -> "GET_STATUS";
      case Type.GET_DATA -> "GET_DATA";
      case Type.GET_CONT_DATA -> "GET_CONT_DATA";
      case Type.STOP_CONT_DATA -> "STOP_CONT_DATA";
      case Type.GET_NEXT_DATA -> "GET_NEXT_DATA";
      case Type.GET_PARAM -> "GET_PARAM";
      case Type.SET_PARAM -> "SET_PARAM";
      default -> commands.getOrDefault(type, "type " + type);
    };
    return Address.format(component) + ", " + known;
  }

  static byte[] word(int... values) {
    ByteBuffer out = ByteBuffer.allocate(4 * values.length);
    for (int value : values) out.putInt(value);
    return out.array();
  }
}
