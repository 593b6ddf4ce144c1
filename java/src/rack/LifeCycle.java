package rack;

import java.util.ArrayList;
import java.util.List;
import java.util.OptionalInt;
import tims.Header;
import tims.Type;

/**
 * The life cycle of a component: its next step, and the answers to ON and OFF. A step that fails puts it into the error
 * state; it is tried again after some seconds until it succeeds or is turned off.
 *
 * <p>Pure: time comes in as nanoseconds. Not safe for several threads; {@link Module} locks.
 */
final class LifeCycle {
  enum Step {
    WAIT,
    TURN_ON,
    LOOP,
    TURN_OFF
  }

  private enum State {
    OFF,
    ON,
    ERROR
  }

  private static final int WAITING_MAX = 32; // requests of ON

  private final List<Header> waiting = new ArrayList<>();
  private State state = State.OFF;
  private boolean wantsOn;
  private long retryAt;

  /** ON: the type of an immediate answer; empty: it is answered by the result of the next step. */
  OptionalInt turnOn(long now, Header request) {
    if (state == State.ON && wantsOn) return OptionalInt.of(Type.OK);
    if (waiting.size() == WAITING_MAX) return OptionalInt.of(Type.ERROR);
    wantsOn = true;
    retryAt = now;
    waiting.add(request);
    return OptionalInt.empty();
  }

  /** At the start of the program. */
  void turnOn() {
    wantsOn = true;
  }

  /** OFF is answered OK at once; returns the requests of ON that are to be answered ERROR. */
  List<Header> turnOff() {
    wantsOn = false;
    return takeWaiting();
  }

  Step next(long now) {
    if (state == State.ON) return wantsOn ? Step.LOOP : Step.TURN_OFF;
    if (!wantsOn) return state == State.ERROR ? Step.TURN_OFF : Step.WAIT;
    return state == State.OFF || now - retryAt >= 0 ? Step.TURN_ON : Step.WAIT;
  }

  /** A step succeeded; returns the requests of ON that are to be answered OK. */
  List<Header> succeeded(Step step) {
    state = step == Step.TURN_OFF ? State.OFF : State.ON;
    return state == State.ON ? takeWaiting() : List.of();
  }

  /** TURN_ON or LOOP failed; returns the requests of ON that are to be answered ERROR. */
  List<Header> failed(long now, long retryAfter) {
    state = wantsOn ? State.ERROR : State.OFF;
    retryAt = now + retryAfter;
    return takeWaiting();
  }

  boolean isOn() {
    return state == State.ON;
  }

  boolean wantsOn() {
    return wantsOn;
  }

  /** What GET_STATUS reports. */
  int status() {
    return state == State.ON ? Type.ENABLED : state == State.OFF ? Type.DISABLED : Type.ERROR;
  }

  private List<Header> takeWaiting() {
    List<Header> taken = List.copyOf(waiting);
    waiting.clear();
    return taken;
  }
}
