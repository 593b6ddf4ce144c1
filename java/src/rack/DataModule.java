package rack;

import java.nio.ByteBuffer;
import java.util.List;
import rack.messages.ContDataReply;
import rack.messages.GetContDataRequest;
import rack.messages.GetDataRequest;
import rack.messages.StopContDataRequest;
import tims.Flag;
import tims.Header;
import tims.Message;
import tims.Type;

/** A component that publishes data: it is on when the first data are there. */
public abstract class DataModule<D extends Struct> extends Module {
  private static final int HISTORY = 10;
  private static final int LISTENERS = 64;

  private final DataHistory history = new DataHistory(HISTORY);
  private final Listeners listeners = new Listeners(LISTENERS);
  private final Object lock = new Object(); // of both
  private volatile int period = 1000;
  private long wakeAt; // ns

  protected DataModule(String program, int classId, Parameters.Row... rows) {
    super(program, classId, rows);
  }

  /** The wall clock as data state it: ms, modulo 2^32. */
  public static long timeStamp() {
    return System.currentTimeMillis() & 0xffffffffL;
  }

  /** In moduleOn: of the data, ms, 1 or more. */
  protected final void setPeriod(int milliseconds) {
    if (milliseconds < 1) throw new IllegalArgumentException("the period is " + milliseconds + " ms: expected 1 or more");
    period = milliseconds;
  }

  protected final int period() {
    return period;
  }

  /** In moduleLoop: sleeps until the next multiple of the period since ON; missed ones are skipped. */
  protected final void sleepUntilNext() throws InterruptedException {
    long step = period * 1_000_000L;
    long now = System.nanoTime();
    wakeAt += step * Math.max(1, Math.floorDiv(now - wakeAt, step) + 1);
    while (!stops() && wakeAt - System.nanoTime() > 0)
      Thread.sleep(Math.min((wakeAt - System.nanoTime() + 999_999) / 1_000_000, 100));
  }

  /** In moduleLoop: keeps data, and sends them to the listeners. Their first field is the time of recording. */
  protected final void put(D data) {
    byte[] body = data.encode();
    List<Header> receivers;
    synchronized (lock) {
      history.add(ByteBuffer.wrap(body).getInt(), body);
      receivers = listeners.due(Type.DATA, Flag.STREAM);
    }
    for (Header each : receivers) send(each, body);
  }

  @Override
  final boolean hasData() {
    return true;
  }

  @Override
  final void begin() throws Exception {
    synchronized (lock) {
      history.clear();
    }
    wakeAt = System.nanoTime();
    while (isWanted()) {
      moduleLoop();
      synchronized (lock) {
        if (!history.isEmpty()) return;
      }
    }
    throw new Refused("it was turned off before its first data");
  }

  @Override
  final void end() {
    List<Header> left;
    synchronized (lock) {
      left = listeners.clear(Type.ERROR);
    }
    for (Header each : left) send(each, new byte[0]);
  }

  @Override
  final boolean dataCommand(Message command) throws Exception {
    switch (command.type()) {
      case Type.GET_DATA -> getData(command);
      case Type.GET_NEXT_DATA -> listen(command, command.src(), 1, true);
      case Type.GET_CONT_DATA -> getContData(command);
      case Type.STOP_CONT_DATA -> {
        synchronized (lock) {
          listeners.remove(StopContDataRequest.decode(command).dataMbxAdr);
        }
        reply(command, Type.OK);
      }
      default -> {
        return false;
      }
    }
    return true;
  }

  private void getData(Message command) throws Exception {
    checkOn();
    int time = (int) GetDataRequest.decode(command).recordingTime;
    byte[] body;
    synchronized (lock) {
      body = history.at(time, period);
    }
    Header request = command.header();
    send(new Header(request.src(), 0, Type.DATA, request.priority(), request.seqNr(), 0), body);
  }

  private void getContData(Message command) throws Exception {
    GetContDataRequest request = GetContDataRequest.decode(command);
    long reduction = Listeners.reduction(request.periodTime, period);
    ContDataReply granted = new ContDataReply();
    granted.periodTime = reduction * period;
    listen(command, request.dataMbxAdr, reduction, false);
    reply(command, Type.CONT_DATA, granted);
  }

  private void listen(Message command, int mailbox, long reduction, boolean once) throws Refused {
    checkOn();
    synchronized (lock) {
      listeners.add(mailbox, command.header(), reduction, once);
    }
  }

  private void checkOn() throws Refused {
    if (!isOn()) throw new Refused("it is off");
  }
}
