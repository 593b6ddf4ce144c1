import java.io.DataInputStream;
import java.io.EOFException;
import java.io.IOException;
import java.net.InetAddress;
import java.net.ServerSocket;
import java.net.Socket;
import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;
import rack.Module;
import tims.Mailbox;
import tims.Session;
import tims.TimsException;

/** The client against routers that a test plays, in a socket: they end a connection, or do not answer. */
public final class FakeRouterTest {
  private static final Duration PATIENCE = Duration.ofSeconds(60);
  private static final int INIT = 13;
  private static final int DELETE = 12;

  private FakeRouterTest() {}

  public static void main(String[] arguments) throws Exception {
    connectionsThatEndAtOnce();
    missingAnswer();
    interruptedComponent();
  }

  private static void check(boolean holds, String what) {
    if (!holds) throw new AssertionError("not so: " + what);
  }

  private static ServerSocket listen() throws IOException {
    return new ServerSocket(0, 50, InetAddress.getLoopbackAddress());
  }

  private static Session.Options options(ServerSocket router) {
    return new Session.Options("127.0.0.1:" + router.getLocalPort()).silence(Duration.ofHours(1)).timeout(PATIENCE).events(text -> {});
  }

  /** Each is followed by another one: none counts as connected until the router has been silent for an hour. */
  private static void connectionsThatEndAtOnce() throws Exception {
    try (ServerSocket router = listen()) {
      CountDownLatch connections = new CountDownLatch(40);
      Thread ends = new Thread(() -> {
        try {
          for (;;) {
            router.accept().close();
            connections.countDown();
          }
        } catch (IOException error) {
          // The test is over.
        }
      });
      ends.start();
      List<Thread> clients = new ArrayList<>();
      for (int i = 0; i < 10; ++i) {
        Thread client = new Thread(() -> {
          try (Session session = Session.connect(options(router))) {
            session.awaitConnected(PATIENCE);
            connections.await();
          } catch (TimsException | InterruptedException error) {
            // It never was connected for long enough to be noticed.
          }
        });
        client.start();
        clients.add(client);
      }
      check(connections.await(PATIENCE.toSeconds(), TimeUnit.SECONDS), "it connects again, still awaited: " + connections.getCount());
      for (Thread client : clients) client.interrupt();
      for (Thread client : clients) client.join();
    }
  }

  /** A router may take an address after its program has given up: so it is told. */
  private static void missingAnswer() throws Exception {
    try (ServerSocket router = listen(); Session session = Session.connect(options(router)); Socket client = router.accept()) {
      try (Mailbox mailbox = session.open("Tool(0/7)", 4, 100)) {
        throw new AssertionError("it was opened: " + mailbox.address());
      } catch (TimsException error) {
        check(error.code() == TimsException.Code.NO_ROUTER, error.getMessage());
      }
      DataInputStream in = new DataInputStream(client.getInputStream());
      byte[] asked = message(in);
      byte[] withdrawn = message(in);
      check(asked[1] == INIT && withdrawn[1] == DELETE, "types " + asked[1] + ", " + withdrawn[1]);
      check(ByteBuffer.wrap(asked).getInt(16) == ByteBuffer.wrap(withdrawn).getInt(16), "the address is withdrawn");
    }
  }

  private static byte[] message(DataInputStream in) throws IOException {
    byte[] header = new byte[16];
    in.readFully(header);
    byte[] whole = java.util.Arrays.copyOf(header, ByteBuffer.wrap(header).getInt(12));
    in.readFully(whole, 16, whole.length - 16);
    return whole;
  }

  private static final class Idle extends Module {
    private final LinkedBlockingQueue<String> calls = new LinkedBlockingQueue<>();

    Idle() {
      super("Idle", 0x70);
    }

    @Override
    protected void moduleInit() {
      calls.add("init");
    }

    @Override
    protected void moduleLoop() {}

    @Override
    protected void moduleCleanup() {
      calls.add("cleanup");
    }
  }

  /** A component whose thread is interrupted while it is off ends, and its command task with it. */
  private static void interruptedComponent() throws Exception {
    try (ServerSocket router = listen()) {
      Thread answers = new Thread(() -> accept(router));
      answers.start();
      Idle component = new Idle();
      Thread main = new Thread(() -> component.run("--router", "127.0.0.1:" + router.getLocalPort()));
      main.start();
      check("init".equals(component.calls.poll(PATIENCE.toSeconds(), TimeUnit.SECONDS)), "it starts");
      main.interrupt();
      check("cleanup".equals(component.calls.poll(PATIENCE.toSeconds(), TimeUnit.SECONDS)), "it ends");
      main.join();
      answers.join();
    }
  }

  /** Accepts each address of one client. */
  private static void accept(ServerSocket router) {
    try (Socket client = router.accept()) {
      DataInputStream in = new DataInputStream(client.getInputStream());
      for (;;) {
        byte[] asked = message(in);
        if (asked[1] != INIT) continue;
        ByteBuffer answer = ByteBuffer.allocate(16).put((byte) 0).put((byte) 0).put(asked[2]).put(asked[3]);
        client.getOutputStream().write(answer.putInt(0).putInt(0).putInt(16).array());
      }
    } catch (EOFException error) {
      // The component has ended.
    } catch (IOException error) {
      throw new AssertionError(error);
    }
  }
}
