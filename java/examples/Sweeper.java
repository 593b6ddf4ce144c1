import rack.DataModule;
import rack.Parameters;
import rack.messages.LadarData;
import rack.messages.LadarPoint;
import rack.messages.LadarProxy;

/** A simulated ladar in a round room: a component like any other. */
public final class Sweeper extends DataModule<LadarData> {
  private Sweeper() {
    super("Sweeper", LadarProxy.CLASS_ID,
        Parameters.integer("period", 100, "period of the data [ms]", 10, 60000),
        Parameters.integer("radius", 3000, "radius of the room [mm]", 100, 30000));
  }

  @Override
  protected String purpose() {
    return "Scans a round room.";
  }

  @Override
  protected void moduleOn() {
    setPeriod(integer("period"));
  }

  @Override
  protected void moduleLoop() throws InterruptedException {
    sleepUntilNext();
    LadarData scan = new LadarData();
    scan.recordingTime = timeStamp();
    scan.duration = period();
    scan.maxRange = 30000;
    for (int degrees = -90; degrees <= 90; ++degrees) {
      LadarPoint point = new LadarPoint();
      point.angle = (float) Math.toRadians(degrees);
      point.distance = integer("radius");
      scan.points.add(point);
    }
    scan.startAngle = scan.points.get(0).angle;
    scan.endAngle = scan.points.get(180).angle;
    put(scan);
  }

  public static void main(String[] arguments) {
    System.exit(new Sweeper().run(arguments));
  }
}
