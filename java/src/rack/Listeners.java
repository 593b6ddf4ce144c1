package rack;

import java.util.ArrayList;
import java.util.List;
import tims.Header;

/** Who gets which data sets: every n-th, or the next one only. Pure; not safe for several threads. */
final class Listeners {
  /** `request`: its priority and sequence number are those of the data. */
  private record Listener(int mailbox, Header request, long reduction, boolean once) {}

  private final int most;
  private final List<Listener> all = new ArrayList<>();
  private long count;

  Listeners(int most) {
    this.most = most;
  }

  /** Every n-th data set with a period of `wanted` ms of data with a period of `own` ms. */
  static long reduction(long wanted, long own) {
    return wanted < own ? 1 : wanted / own;
  }

  /** A mailbox that listens already has its request replaced. */
  void add(int mailbox, Header request, long reduction, boolean once) throws Refused {
    boolean again = all.removeIf(each -> each.mailbox() == mailbox);
    if (!again && all.size() == most) throw new Refused("it has " + most + " listeners already");
    all.add(new Listener(mailbox, request, reduction, once));
  }

  void remove(int mailbox) {
    all.removeIf(each -> each.mailbox() == mailbox);
  }

  /** Counts a data set; the headers of the messages to its receivers. */
  List<Header> due(int type, int flags) {
    ++count;
    List<Header> headers = new ArrayList<>();
    for (Listener each : all)
      if (count % each.reduction() == 0) headers.add(header(each, type, flags));
    all.removeIf(Listener::once);
    return headers;
  }

  /** Removes all; the headers of messages to them. */
  List<Header> clear(int type) {
    List<Header> headers = new ArrayList<>();
    for (Listener each : all) headers.add(header(each, type, 0));
    all.clear();
    count = 0;
    return headers;
  }

  private static Header header(Listener of, int type, int flags) {
    return new Header(of.mailbox(), 0, type, of.request().priority(), of.request().seqNr(), flags);
  }
}
