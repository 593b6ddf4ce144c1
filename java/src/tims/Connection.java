package tims;

import java.io.IOException;

/** One connection to a router: it carries whole messages. It is used once, and ends once. */
interface Connection {
  /** What a connection reports, from a thread of its own, one call at a time. */
  interface Listener {
    void received(byte[] message);

    /** The router gave a sign of life that is no message. */
    void alive();

    /** The last call. */
    void ended(String why);
  }

  /** Returns when the router has accepted it. */
  void open(Listener listener) throws IOException;

  /** May be called by any thread. */
  void send(byte[] message) throws IOException;

  void close();
}
