package rack;

import java.util.ArrayDeque;
import java.util.Deque;

/** The last data sets of a component, by their times: ms, modulo 2^32. Pure; not safe for several threads. */
final class DataHistory {
  record Entry(int time, byte[] body) {}

  private final int size;
  private final Deque<Entry> entries = new ArrayDeque<>();

  DataHistory(int size) {
    this.size = size;
  }

  void add(int time, byte[] body) {
    if (entries.size() == size) entries.removeFirst();
    entries.addLast(new Entry(time, body));
  }

  void clear() {
    entries.clear();
  }

  boolean isEmpty() {
    return entries.isEmpty();
  }

  /**
   * The body recorded nearest to that time, of two the later; 0: the newest. Its data may be two periods older.
   *
   * @throws Refused there are none of that time
   */
  byte[] at(int time, int period) throws Refused {
    if (entries.isEmpty()) throw new Refused("there are no data yet");
    Entry newest = entries.getLast();
    if (time == 0) return newest.body();
    if (time - newest.time() > 2 * period)
      throw new Refused("data of this time are not yet available: the newest are " + (time - newest.time()) + " ms older");
    if (time - entries.getFirst().time() < 0)
      throw new Refused("data of this time are no longer available: the oldest are " + (entries.getFirst().time() - time) + " ms newer");
    Entry best = newest;
    for (Entry each : entries)
      if (Math.abs(each.time() - time) <= Math.abs(best.time() - time)) best = each;
    return best.body();
  }
}
