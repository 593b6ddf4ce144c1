package tims;

import java.io.IOException;
import java.time.Duration;
import java.util.TreeMap;

/**
 * Where messages are sent from and received. It holds a number of messages; a full one drops its oldest message of the
 * lowest priority for one that is not less important, as every mailbox of RACK. Any thread may use it.
 */
public final class Mailbox implements AutoCloseable {
  /** Sorted as they are received: higher priority first, then arrival. */
  private record Place(int priority, long arrival) implements Comparable<Place> {
    @Override
    public int compareTo(Place other) {
      return priority != other.priority
          ? Integer.compare(other.priority, priority)
          : Long.compare(arrival, other.arrival);
    }
  }

  /** Since it was opened. */
  public record Counters(long received, long replaced, long refused, long tooBig) {}

  private final Session session;
  private final int address;
  private final int slots;
  private final int bodyMax;
  private final TreeMap<Place, Message> waiting = new TreeMap<>();
  private long arrivals;
  private long received;
  private long replaced;
  private long refused;
  private long tooBig;
  private boolean closed;

  Mailbox(Session session, int address, int slots, int bodyMax) {
    if (slots < 1 || slots > 65535) throw new IllegalArgumentException("a mailbox has 1 to 65535 slots, not " + slots);
    if (bodyMax < 0) throw new IllegalArgumentException("the largest body has " + bodyMax + " bytes: expected 0 or more");
    this.session = session;
    this.address = address;
    this.slots = slots;
    this.bodyMax = bodyMax;
  }

  public int address() {
    return address;
  }

  public Session session() {
    return session;
  }

  /** Bytes of the largest body that it accepts. */
  public int bodyMax() {
    return bodyMax;
  }

  /**
   * Sends a body in the byte order that the header's flags state. If no mailbox has the address, the router answers a
   * command with {@link Type#NOT_AVAILABLE}.
   *
   * @throws TimsException CLOSED, NO_ROUTER: there is no connection now; TOO_BIG: the router would end the connection
   */
  public void send(Header header, byte[] body) throws TimsException {
    synchronized (this) {
      if (closed) throw closedError();
    }
    session.send(header.withSrc(address), body);
  }

  public void send(int dest, int type, byte[] body) throws TimsException {
    send(Header.to(dest, type), body);
  }

  public void send(int dest, int type) throws TimsException {
    send(Header.to(dest, type), new byte[0]);
  }

  /** Sends to the sender of a message, with its priority and sequence number, a body in big endian. */
  public void reply(Header request, int type, byte[] body) throws TimsException {
    send(new Header(request.src(), address, type, request.priority(), request.seqNr(), 0), body);
  }

  /**
   * Waits for a message; takes the oldest of the highest priority.
   *
   * @param timeout zero: does not wait
   * @throws TimsException TIMEOUT, CLOSED
   */
  public synchronized Message receive(Duration timeout) throws TimsException, InterruptedException {
    long end = System.nanoTime() + timeout.toNanos();
    for (;;) {
      if (closed) throw closedError();
      if (!waiting.isEmpty()) {
        ++received;
        return waiting.pollFirstEntry().getValue();
      }
      long left = (end - System.nanoTime() + 999_999) / 1_000_000;
      if (left <= 0)
        throw new TimsException(TimsException.Code.TIMEOUT, Address.format(address) + ": no message in " + timeout.toMillis() + " ms");
      wait(left);
    }
  }

  /** Discards every waiting message; returns their number. */
  public synchronized int clean() {
    int count = waiting.size();
    waiting.clear();
    return count;
  }

  public synchronized Counters counters() {
    return new Counters(received, replaced, refused, tooBig);
  }

  /** Messages in it are lost, and calls that wait end with CLOSED. */
  @Override
  public void close() {
    synchronized (this) {
      if (closed) return;
      closed = true;
      waiting.clear();
      notifyAll();
    }
    session.closed(this);
  }

  synchronized void deliver(Message message) {
    if (closed) return;
    if (message.bodySize() > bodyMax) {
      ++tooBig;
      return;
    }
    Place place = new Place(message.header().priority(), arrivals++);
    if (waiting.size() == slots && !makeRoom(place.priority())) return;
    waiting.put(place, message);
    notify();
  }

  private boolean makeRoom(int priority) {
    int lowest = waiting.lastKey().priority();
    if (lowest > priority) {
      ++refused;
      return false;
    }
    waiting.remove(waiting.ceilingKey(new Place(lowest, 0)));
    ++replaced;
    return true;
  }

  private TimsException closedError() {
    return new TimsException(TimsException.Code.CLOSED, Address.format(address) + " is closed: open it again");
  }
}
