package tims;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.net.URI;
import java.net.http.HttpClient;
import java.net.http.WebSocket;
import java.nio.ByteBuffer;
import java.time.Duration;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;
import java.util.concurrent.CompletionStage;
import java.util.concurrent.atomic.AtomicBoolean;
import javax.net.ssl.SSLContext;

/** The router's HTTP port: one binary message of the WebSocket is one message. */
final class WebSocketConnection implements Connection {
  private static final Duration CONNECT_TIME = Duration.ofSeconds(5);

  private final URI router;
  private final int messageMax;
  private final SSLContext tls;
  private final String bearer;
  private WebSocket socket;

  WebSocketConnection(URI router, int messageMax, SSLContext tls, String bearer) {
    this.router = router;
    this.messageMax = messageMax;
    this.tls = tls;
    this.bearer = bearer;
  }

  @Override
  public void open(Listener listener) throws IOException {
    HttpClient.Builder client = HttpClient.newBuilder().connectTimeout(CONNECT_TIME);
    if (tls != null) client.sslContext(tls);
    WebSocket.Builder builder = client.build().newWebSocketBuilder().connectTimeout(CONNECT_TIME);
    if (bearer != null) builder.header("Authorization", "Bearer " + bearer);
    try {
      socket = builder.buildAsync(router, new Reader(listener)).join();
    } catch (CompletionException error) {
      throw new IOException(reason(error.getCause()), error.getCause());
    }
  }

  private static String reason(Throwable error) {
    return error.getMessage() == null ? error.getClass().getSimpleName() : error.getMessage();
  }

  @Override
  public synchronized void send(byte[] message) throws IOException {
    try {
      socket.sendBinary(ByteBuffer.wrap(message), true).join();
    } catch (CompletionException error) {
      throw new IOException(reason(error.getCause()), error.getCause());
    }
  }

  @Override
  public void close() {
    if (socket != null) socket.abort();
  }

  private final class Reader implements WebSocket.Listener {
    private final Listener listener;
    private final ByteArrayOutputStream parts = new ByteArrayOutputStream();
    private final AtomicBoolean ended = new AtomicBoolean();

    Reader(Listener listener) {
      this.listener = listener;
    }

    @Override
    public CompletionStage<?> onBinary(WebSocket from, ByteBuffer data, boolean last) {
      byte[] bytes = new byte[data.remaining()];
      data.get(bytes);
      if (parts.size() + bytes.length > messageMax) return end(from, "the router sent a message above " + messageMax + " bytes");
      parts.writeBytes(bytes);
      if (last) {
        byte[] message = parts.toByteArray();
        parts.reset();
        if (message.length < Header.SIZE || Header.length(message) != message.length)
          return end(from, "the router sent a message of a wrong length");
        listener.received(message);
      }
      from.request(1);
      return null;
    }

    @Override
    public CompletionStage<?> onPing(WebSocket from, ByteBuffer data) { // it is answered by the HttpClient
      listener.alive();
      from.request(1);
      return null;
    }

    @Override
    public CompletionStage<?> onClose(WebSocket from, int code, String why) {
      return end(from, why.isEmpty() ? "the router closed the connection (" + code + ")" : why);
    }

    @Override
    public void onError(WebSocket from, Throwable error) {
      end(from, reason(error));
    }

    private CompletionStage<?> end(WebSocket from, String why) {
      from.abort();
      if (ended.compareAndSet(false, true)) listener.ended(why);
      return CompletableFuture.completedStage(null);
    }
  }
}
