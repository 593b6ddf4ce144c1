package rack;

import java.time.Duration;
import java.util.Map;
import java.util.Optional;
import java.util.function.Supplier;
import tims.Address;
import tims.Mailbox;
import tims.Message;
import tims.TimsException;
import tims.TimsException.Code;
import tims.Type;

/** A component that publishes data, on request or as a stream. */
public class DataProxy<D extends Struct> extends Proxy {
  private final Supplier<D> made;

  protected DataProxy(Mailbox work, int component, Map<Integer, String> commands, Supplier<D> made) {
    super(work, component, commands);
    this.made = made;
  }

  /** The newest data. */
  public final D getData() throws TimsException, InterruptedException {
    return getData(0);
  }

  /** The data recorded nearest to that time [ms]; 0: the newest. */
  public final D getData(long recordingTime) throws TimsException, InterruptedException {
    Message message = ask(Type.GET_DATA, word((int) recordingTime), Duration.ofSeconds(2), Type.DATA);
    return decoded(Type.GET_DATA, made.get(), message);
  }

  /** The next data that are produced: the timeout should be longer than the component's period. */
  public final D getNextData(Duration timeout) throws TimsException, InterruptedException {
    return decoded(Type.GET_NEXT_DATA, made.get(), ask(Type.GET_NEXT_DATA, new byte[0], timeout, Type.DATA));
  }

  /** Its data go to this mailbox from now on; returns the granted period [ms]. 0: as fast as possible. */
  public final int subscribe(Mailbox mailbox, int period) throws TimsException, InterruptedException {
    Message message = ask(Type.GET_CONT_DATA, word(period, mailbox.address()), Duration.ofSeconds(2), Type.CONT_DATA);
    if (message.bodySize() < 4)
      throw new TimsException(Code.MALFORMED, Address.format(component()) + ": CONT_DATA has " + message.bodySize() + " bytes, not 4");
    return message.body().getInt();
  }

  public final void unsubscribe(Mailbox mailbox) throws TimsException, InterruptedException {
    ask(Type.STOP_CONT_DATA, word(mailbox.address()), Duration.ofSeconds(2), Type.OK);
  }

  /**
   * The data of a stream; empty: it is another message.
   *
   * @throws TimsException ANSWERED_ERROR: the stream has ended; MALFORMED
   */
  public final Optional<D> decodeStream(Message message) throws TimsException {
    if (message.src() != component()) return Optional.empty();
    if (message.type() == Type.ERROR)
      throw new TimsException(Code.ANSWERED_ERROR, Address.format(component())
          + " ended its stream (off, or failed): subscribe again when it is on");
    return message.type() == Type.DATA ? Optional.of(decoded(Type.DATA, made.get(), message)) : Optional.empty();
  }
}
