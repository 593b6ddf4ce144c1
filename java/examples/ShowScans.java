import java.time.Duration;
import rack.messages.LadarData;
import rack.messages.LadarPoint;
import rack.messages.LadarProxy;
import tims.Mailbox;
import tims.Message;
import tims.Session;

/** ShowScans ROUTER COUNT: turns Ladar(0/0) on, and prints the nearest point of each scan. */
public final class ShowScans {
  private ShowScans() {}

  public static void main(String[] arguments) throws Exception {
    int count = Integer.parseInt(arguments[1]);
    try (Session session = Session.connect(arguments[0]);
        Mailbox work = session.open("Tool(0/60)", 4, 65536);
        Mailbox scans = session.open("Tool(0/60):1", 2, 65536)) {
      LadarProxy ladar = new LadarProxy(work, "Ladar(0/0)");
      ladar.on();
      ladar.subscribe(scans, 0);
      while (count > 0) {
        Message message = scans.receive(Duration.ofSeconds(5));
        if (ladar.decodeStream(message).isEmpty()) continue;
        show(ladar.decodeStream(message).get());
        --count;
      }
      ladar.unsubscribe(scans);
    }
  }

  private static void show(LadarData scan) {
    LadarPoint nearest = scan.points.get(0);
    for (LadarPoint each : scan.points) if (each.distance < nearest.distance) nearest = each;
    System.out.printf("%d points, nearest at %d mm, %.2f rad%n", scan.points.size(), nearest.distance, nearest.angle);
  }
}
