package rack;

/** A component cannot do what it shall: the text is the reason that the sender of the command gets. */
public final class Refused extends Exception {
  private static final long serialVersionUID = 1;

  public Refused(String reason) {
    super(reason);
  }
}
