package tims;

import java.io.BufferedInputStream;
import java.io.DataInputStream;
import java.io.EOFException;
import java.io.IOException;
import java.io.OutputStream;
import java.net.InetSocketAddress;
import java.net.Socket;
import java.util.Arrays;

/** The protocol of the original: messages one behind the other. */
final class TcpConnection implements Connection {
  private static final int CONNECT_TIME = 5000; // ms

  private final InetSocketAddress router;
  private final int messageMax;
  private final Socket socket = new Socket();
  private OutputStream out;

  TcpConnection(InetSocketAddress router, int messageMax) {
    this.router = router;
    this.messageMax = messageMax;
  }

  @Override
  public void open(Listener listener) throws IOException {
    // The name is looked up for each connection: a router may have moved.
    socket.connect(new InetSocketAddress(router.getHostString(), router.getPort()), CONNECT_TIME);
    socket.setTcpNoDelay(true);
    out = socket.getOutputStream();
    DataInputStream in = new DataInputStream(new BufferedInputStream(socket.getInputStream(), 1 << 16));
    Thread reader = new Thread(() -> read(in, listener), "tims-tcp");
    reader.setDaemon(true);
    reader.start();
  }

  private void read(DataInputStream in, Listener listener) {
    String why;
    try {
      for (;;) listener.received(next(in));
    } catch (EOFException error) {
      why = "the router closed the connection";
    } catch (IOException error) {
      why = error.getMessage();
    }
    close();
    listener.ended(why);
  }

  private byte[] next(DataInputStream in) throws IOException {
    byte[] header = new byte[Header.SIZE];
    in.readFully(header);
    long length = Header.length(header);
    if (length < Header.SIZE || length > messageMax)
      throw new IOException("the router sent a message of " + length + " bytes, allowed are 16 to " + messageMax);
    byte[] message = Arrays.copyOf(header, (int) length);
    in.readFully(message, Header.SIZE, message.length - Header.SIZE);
    return message;
  }

  @Override
  public synchronized void send(byte[] message) throws IOException {
    out.write(message);
  }

  @Override
  public void close() {
    try {
      socket.close();
    } catch (IOException error) {
      // It is closed in any case.
    }
  }
}
